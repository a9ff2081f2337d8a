//! One sample for several lattice points in a row, where the transfer function hardly changes.
//!
//! A run of lattice points begins at the first one in an even cube and ends with the last one for certain in it, so
//! that it depends on the lattice and on the cubes only. A cube that is even shows nothing at all or something
//! everywhere: skipping leaves out a run or none of it.

use super::packet::Packet;
use crate::lanes::{F32s, Mask};
use crate::levels::{Level, vectorized};
use crate::library::classify::Surface;
use crate::library::composite::emission_absorption;
use crate::scenery::Object;

impl<S: Level> Packet<'_, S> {
    /// Front to back through one volume by runs of lattice points.
    #[inline(never)]
    pub(super) fn by_runs(&mut self, object: &Object<S>) {
        vectorized::<S, _>(
            #[inline(always)]
            || self.by_runs_here(object),
        );
    }

    #[inline(always)]
    fn by_runs_here(&mut self, object: &Object<S>) {
        let (rays, line) = (self.rays, &self.rays.lines[0]);
        let (zero, one) = (F32s::zero(), F32s::splat(1.0));
        let shape = object.values.shape();
        let (mut k, end, mut live) = self.stand();
        while live.any() {
            let position = line.position(k + rays.jitter);
            if let Some(next) = self.behind_nothing(object, position, k, live) {
                self.skipped += next - k;
                k = next;
                live = live & k.lt(end);
                continue;
            }
            let run = match &object.even {
                Some(even) => even.run(shape, line, position).min(rays.count - k),
                None => one,
            };
            let kept = self.kept(object, k, run, live);
            let sampled = live & zero.lt(kept);
            let sampled = object.unless_rejected(position, self.state.value, sampled);
            if sampled.any() {
                let value = self.value(object, position, sampled);
                let sampled = sampled & value.is_finite();
                let Surface { color, opacity } = object.classify(value, position, sampled);
                let visible = sampled & zero.lt(opacity);
                if visible.any() {
                    let opacity = object.of_steps(opacity, kept);
                    emission_absorption::add(&mut self.state, visible, color, opacity);
                    self.visible += visible.select(one, zero);
                }
            }
            k = live.select(k + run, k);
            live = live & k.lt(end) & !self.done();
        }
        self.k = k;
    }

    /// How many of the `run` lattice points from `k` on are not clipped.
    #[inline(always)]
    fn kept(&self, object: &Object<S>, k: F32s<S>, run: F32s<S>, live: Mask<S>) -> F32s<S> {
        if object.clips.is_empty() {
            return run;
        }
        let (zero, one) = (F32s::zero(), F32s::splat(1.0));
        let (mut kept, mut i) = (zero, zero);
        let mut left = live;
        while left.any() {
            let position = self.rays.lines[0].position(k + i + self.rays.jitter);
            kept += object.clips.keep(position, left).select(one, zero);
            i += one;
            left = left & i.lt(run);
        }
        kept
    }
}
