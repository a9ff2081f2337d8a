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
    let shiny = highlight(
        surface,
        specular,
        shininess,
        #[inline(always)]
        |cosine| cosine.max(F32s::zero()),
    );
    (matt, shiny)
}

/// The specular part, by what `seen` makes of the cosine between normal and half vector.
#[inline(always)]
pub(super) fn highlight<S: Level>(
    surface: &Surface<S>,
    specular: f32,
    shininess: f32,
    seen: impl Fn(F32s<S>) -> F32s<S>,
) -> F32s<S> {
    if specular == 0.0 {
        return F32s::zero();
    }
    // The half vector has no direction where the light comes exactly from behind: not lit there.
    let between = along(surface.to_light, surface.to_eye, F32s::splat(1.0));
    let (half, has_half) = unit(between);
    let cosine = seen(dot(surface.normal, half));
    let power = power_of_cosine(cosine.min(F32s::splat(1.0)), shininess);
    has_half.select(power * F32s::splat(specular), F32s::zero())
}
