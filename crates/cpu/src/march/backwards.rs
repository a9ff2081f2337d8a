//! The ray loop from the far end.

use super::packet::Packet;
use crate::lanes::F32s;
use crate::levels::{Level, vectorized};
use crate::library::classify::Surface;
use crate::library::composite::emission_absorption;
use crate::scenery::Object;

impl<S: Level> Packet<'_, S> {
    /// Back to front through one volume: every sample.
    #[inline(never)]
    pub(super) fn backwards(&mut self, object: &Object<S>) -> F32s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || self.backwards_here(object),
        )
    }

    #[inline(always)]
    pub(super) fn backwards_here(&mut self, object: &Object<S>) -> F32s<S> {
        let (rays, line) = (self.rays, &self.rays.lines[0]);
        let one = F32s::splat(1.0);
        let mut left = rays.count;
        let mut live = F32s::zero().lt(left);
        while live.any() {
            left = live.select(left - one, left);
            let position = line.position(left + rays.jitter);
            let look = self.look(object, position, live);
            let Surface { colour, opacity } = look.surface;
            emission_absorption::add_in_front(&mut self.state, look.visible, colour, opacity);
            self.visible += look.visible.select(one, F32s::zero());
            live = live & F32s::zero().lt(left);
        }
        rays.count
    }
}
