//! The ray loop through one volume with any functions.

use super::packet::Packet;
use crate::lanes::F32s;
use crate::levels::{Level, vectorized};
use crate::scenery::Object;
use strahl_scene::plan::Composite;

impl<S: Level> Packet<'_, S> {
    /// Front to back through one volume; how many lattice points each ray has walked.
    #[inline(never)]
    pub(super) fn forwards(&mut self, object: &Object<S>) -> F32s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || self.forwards_here(object),
        )
    }

    #[inline(always)]
    fn forwards_here(&mut self, object: &Object<S>) -> F32s<S> {
        let (rays, line) = (self.rays, &self.rays.lines[0]);
        let one = F32s::splat(1.0);
        let mut strides = object.strides.as_ref().map(|strides| strides.along(line));
        let mut k = F32s::zero();
        let mut live = k.lt(rays.count);
        while live.any() {
            let position = line.position(k + rays.jitter);
            if let Some(next) = self.behind_nothing(object, position, k, live) {
                k = next;
                live = live & k.lt(rays.count);
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
                let visible = self.add(object, k, position, sampled, value, stride);
                self.visible += visible.select(one, F32s::zero());
            }
            k = moving.select(k + stride, k);
            live = live & k.lt(rays.count) & !self.done();
        }
        if let Composite::FirstHit { threshold } = self.scenery.composite {
            self.hit(object, F32s::splat(threshold));
        }
        k
    }
}
