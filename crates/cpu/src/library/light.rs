//! Slot light: direction and strength of the light that reaches a place.

use crate::lanes::{F32s, Vec3s, dot, each, scale, splat3};
use crate::levels::Level;
use strahl_scene::plan::{Plan, PlanLight};

/// A light in single precision.
#[derive(Clone, Copy)]
pub enum Light {
    /// The same direction everywhere.
    Directional {
        to_light: [f32; 3],
        radiance: [f32; 3],
    },
    /// From a place; falls with the square of the distance.
    Point {
        place_mm: [f32; 3],
        reach_mm: f32,
        radiance: [f32; 3],
    },
    /// Along each ray.
    Head { radiance: [f32; 3] },
}

impl Light {
    /// The lights of `plan`.
    pub fn all(plan: &Plan) -> Vec<Light> {
        let single = |v: glam::DVec3| v.to_array().map(|v| v as f32);
        let light = |light: &PlanLight| match *light {
            PlanLight::Directional { to_light, radiance } => Light::Directional {
                to_light: single(to_light),
                radiance,
            },
            PlanLight::Point {
                place_mm,
                reach_mm,
                radiance,
            } => Light::Point {
                place_mm: single(place_mm),
                reach_mm,
                radiance,
            },
            PlanLight::Head { radiance } => Light::Head { radiance },
        };
        plan.lights.iter().map(light).collect()
    }

    /// Whether it matters where the lit place is.
    pub fn has_place(&self) -> bool {
        matches!(self, Light::Point { .. })
    }

    /// Unit vector towards the light, and linear RGB of what arrives at `place_mm`.
    #[inline(always)]
    pub fn at<S: Level>(&self, place_mm: Vec3s<S>, to_eye: Vec3s<S>) -> (Vec3s<S>, Vec3s<S>) {
        match *self {
            Light::Directional { to_light, radiance } => (splat3(to_light), splat3(radiance)),
            Light::Head { radiance } => (to_eye, splat3(radiance)),
            Light::Point {
                place_mm: lamp,
                reach_mm,
                radiance,
            } => {
                let lamp = splat3(lamp);
                let way = each!([0, 1, 2], |axis| lamp[axis] - place_mm[axis]);
                // At the lamp itself there is no direction and no end of brightness.
                let nearest = F32s::splat(0.001 * reach_mm);
                let distance = dot(way, way).sqrt().max(nearest);
                let fall = F32s::splat(reach_mm).over(distance);
                let direction = each!(way, |w| w.over(distance));
                (direction, scale(splat3(radiance), fall * fall))
            }
        }
    }
}
