//! A debug view: where in the volume the last sample lies, as a color.

use super::rule::{Rule, Sample};
use super::state::State;
use crate::lanes::Mask;
use crate::levels::{Level, vectorized};

/// Where in the volume the last sample lies, as a color.
#[derive(Clone, Copy)]
pub struct Exit;

impl Rule for Exit {
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
}
