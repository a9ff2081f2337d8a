//! A debug view: the normal of the first sample that is not transparent, as a color.

use super::rule::{Rule, Sample};
use super::state::State;
use super::vector_color::vector_color;
use crate::lanes::{F32s, Mask, unit};
use crate::levels::{Level, vectorized};

/// The normal of the first sample that is not transparent, as a color.
#[derive(Clone, Copy)]
pub struct Normal;

impl Rule for Normal {
    #[inline(never)]
    fn add<S: Level>(&self, state: &mut State<S>, sample: &Sample<S>) -> Mask<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let shown = sample.shown();
                if shown.any() {
                    let (normal, _) = unit(sample.gradient(shown));
                    let color = vector_color(normal);
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
