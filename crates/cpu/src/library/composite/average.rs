//! The mean along the ray: what an X-ray film would show of a linear detector.

use super::rule::{Crossing, Rule, Sample};
use super::state::State;
use crate::lanes::{F32s, Mask};
use crate::levels::Level;

/// The mean value, classified once.
#[derive(Clone, Copy)]
pub struct Average;

impl Rule for Average {
    /// Adds up, with W. Kahan's compensation, as thousands of samples of the same size would each lose
    /// their last bits.
    #[inline(always)]
    fn add<S: Level>(&self, state: &mut State<S>, sample: &Sample<S>) -> Mask<S> {
        let sampled = sample.sampled;
        let term = sample.value - state.lost;
        let sum = state.value + term;
        let lost = (sum - state.value) - term;
        // An infinite sum stays infinite instead of becoming NaN.
        let finite = lost.is_finite();
        state.value = sampled.select(sum, state.value);
        state.lost = (sampled & finite).select(lost, state.lost);
        state.number = sampled.select(state.number + F32s::splat(1.0), state.number);
        state.place = sampled.select(sample.place(), state.place);
        sampled
    }

    #[inline(always)]
    fn finish<S: Level>(&self, state: &mut State<S>, rays: &Crossing<S>) {
        let found = F32s::zero().lt(state.number);
        let mean = state.value.over(state.number.max(F32s::splat(1.0)));
        rays.classify_once(state, mean, found);
    }
}
