use super::sample::Sample;
use super::surface::Surface;
use crate::lanes::F32s;
use crate::levels::Level;

/// The value itself as gray and as opacity; NaN is nothing.
#[inline(always)]
pub fn surface<S: Level>(sample: &Sample<S>, black: f32, white: f32) -> Surface<S> {
    let share = (sample.value - F32s::splat(black)).over(F32s::splat(white - black));
    let grey = share.max(F32s::zero()).min(F32s::splat(1.0));
    Surface {
        color: [grey; 3],
        opacity: grey,
    }
}
