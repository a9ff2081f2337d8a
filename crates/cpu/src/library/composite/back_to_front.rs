//! Emission and absorption from the last sample to the first; no ray ends early.

use super::rule::{Rule, Sample};
use super::state::State;
use crate::lanes::{F32s, Mask, Vec3s};
use crate::levels::Level;

/// What the eye sees of all samples.
#[derive(Clone, Copy)]
pub struct BackToFront;

impl Rule for BackToFront {
    fn is_back_to_front(&self) -> bool {
        true
    }

    #[inline(always)]
    fn add<S: Level>(&self, state: &mut State<S>, sample: &Sample<S>) -> Mask<S> {
        let look = sample.look(&mut state.last_normal);
        add(
            state,
            look.visible,
            look.surface.color,
            look.surface.opacity,
        );
        look.visible
    }
}

/// Adds a sample that lies in front of all before it: C = (1−a)·C + a·c, A likewise.
#[inline(always)]
pub fn add<S: Level>(state: &mut State<S>, visible: Mask<S>, color: Vec3s<S>, opacity: F32s<S>) {
    let opacity = visible.select(opacity, F32s::zero());
    let behind = F32s::splat(1.0) - opacity;
    for (sum, channel) in state.color.iter_mut().zip(color) {
        *sum = *sum * behind + visible.select(opacity * channel, F32s::zero());
    }
    state.alpha = state.alpha * behind + opacity;
}
