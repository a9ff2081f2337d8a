//! The mean along the ray: what an X-ray film would show of a linear detector.

use super::state::State;
use crate::lanes::{F32s, Mask};
use crate::levels::Level;

/// Adds up, with W. Kahan's compensation, as thousands of samples of the same size would each lose
/// their last bits.
#[inline(always)]
pub fn add<S: Level>(state: &mut State<S>, sampled: Mask<S>, value: F32s<S>) {
    let term = value - state.lost;
    let sum = state.value + term;
    let lost = (sum - state.value) - term;
    // An infinite sum stays infinite instead of becoming NaN.
    let finite = lost.is_finite();
    state.value = sampled.select(sum, state.value);
    state.lost = (sampled & finite).select(lost, state.lost);
    state.number = sampled.select(state.number + F32s::splat(1.0), state.number);
}

/// The mean.
#[inline(always)]
pub fn mean<S: Level>(state: &State<S>) -> F32s<S> {
    state.value.over(state.number.max(F32s::splat(1.0)))
}
