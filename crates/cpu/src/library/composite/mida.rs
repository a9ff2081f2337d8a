//! Maximum intensity difference accumulation (S. Bruckner and E. Gröller 2009): where the ray meets
//! a value larger than all before, what lies in front fades by the difference.

use super::emission_absorption::{self, EmissionAbsorption};
use super::rule::{Crossing, Rule, Sample};
use super::state::State;
use crate::lanes::{F32s, Mask, each};
use crate::levels::Level;

/// Emission–absorption (`blend` −1), the method itself (0), the largest value alone (1), and what lies between.
#[derive(Clone, Copy)]
pub struct Mida {
    /// The value that counts as 0 …
    pub low: f32,
    /// … and as 1.
    pub high: f32,
    pub blend: f32,
    pub stop_at_transmittance: f32,
}

impl Mida {
    /// Fades what was added by how much the share of the value, 0 to 1, rises over all before.
    #[inline(always)]
    fn fade<S: Level>(&self, state: &mut State<S>, sample: &Sample<S>) {
        let (sampled, value) = (sample.sampled, sample.value);
        let share = (value - F32s::splat(self.low)).over(F32s::splat(self.high - self.low));
        let share = share.max(F32s::zero()).min(F32s::splat(1.0));
        let rise = (share - state.value).max(F32s::zero());
        let kept = F32s::splat(1.0) - rise * F32s::splat(1.0 + self.blend.min(0.0));
        let kept = sampled.select(kept, F32s::splat(1.0));
        state.color = each!(state.color, |c| c * kept);
        state.alpha = state.alpha * kept;
        if self.blend > 0.0 {
            let rises = sampled & state.value.lt(share);
            state.place = rises.select(sample.place(), state.place);
            state.number = rises.select(value, state.number);
        }
        state.value = sampled.select(share.max(state.value), state.value);
    }
}

impl Rule for Mida {
    #[inline(always)]
    fn add<S: Level>(&self, state: &mut State<S>, sample: &Sample<S>) -> Mask<S> {
        self.fade(state, sample);
        let look = sample.look(&mut state.last_normal);
        let surface = look.surface;
        emission_absorption::add(state, look.visible, surface.color, surface.opacity);
        look.visible
    }

    /// Where so little would still come through that the ray may end, and no larger value can come.
    #[inline(always)]
    fn done<S: Level>(&self, state: &State<S>) -> Mask<S> {
        let stop_at_transmittance = self.stop_at_transmittance;
        let opaque = EmissionAbsorption {
            stop_at_transmittance,
        }
        .done(state);
        if self.blend == -1.0 {
            return opaque;
        }
        opaque & F32s::splat(1.0).le(state.value)
    }

    /// Above 0, fades to the sample at which the largest share was first reached: its value is in `number`.
    #[inline(always)]
    fn finish<S: Level>(&self, state: &mut State<S>, rays: &Crossing<S>) {
        if self.blend <= 0.0 {
            return;
        }
        let mut maximum = *state;
        rays.classify_once(&mut maximum, state.number, F32s::zero().lt(state.value));
        let [summed, largest] = [1.0 - self.blend, self.blend].map(F32s::splat);
        for (color, of_maximum) in state.color.iter_mut().zip(maximum.color) {
            *color = *color * summed + of_maximum * largest;
        }
        state.alpha = state.alpha * summed + maximum.alpha * largest;
    }
}
