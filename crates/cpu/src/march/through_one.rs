//! The ray loop through one volume with any functions.

use super::packet::Packet;
use crate::lanes::F32s;
use crate::levels::{Level, vectorized};
use crate::library::composite::{Rule, with_rule};
use crate::scenery::Object;

impl<S: Level> Packet<'_, S> {
    /// Through one volume, in the order of the rule.
    #[inline(never)]
    pub(super) fn through_one(&mut self, object: &Object<S>) {
        vectorized::<S, _>(
            #[inline(always)]
            || self.through_one_here(object),
        );
    }

    #[inline(always)]
    fn through_one_here(&mut self, object: &Object<S>) {
        let (rays, line) = (self.rays, &self.rays.lines[0]);
        let one = F32s::splat(1.0);
        let is_back_to_front = with_rule!(self.scenery.composite, rule => rule.is_back_to_front());
        let strides = object.strides.as_ref().filter(|_| !is_back_to_front);
        let mut strides = strides.map(|strides| strides.along(line, self.last_alpha));
        let (mut k, end, mut live) = self.stand();
        while live.any() {
            let at = if is_back_to_front {
                rays.count - one - k
            } else {
                k
            };
            let position = line.position(at + rays.jitter);
            if let Some(next) = self.behind_nothing(object, position, k, live) {
                k = next;
                live = live & k.lt(end);
                continue;
            }
            let sampled = object.clips.keep(position, live);
            let (moving, sampled) = self.moving_and_sampled(object, position, live, sampled);
            let stride = match &mut strides {
                Some(strides) => {
                    let shape = object.values.shape();
                    let cell = shape.cell(shape.clamp(position));
                    strides.at(cell, moving, self.state.alpha, rays.count - k)
                }
                None => one,
            };
            if sampled.any() {
                let value = self.value(object, position, sampled);
                // What is not finite is no value: no rule counts it.
                let sampled = sampled & value.is_finite();
                let visible = self.add(object, at, position, sampled, value, stride);
                self.visible += visible.select(one, F32s::zero());
            }
            k = moving.select(k + stride, k);
            live = live & k.lt(end) & !self.done();
        }
        self.k = k;
        if let Some(strides) = strides {
            self.last_alpha = strides.last_alpha;
        }
    }
}
