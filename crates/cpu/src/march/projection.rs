//! Projections: the largest or the smallest value of every ray, where it is likely first.
//!
//! A lattice is cut into runs of a few points, and one look-up says for a whole run what its values
//! cannot exceed. Each ray samples the most promising run first; hardly any other run can hold more than
//! what it has found there.

use super::packet::Packet;
use crate::lanes::{F32s, Mask};
use crate::levels::{Level, vectorized};
use crate::line::Line;
use crate::scenery::Object;
use crate::skip::Bounds;
use strahl_scene::plan::Composite;

/// Runs that are looked at together.
const RUNS: usize = 128;

/// Bounds of runs: memory that packets use one after the other, as clearing it takes a while.
pub struct RunBounds<S: Level> {
    bounds: [F32s<S>; RUNS],
    /// The first lattice points.
    starts: [f32; RUNS],
}

impl<S: Level> RunBounds<S> {
    /// Of no run.
    #[inline(always)]
    pub fn none() -> RunBounds<S> {
        RunBounds {
            bounds: [F32s::zero(); RUNS],
            starts: [0.0; RUNS],
        }
    }
}

impl<S: Level> Packet<'_, S> {
    /// Through one volume, with bounds for its values.
    #[inline(never)]
    pub(super) fn project(
        &mut self,
        object: &Object<S>,
        bounds: &Bounds,
        of_runs: &mut RunBounds<S>,
    ) {
        vectorized::<S, _>(
            #[inline(always)]
            || self.project_here(object, bounds, of_runs),
        );
    }

    #[inline(always)]
    fn project_here(&mut self, object: &Object<S>, bounds: &Bounds, of_runs: &mut RunBounds<S>) {
        let (rays, line) = (self.rays, &self.rays.lines[0]);
        let shape = object.values.shape();
        let one = F32s::splat(1.0);
        let nothing = F32s::splat(f32::NEG_INFINITY);
        let points = bounds.points_of_run(line);
        let last = rays.count - one;
        // The largest value so far; of a minimum the negatives are kept.
        self.state.value = nothing;
        self.skipped = rays.count;
        let mut from = 0.0;
        while F32s::splat(from).lt(rays.count).any() {
            let (mut best, mut best_run) = (nothing, F32s::zero());
            let mut others = 0;
            while others < RUNS {
                let k = F32s::splat(from);
                let live = k.lt(rays.count);
                if !live.any() {
                    break;
                }
                let (start, end) = (k.min(last), (k + F32s::splat(points - 1.0)).min(last));
                let ends = [
                    line.position(start + rays.jitter),
                    line.position(end + rays.jitter),
                ];
                let bound = live.select(bounds.of_run(shape, ends), nothing);
                let better = best.lt(bound);
                best = better.select(bound, best);
                best_run = better.select(k, best_run);
                of_runs.bounds[others] = bound;
                of_runs.starts[others] = from;
                others += 1;
                from += points;
            }
            loop {
                let waiting = self.may_change(best, best_run);
                if !waiting.any() {
                    break;
                }
                self.sample_run(object, line, bounds, best_run, points, waiting);
                let sampled = best_run;
                best = nothing;
                let mut left = 0;
                for run in 0..others {
                    let start = of_runs.starts[run];
                    let k = F32s::splat(start);
                    let bound = k.eq(sampled).select(nothing, of_runs.bounds[run]);
                    let better = best.lt(bound);
                    best = better.select(bound, best);
                    best_run = better.select(k, best_run);
                    // Runs that no ray needs any more are not looked at again.
                    of_runs.bounds[left] = bound;
                    of_runs.starts[left] = start;
                    left += usize::from(self.may_change(bound, k).any());
                }
                others = left;
            }
        }
        if bounds.is_negative() {
            self.state.value = -self.state.value;
        }
        self.k = rays.count;
    }

    /// Looks around the largest or smallest value of each ray for one beyond it: half a step to either side, then a
    /// quarter, down to one of `parts`.
    #[inline(never)]
    pub(super) fn refine_projection(&mut self, object: &Object<S>, parts: u32) {
        vectorized::<S, _>(
            #[inline(always)]
            || self.refine_projection_here(object, parts),
        );
    }

    #[inline(always)]
    fn refine_projection_here(&mut self, object: &Object<S>, parts: u32) {
        let (rays, line) = (self.rays, &self.rays.lines[0]);
        let found = F32s::zero().lt(self.state.number);
        if !found.any() {
            return;
        }
        let is_least = self.scenery.composite == Composite::Minip;
        // Where the ray leaves.
        let tail = rays.tail * F32s::splat(1.0 / parts as f32);
        let last = rays.count - F32s::splat(1.0) + rays.jitter + tail;
        let mut by = 0.5;
        while by * parts as f32 >= 1.0 {
            for by in [-by, by] {
                let place = self.state.place + F32s::splat(by);
                let on_ray = found & F32s::zero().le(place) & place.le(last);
                let position = line.position(place);
                let sampled = object.clips.keep(position, on_ray);
                let value = self.value(object, position, sampled);
                let (a, b) = if is_least {
                    (value, self.state.value)
                } else {
                    (self.state.value, value)
                };
                let better = sampled & value.is_finite() & a.lt(b);
                self.state.value = better.select(value, self.state.value);
                self.state.place = better.select(place, self.state.place);
            }
            by *= 0.5;
        }
    }

    /// Where a run from `k` on, of values up to `bound`, can change what is known of a ray: the largest
    /// value, and where it is first.
    #[inline(always)]
    fn may_change(&self, bound: F32s<S>, k: F32s<S>) -> Mask<S> {
        let state = &self.state;
        let earlier = (k + self.rays.jitter).lt(state.place);
        state.value.lt(bound) | (bound.eq(state.value) & earlier)
    }

    #[inline(always)]
    fn sample_run(
        &mut self,
        object: &Object<S>,
        line: &Line<S>,
        bounds: &Bounds,
        mut k: F32s<S>,
        points: f32,
        asked: Mask<S>,
    ) {
        let rays = self.rays;
        let one = F32s::splat(1.0);
        let end = (k + F32s::splat(points)).min(rays.count);
        loop {
            let live = asked & k.lt(end);
            if !live.any() {
                return;
            }
            self.skipped = live.select(self.skipped - one, self.skipped);
            let place = k + rays.jitter;
            let position = line.position(place);
            let so_far = if bounds.is_negative() {
                -self.state.value
            } else {
                self.state.value
            };
            let sampled = object.clips.keep(position, live);
            let sampled = object.unless_rejected(position, so_far, sampled);
            if sampled.any() {
                let value = object.values.at(position);
                self.sampled += sampled.select(one, F32s::zero());
                let sampled = sampled & value.is_finite();
                let value = if bounds.is_negative() { -value } else { value };
                let state = &mut self.state;
                let earlier = value.eq(state.value) & place.lt(state.place);
                let better = sampled & (state.value.lt(value) | earlier);
                state.value = better.select(value, state.value);
                state.place = better.select(place, state.place);
                state.number = sampled.select(one, state.number);
                self.visible += sampled.select(one, F32s::zero());
            }
            k += one;
        }
    }
}
