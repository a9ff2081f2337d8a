use super::place::Place;
use crate::lanes::{F32s, Vec3s, length};
use crate::levels::Level;
use crate::library::classify::Surface;

/// Unlit, with the opacity scaled by the steepness of the value.
#[inline(always)]
pub fn look<S: Level>(
    surface: Surface<S>,
    place: &Place<S, impl Fn() -> Vec3s<S>, impl Fn() -> Vec3s<S>>,
    full_per_mm: f32,
) -> Surface<S> {
    let part = length((place.gradient)()).over(F32s::splat(full_per_mm));
    Surface {
        opacity: surface.opacity * part.min(F32s::splat(1.0)),
        ..surface
    }
}
