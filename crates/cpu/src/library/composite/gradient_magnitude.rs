//! A debug view: how steep the first sample that is not transparent is, as gray.

use super::grey::grey;
use super::rule::{Rule, Sample};
use super::state::State;
use crate::lanes::{F32s, Mask, length};
use crate::levels::{Level, vectorized};

/// How steep the first sample that is not transparent is, as gray.
#[derive(Clone, Copy)]
pub struct GradientMagnitude {
    pub white_per_mm: f32,
}

impl Rule for GradientMagnitude {
    #[inline(never)]
    fn add<S: Level>(&self, state: &mut State<S>, sample: &Sample<S>) -> Mask<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let shown = sample.shown();
                if shown.any() {
                    let color = grey(length(sample.gradient(shown)), 0.0, self.white_per_mm);
                    state.paint(shown, color);
                }
                shown
            },
        )
    }

    #[inline(always)]
    fn done<S: Level>(&self, state: &State<S>) -> Mask<S> {
        F32s::zero().lt(state.alpha)
    }
}
