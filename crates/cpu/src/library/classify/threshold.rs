use super::identity;
use super::sample::Sample;
use super::surface::Surface;
use crate::lanes::{F32s, each};
use crate::levels::Level;

/// The value itself as gray and as opacity above a threshold, nothing up to it.
#[inline(always)]
pub fn surface<S: Level>(sample: &Sample<S>, threshold: f32, black: f32, white: f32) -> Surface<S> {
    let above = F32s::splat(threshold).lt(sample.value);
    let Surface { color, opacity } = identity::surface(sample, black, white);
    Surface {
        color: each!(color, |c| above.select(c, F32s::zero())),
        opacity: above.select(opacity, F32s::zero()),
    }
}
