//! Maximum intensity projection.

use super::State;
use crate::lanes::{F32s, Mask};
use crate::library::classify::Table;

/// The state of a ray without samples.
pub const START: f32 = f32::NEG_INFINITY;

/// Keeps the largest value.
#[inline(always)]
pub fn add(state: &mut State, sampled: Mask, value: F32s) {
    state.value = sampled.select(value.max(state.value), state.value);
    state.number = sampled.select(F32s::splat(1.0), state.number);
}

/// Classifies it.
#[inline(always)]
pub fn finish(state: State, table: &Table) -> State {
    state.finish_value(table, state.value)
}
