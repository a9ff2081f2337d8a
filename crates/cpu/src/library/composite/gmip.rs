//! The largest gradient magnitude of the ray.

use super::grey::grey;
use super::rule::{Crossing, Rule, Sample};
use super::state::State;
use crate::lanes::{F32s, Mask, length};
use crate::levels::Level;

/// The largest gradient magnitude as gray.
#[derive(Clone, Copy)]
pub struct Gmip {
    pub white_per_mm: f32,
}

impl Rule for Gmip {
    #[inline(always)]
    fn add<S: Level>(&self, state: &mut State<S>, sample: &Sample<S>) -> Mask<S> {
        let steep = length(sample.gradient(sample.sampled));
        let better = sample.sampled & state.value.lt(steep);
        state.keep(better, sample.sampled, steep, sample.place());
        sample.sampled
    }

    #[inline(always)]
    fn finish<S: Level>(&self, state: &mut State<S>, _rays: &Crossing<S>) {
        let found = F32s::zero().lt(state.number);
        let seen = grey(state.value, 0.0, self.white_per_mm);
        state.paint(found, seen);
    }
}
