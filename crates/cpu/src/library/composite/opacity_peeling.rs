//! Opacity peeling (C. Rezk-Salama and A. Kolb 2006): emission and absorption that begins anew where the ray leaves
//! something opaque.

use super::emission_absorption::{self, EmissionAbsorption};
use super::rule::{Crossing, Rule, Sample};
use super::state::State;
use crate::lanes::{F32s, Mask};
use crate::levels::Level;
use crate::library::classify::Surface;

/// Of a [`State`] it uses `color` and `alpha` of the layer that the ray is in, `number`, which layer that is, `place`, the
/// lattice point of the last sample, and `value`, above 0 where the layer that is shown has ended.
#[derive(Clone, Copy)]
pub struct OpacityPeeling {
    pub layer: u32,
    pub opaque_above: f32,
    pub clear_below: f32,
    pub stop_at_transmittance: f32,
}

impl OpacityPeeling {
    /// The rays that are in the layer that is shown.
    #[inline(always)]
    fn in_layer<S: Level>(&self, state: &State<S>) -> Mask<S> {
        state.number.eq(F32s::splat(self.layer as f32))
    }
}

impl Rule for OpacityPeeling {
    #[inline(always)]
    fn add<S: Level>(&self, state: &mut State<S>, sample: &Sample<S>) -> Mask<S> {
        let look = sample.look(&mut state.last_normal);
        let Surface { color, opacity } = look.surface;
        let opacity = look.visible.select(opacity, F32s::zero());
        let object = sample.crossing.object;
        let clear = object.of_step(F32s::splat(self.clear_below));
        // Points that skipping or a clip has left out would have been clear.
        let is_clear = opacity.le(clear) | F32s::splat(1.5).lt(sample.k - state.place);
        let is_opaque = F32s::splat(self.opaque_above).lt(state.alpha);
        let ends = sample.sampled & is_clear & is_opaque;
        state.place = sample.sampled.select(sample.k, state.place);
        let has_ended = ends & self.in_layer(state);
        state.value = has_ended.select(F32s::splat(1.0), state.value);
        let peeled = ends & !has_ended;
        state.number = peeled.select(state.number + F32s::splat(1.0), state.number);
        state.color = peeled.select3([F32s::zero(); 3], state.color);
        state.alpha = peeled.select(F32s::zero(), state.alpha);
        let visible = look.visible & !has_ended;
        emission_absorption::add(state, visible, color, opacity);
        visible
    }

    #[inline(always)]
    fn done<S: Level>(&self, state: &State<S>) -> Mask<S> {
        let stop_at_transmittance = self.stop_at_transmittance;
        let opaque = EmissionAbsorption {
            stop_at_transmittance,
        }
        .done(state);
        F32s::zero().lt(state.value) | (opaque & self.in_layer(state))
    }

    #[inline(always)]
    fn finish<S: Level>(&self, state: &mut State<S>, _rays: &Crossing<S>) {
        let shown = self.in_layer(state);
        state.color = shown.select3(state.color, [F32s::zero(); 3]);
        state.alpha = shown.select(state.alpha, F32s::zero());
    }
}
