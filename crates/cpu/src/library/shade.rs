//! Slot shade: the light that a sample sends to the eye.

mod blinn_phong;

pub use blinn_phong::BlinnPhong;

use crate::lanes::Vec3s;
use crate::library::illuminate::Light;
use strahl_scene::plan::{Plan, Shade};

/// How samples are shaded.
pub enum Shading {
    /// The surface colour, whatever the gradient.
    Unlit,
    /// See [`Shade::BlinnPhong`].
    BlinnPhong(BlinnPhong, Vec<Light>),
}

impl Shading {
    /// The shading of `plan`.
    pub fn new(plan: &Plan) -> Shading {
        match plan.shade {
            Shade::Unlit => Shading::Unlit,
            Shade::BlinnPhong {
                ambient,
                diffuse,
                specular,
                shininess,
            } => Shading::BlinnPhong(
                BlinnPhong {
                    ambient,
                    diffuse,
                    specular,
                    shininess,
                },
                Light::all(plan),
            ),
        }
    }

    /// The colour towards the eye; `gradient` is called only if it matters.
    #[inline(always)]
    pub fn colour(
        &self,
        surface: Vec3s,
        gradient: impl FnOnce() -> Vec3s,
        direction: Vec3s,
    ) -> Vec3s {
        match self {
            Shading::Unlit => surface,
            Shading::BlinnPhong(model, lights) => {
                model.colour(surface, gradient(), direction, lights)
            }
        }
    }
}
