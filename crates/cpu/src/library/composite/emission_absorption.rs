//! N. Max, "Optical models for direct volume rendering" (1995), front to back.

use super::rule::{Rule, Sample};
use super::state::State;
use super::visible_values::VisibleValues;
use crate::lanes::{F32s, Mask, Vec3s};
use crate::levels::Level;
use crate::library::classify::Surface;

/// What the eye sees of all samples, until too little would still come through.
#[derive(Clone, Copy)]
pub struct EmissionAbsorption {
    pub stop_at_transmittance: f32,
}

impl Rule for EmissionAbsorption {
    fn sees(&self) -> VisibleValues {
        VisibleValues::Shown
    }

    #[inline(always)]
    fn add<S: Level>(&self, state: &mut State<S>, sample: &Sample<S>) -> Mask<S> {
        let look = sample.look(&mut state.last_normal);
        let Surface { color, opacity } = look.surface;
        let opacity = sample.crossing.object.of_stride(opacity, sample.stride);
        add(state, look.visible, color, opacity);
        look.visible
    }

    #[inline(always)]
    fn done<S: Level>(&self, state: &State<S>) -> Mask<S> {
        (F32s::splat(1.0) - state.alpha).lt(F32s::splat(self.stop_at_transmittance))
    }
}

/// Adds what the eye sees of a sample: C += (1−A)·a·c, A += (1−A)·a.
#[inline(always)]
pub fn add<S: Level>(state: &mut State<S>, visible: Mask<S>, color: Vec3s<S>, opacity: F32s<S>) {
    let share = (F32s::splat(1.0) - state.alpha) * opacity;
    let share = visible.select(share, F32s::zero());
    for (sum, channel) in state.color.iter_mut().zip(color) {
        // Selected once more: a color may be infinite, and 0·∞ is NaN.
        *sum += visible.select(share * channel, F32s::zero());
    }
    state.alpha += share;
}
