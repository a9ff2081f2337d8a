//! Minimum intensity projection.

use super::State;
use crate::lanes::{F32s, Mask};

/// The state of a ray without samples.
pub const START: f32 = f32::INFINITY;

/// Keeps the smallest value, and where it is first.
#[inline(always)]
pub fn add(state: &mut State, sampled: Mask, value: F32s, place: F32s) {
    let better = sampled & value.lt(state.value);
    state.keep(better, sampled, value, place);
}
