use super::Surface;
use crate::lanes::F32s;

/// Matt: brightness by the cosine of the angle to the light.
#[inline(always)]
pub fn parts(surface: &Surface, diffuse: f32) -> (F32s, F32s) {
    (surface.cosine * F32s::splat(diffuse), F32s::ZERO)
}
