use super::surface::Surface;
use crate::elementary::power_of_cosine;
use crate::lanes::{F32s, along, dot, unit};
use crate::levels::Level;

/// J. Blinn's half-vector form of Phong's model (SIGGRAPH 1977).
#[inline(always)]
pub fn parts<S: Level>(
    surface: &Surface<S>,
    diffuse: f32,
    specular: f32,
    shininess: f32,
) -> (F32s<S>, F32s<S>) {
    let matt = surface.cosine * F32s::splat(diffuse);
    if specular == 0.0 {
        return (matt, F32s::zero());
    }
    // The half vector has no direction where the light comes exactly from behind: not lit there.
    let between = along(surface.to_light, surface.to_eye, F32s::splat(1.0));
    let (half, has_half) = unit(between);
    let cosine = dot(surface.normal, half).max(F32s::zero());
    let power = power_of_cosine(cosine.min(F32s::splat(1.0)), shininess);
    (
        matt,
        has_half.select(power * F32s::splat(specular), F32s::zero()),
    )
}
