//! A debug view: how many samples the ray takes, as gray.

use super::grey::grey;
use super::rule::{Crossing, Rule, Sample};
use super::state::State;
use crate::lanes::{F32s, Mask};
use crate::levels::Level;

/// How many samples the ray takes, as gray.
#[derive(Clone, Copy)]
pub struct SampleCount {
    pub white: f32,
}

impl Rule for SampleCount {
    #[inline(always)]
    fn add<S: Level>(&self, state: &mut State<S>, sample: &Sample<S>) -> Mask<S> {
        let more = state.number + F32s::splat(1.0);
        state.number = sample.sampled.select(more, state.number);
        sample.sampled
    }

    #[inline(always)]
    fn finish<S: Level>(&self, state: &mut State<S>, _rays: &Crossing<S>) {
        let found = F32s::zero().lt(state.number);
        state.paint(found, grey(state.number, 0.0, self.white));
    }
}
