use super::surface::Surface;
use crate::lanes::{F32s, each};
use crate::levels::Level;

/// The value itself as grey and as opacity; NaN is nothing.
#[inline(always)]
pub fn at<S: Level>(value: F32s<S>, black: f32, white: f32) -> Surface<S> {
    let share = (value - F32s::splat(black)).over(F32s::splat(white - black));
    let grey = share.max(F32s::zero()).min(F32s::splat(1.0));
    Surface {
        colour: [grey; 3],
        opacity: grey,
    }
}

/// The same above a threshold, nothing up to it.
#[inline(always)]
pub fn above<S: Level>(value: F32s<S>, threshold: f32, black: f32, white: f32) -> Surface<S> {
    let above = F32s::splat(threshold).lt(value);
    let Surface { colour, opacity } = at(value, black, white);
    Surface {
        colour: each!(colour, |c| above.select(c, F32s::zero())),
        opacity: above.select(opacity, F32s::zero()),
    }
}
