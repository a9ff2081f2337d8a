use super::surface::Surface;
use crate::elementary::power_of_cosine;
use crate::lanes::{F32s, dot, each};
use crate::levels::Level;

/// B. Phong's model (1975): a highlight around the mirrored light 2(N·L)N − L.
#[inline(always)]
pub fn parts<S: Level>(
    surface: &Surface<S>,
    diffuse: f32,
    specular: f32,
    shininess: f32,
) -> (F32s<S>, F32s<S>) {
    let twice = surface.cosine + surface.cosine;
    let mirrored = each!([0, 1, 2], |i| {
        surface.normal[i] * twice - surface.to_light[i]
    });
    let cosine = dot(mirrored, surface.to_eye).max(F32s::zero());
    let power = power_of_cosine(cosine.min(F32s::splat(1.0)), shininess);
    (
        surface.cosine * F32s::splat(diffuse),
        power * F32s::splat(specular),
    )
}
