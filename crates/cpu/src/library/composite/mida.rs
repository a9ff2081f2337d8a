//! Maximum intensity difference accumulation (S. Bruckner and E. Gröller 2009): where the ray meets
//! a value larger than all before, what lies in front fades by the difference.

use super::emission_absorption;
use super::state::State;
use crate::lanes::{F32s, Mask, Vec3s, each};
use crate::levels::Level;

/// Fades what was added by how much the share of the value, 0 to 1, rises over all before.
#[inline(always)]
pub fn fade<S: Level>(
    state: &mut State<S>,
    sampled: Mask<S>,
    value: F32s<S>,
    low: f32,
    high: f32,
    blend: f32,
) {
    let share = (value - F32s::splat(low)).over(F32s::splat(high - low));
    let share = share.max(F32s::zero()).min(F32s::splat(1.0));
    let rise = (share - state.value).max(F32s::zero());
    let kept = F32s::splat(1.0) - rise * F32s::splat(1.0 + blend);
    let kept = sampled.select(kept, F32s::splat(1.0));
    state.colour = each!(state.colour, |c| c * kept);
    state.alpha = state.alpha * kept;
    state.value = sampled.select(share.max(state.value), state.value);
}

/// Adds what the eye sees of a sample, as emission–absorption does.
#[inline(always)]
pub fn add<S: Level>(state: &mut State<S>, visible: Mask<S>, colour: Vec3s<S>, opacity: F32s<S>) {
    emission_absorption::add(state, visible, colour, opacity);
}

/// Where so little would still come through that the ray may end, and no larger value can come.
#[inline(always)]
pub fn done<S: Level>(state: &State<S>, stop_at_transmittance: f32, blend: f32) -> Mask<S> {
    let opaque = emission_absorption::done(state, stop_at_transmittance);
    if blend == -1.0 {
        return opaque;
    }
    opaque & F32s::splat(1.0).le(state.value)
}
