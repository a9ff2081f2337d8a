//! Minimum intensity projection.

use super::state::State;
use crate::lanes::{F32s, Mask};
use crate::levels::Level;

/// The state of a ray without samples.
pub const START: f32 = f32::INFINITY;

/// Keeps the smallest value, and where it is first.
#[inline(always)]
pub fn add<S: Level>(state: &mut State<S>, sampled: Mask<S>, value: F32s<S>, place: F32s<S>) {
    let better = sampled & value.lt(state.value);
    state.keep(better, sampled, value, place);
}
