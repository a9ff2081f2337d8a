use super::surface::Surface;
use crate::elementary::power_of_cosine;
use crate::lanes::{F32s, along, dot, unit};
use crate::levels::Level;

/// As `blinn_phong`, with absolute values of both products.
#[inline(always)]
pub fn parts<S: Level>(
    surface: &Surface<S>,
    diffuse: f32,
    specular: f32,
    shininess: f32,
) -> (F32s<S>, F32s<S>) {
    let matt = dot(surface.normal, surface.to_light).abs() * F32s::splat(diffuse);
    if specular == 0.0 {
        return (matt, F32s::zero());
    }
    let between = along(surface.to_light, surface.to_eye, F32s::splat(1.0));
    let (half, has_half) = unit(between);
    let cosine = dot(surface.normal, half).abs().min(F32s::splat(1.0));
    let power = power_of_cosine(cosine, shininess);
    (
        matt,
        has_half.select(power * F32s::splat(specular), F32s::zero()),
    )
}
