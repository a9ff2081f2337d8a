//! A debug view: where in the volume the first sample lies, as a color.

use super::rule::{Rule, Sample};
use super::state::State;
use crate::lanes::{F32s, Mask};
use crate::levels::{Level, vectorized};

/// Where in the volume the first sample lies, as a color.
#[derive(Clone, Copy)]
pub struct Entry;

impl Rule for Entry {
    #[inline(never)]
    fn add<S: Level>(&self, state: &mut State<S>, sample: &Sample<S>) -> Mask<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                state.paint(sample.sampled, sample.position_color());
                sample.sampled
            },
        )
    }

    #[inline(always)]
    fn done<S: Level>(&self, state: &State<S>) -> Mask<S> {
        F32s::zero().lt(state.alpha)
    }
}
