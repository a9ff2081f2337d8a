//! Slot illuminate: the light that a surface sends to the eye from one light.
//!
//! All vectors have length 1. Diffuse parts are multiplied by the surface colour, highlights are
//! white; there is nothing where the light comes from behind.

mod blinn_phong;
mod cook_torrance;
mod lambert;
mod phong;
mod surface;

use crate::lanes::{F32s, Vec3s, dot, each};
use crate::levels::Level;
use strahl_scene::plan::Illuminate;
use surface::Surface;

/// What one light does to a surface.
#[inline(always)]
pub fn illuminate<S: Level>(
    model: Illuminate,
    color: Vec3s<S>,
    normal: Vec3s<S>,
    to_eye: Vec3s<S>,
    to_light: Vec3s<S>,
    radiance: Vec3s<S>,
) -> Vec3s<S> {
    let cosine = dot(normal, to_light);
    let lit = F32s::zero().lt(cosine);
    let cosine = cosine.max(F32s::zero());
    let surface = Surface {
        normal,
        to_eye,
        to_light,
        cosine,
    };
    let (diffuse, highlight) = match model {
        Illuminate::Lambert { diffuse } => lambert::parts(&surface, diffuse),
        Illuminate::Phong {
            diffuse,
            specular,
            shininess,
        } => phong::parts(&surface, diffuse, specular, shininess),
        Illuminate::BlinnPhong {
            diffuse,
            specular,
            shininess,
        } => blinn_phong::parts(&surface, diffuse, specular, shininess),
        Illuminate::CookTorrance {
            diffuse,
            roughness,
            reflectance,
        } => cook_torrance::parts(&surface, diffuse, roughness, reflectance),
    };
    let highlight = lit.select(highlight, F32s::zero());
    each!([0, 1, 2], |c| {
        radiance[c] * (diffuse * color[c] + highlight)
    })
}
