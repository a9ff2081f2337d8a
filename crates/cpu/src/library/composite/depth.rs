//! A debug view: how far from the start of the ray the first sample that is not transparent lies, as gray.

use super::grey::grey;
use super::rule::{Rule, Sample};
use super::state::State;
use crate::lanes::{F32s, Mask};
use crate::levels::{Level, vectorized};

/// How far from the start of the ray the first sample that is not transparent lies, as gray.
#[derive(Clone, Copy)]
pub struct Depth {
    pub near_mm: f32,
    pub far_mm: f32,
}

impl Rule for Depth {
    #[inline(never)]
    fn add<S: Level>(&self, state: &mut State<S>, sample: &Sample<S>) -> Mask<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let shown = sample.shown();
                if shown.any() {
                    let distance_mm = sample.crossing.distance_mm(sample.place());
                    let color = grey(distance_mm, self.near_mm, self.far_mm);
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
