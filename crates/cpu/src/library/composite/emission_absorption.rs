//! N. Max, "Optical models for direct volume rendering" (1995), front to back.

use super::State;
use crate::lanes::{F32s, Mask, Vec3s};

/// Adds what the eye sees of a sample: C += (1−A)·a·c, A += (1−A)·a.
#[inline(always)]
pub fn add(state: &mut State, visible: Mask, colour: Vec3s, opacity: F32s) {
    let share = (F32s::splat(1.0) - state.alpha) * opacity;
    let share = visible.select(share, F32s::ZERO);
    for (sum, channel) in state.colour.iter_mut().zip(colour) {
        // Selected once more: a colour may be infinite, and 0·∞ is NaN.
        *sum += visible.select(share * channel, F32s::ZERO);
    }
    state.alpha += share;
}

/// Adds a sample that lies in front of all before it: C = (1−a)·C + a·c, A likewise.
#[inline(always)]
pub fn add_in_front(state: &mut State, visible: Mask, colour: Vec3s, opacity: F32s) {
    let opacity = visible.select(opacity, F32s::ZERO);
    let behind = F32s::splat(1.0) - opacity;
    for (sum, channel) in state.colour.iter_mut().zip(colour) {
        *sum = *sum * behind + visible.select(opacity * channel, F32s::ZERO);
    }
    state.alpha = state.alpha * behind + opacity;
}

/// Where so little would still come through that the ray may end.
#[inline(always)]
pub fn done(state: &State, stop_at_transmittance: f32) -> Mask {
    (F32s::splat(1.0) - state.alpha).lt(F32s::splat(stop_at_transmittance))
}
