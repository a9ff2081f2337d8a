use super::surface::Surface;
use crate::lanes::F32s;
use crate::levels::Level;

/// Matt: brightness by the cosine of the angle to the light.
#[inline(always)]
pub fn parts<S: Level>(surface: &Surface<S>, diffuse: f32) -> (F32s<S>, F32s<S>) {
    (surface.cosine * F32s::splat(diffuse), F32s::zero())
}
