//! Slot illuminate: from where and how strongly a sample is lit.

use crate::lanes::{F32s, Vec3s, splat3};
use strahl_scene::plan::{Plan, PlanLight};

/// A light in single precision.
#[derive(Clone, Copy)]
pub enum Light {
    /// The same direction everywhere.
    Directional {
        to_light: [f32; 3],
        radiance: [f32; 3],
    },
    /// Along each ray.
    Head { radiance: [f32; 3] },
}

impl Light {
    /// The lights of `plan`.
    pub fn all(plan: &Plan) -> Vec<Light> {
        let light = |light: &PlanLight| match *light {
            PlanLight::Directional { to_light, radiance } => Light::Directional {
                to_light: to_light.to_array().map(|v| v as f32),
                radiance,
            },
            PlanLight::Head { radiance } => Light::Head { radiance },
        };
        plan.lights.iter().map(light).collect()
    }

    /// Unit vector towards the light.
    #[inline(always)]
    pub fn direction(&self, to_eye: Vec3s) -> Vec3s {
        match *self {
            Light::Directional { to_light, .. } => splat3(to_light),
            Light::Head { .. } => to_eye,
        }
    }

    /// Linear RGB.
    #[inline(always)]
    pub fn radiance(&self) -> [F32s; 3] {
        match *self {
            Light::Directional { radiance, .. } | Light::Head { radiance } => splat3(radiance),
        }
    }
}
