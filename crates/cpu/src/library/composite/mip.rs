//! Maximum intensity projection.

use super::rule::{Crossing, Rule, Sample};
use super::state::State;
use super::visible_values::VisibleValues;
use crate::lanes::{F32s, Mask};
use crate::levels::Level;

/// The largest value, and where it is first; classified once.
#[derive(Clone, Copy)]
pub struct Mip;

impl Rule for Mip {
    fn sees(&self) -> VisibleValues {
        VisibleValues::Larger
    }

    #[inline(always)]
    fn start<S: Level>(&self) -> State<S> {
        State::start(f32::NEG_INFINITY)
    }

    #[inline(always)]
    fn add<S: Level>(&self, state: &mut State<S>, sample: &Sample<S>) -> Mask<S> {
        let better = sample.sampled & state.value.lt(sample.value);
        state.keep(better, sample.sampled, sample.value, sample.place());
        sample.sampled
    }

    #[inline(always)]
    fn finish<S: Level>(&self, state: &mut State<S>, rays: &Crossing<S>) {
        let found = F32s::zero().lt(state.number);
        rays.classify_once(state, state.value, found);
    }
}
