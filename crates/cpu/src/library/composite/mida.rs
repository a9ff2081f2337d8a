//! Maximum intensity difference accumulation (S. Bruckner and E. Gröller 2009): where the ray meets
//! a value larger than all before, what lies in front fades by the difference.

use super::emission_absorption::{self, EmissionAbsorption};
use super::rule::{Rule, Sample};
use super::state::State;
use crate::lanes::{F32s, Mask, each};
use crate::levels::Level;

/// Between emission–absorption (`blend` −1) and the largest value.
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
    fn fade<S: Level>(&self, state: &mut State<S>, sampled: Mask<S>, value: F32s<S>) {
        let share = (value - F32s::splat(self.low)).over(F32s::splat(self.high - self.low));
        let share = share.max(F32s::zero()).min(F32s::splat(1.0));
        let rise = (share - state.value).max(F32s::zero());
        let kept = F32s::splat(1.0) - rise * F32s::splat(1.0 + self.blend);
        let kept = sampled.select(kept, F32s::splat(1.0));
        state.colour = each!(state.colour, |c| c * kept);
        state.alpha = state.alpha * kept;
        state.value = sampled.select(share.max(state.value), state.value);
    }
}

impl Rule for Mida {
    #[inline(always)]
    fn add<S: Level>(&self, state: &mut State<S>, sample: &Sample<S>) -> Mask<S> {
        self.fade(state, sample.sampled, sample.value);
        let look = sample.look(&mut state.last_normal);
        let surface = look.surface;
        emission_absorption::add(state, look.visible, surface.colour, surface.opacity);
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
}
