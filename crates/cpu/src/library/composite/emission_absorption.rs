//! N. Max, "Optical models for direct volume rendering" (1995), front to back.

use super::state::State;
use crate::lanes::{F32s, Mask, Vec3s};
use crate::levels::Level;

/// Adds what the eye sees of a sample: C += (1−A)·a·c, A += (1−A)·a.
#[inline(always)]
pub fn add<S: Level>(state: &mut State<S>, visible: Mask<S>, colour: Vec3s<S>, opacity: F32s<S>) {
    let share = (F32s::splat(1.0) - state.alpha) * opacity;
    let share = visible.select(share, F32s::zero());
    for (sum, channel) in state.colour.iter_mut().zip(colour) {
        // Selected once more: a colour may be infinite, and 0·∞ is NaN.
        *sum += visible.select(share * channel, F32s::zero());
    }
    state.alpha += share;
}

/// Adds a sample that lies in front of all before it: C = (1−a)·C + a·c, A likewise.
#[inline(always)]
pub fn add_in_front<S: Level>(
    state: &mut State<S>,
    visible: Mask<S>,
    colour: Vec3s<S>,
    opacity: F32s<S>,
) {
    let opacity = visible.select(opacity, F32s::zero());
    let behind = F32s::splat(1.0) - opacity;
    for (sum, channel) in state.colour.iter_mut().zip(colour) {
        *sum = *sum * behind + visible.select(opacity * channel, F32s::zero());
    }
    state.alpha = state.alpha * behind + opacity;
}

/// Where so little would still come through that the ray may end.
#[inline(always)]
pub fn done<S: Level>(state: &State<S>, stop_at_transmittance: f32) -> Mask<S> {
    (F32s::splat(1.0) - state.alpha).lt(F32s::splat(stop_at_transmittance))
}
