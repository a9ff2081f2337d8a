//! Minimum intensity projection.

use super::rule::{Crossing, Rule, Sample};
use super::state::State;
use super::visible_values::VisibleValues;
use crate::lanes::{F32s, Mask};
use crate::levels::Level;

/// The smallest value, and where it is first; classified once.
#[derive(Clone, Copy)]
pub struct Minip;

impl Rule for Minip {
    fn sees(&self) -> VisibleValues {
        VisibleValues::Smaller
    }

    #[inline(always)]
    fn start<S: Level>(&self) -> State<S> {
        State::start(f32::INFINITY)
    }

    #[inline(always)]
    fn add<S: Level>(&self, state: &mut State<S>, sample: &Sample<S>) -> Mask<S> {
        let better = sample.sampled & sample.value.lt(state.value);
        state.keep(better, sample.sampled, sample.value, sample.place());
        sample.sampled
    }

    #[inline(always)]
    fn finish<S: Level>(&self, state: &mut State<S>, rays: &Crossing<S>) {
        let found = F32s::zero().lt(state.number);
        rays.classify_once(state, state.value, found);
    }
}
