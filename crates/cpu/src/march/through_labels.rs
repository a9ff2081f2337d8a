//! Front to back through the segments of a label volume: the samples of one segment in a row are a run, which
//! the local rule of its technique makes into one sample; runs add up by the rule of the Plan.

use super::packet::Packet;
use super::runs::Run;
use crate::lanes::{F32s, Mask, Vec3s, each, lanes};
use crate::levels::{Level, vectorized};
use crate::library::composite::{Crossing, Rule, State, with_rule};
use crate::scenery::Object;
use crate::segment_looks::FINISHED;
use crate::segment_numbers::SegmentNumbers;

impl<S: Level> Packet<'_, S> {
    /// Through the segments of one volume. [`end_last_runs`](Packet::end_last_runs) completes what is seen.
    #[inline(never)]
    pub(super) fn through_labels(&mut self, segments: &SegmentNumbers) {
        vectorized::<S, _>(
            #[inline(always)]
            || self.through_labels_here(segments),
        );
    }

    #[inline(always)]
    fn through_labels_here(&mut self, segments: &SegmentNumbers) {
        let (rays, line) = (self.rays, &self.rays.lines[0]);
        let one = F32s::splat(1.0);
        let end = self.end.min(rays.count);
        let unseen = segments.unseen.as_deref();
        let everywhere = unseen.and_then(|unseen| unseen.everywhere.as_ref());
        let in_one = unseen.and_then(|unseen| unseen.in_one.as_ref());
        let shape = self.scenery.objects[0].values.shape();
        let mut live = self.begin.le(self.k) & self.k.lt(end) & !self.runs.are_complete(segments);
        while live.any() {
            let k = self.k;
            let position = line.position(k + rays.jitter);
            if let Some(skip) = everywhere {
                // A run ends before anything behind it is left out. One that has seen nothing may as well begin behind it.
                let technique = self.runs.technique;
                let begins = technique.lt(F32s::splat(FINISHED)) & self.sees_nothing();
                let is_free = technique.eq(F32s::zero()) | begins;
                let jump = skip.jump(shape, line, position);
                let jumping = live & is_free & F32s::zero().lt(jump);
                if jumping.any() {
                    self.k = jumping.select((k + jump).min(rays.count), k);
                    self.skipped += self.k - k;
                    if !segments.groups.is_empty() {
                        self.runs.end_groups(segments, jumping);
                    }
                    // Whatever comes next is a new run.
                    self.runs.segment = jumping.select(F32s::zero(), self.runs.segment);
                    self.runs.technique = jumping.select(F32s::zero(), self.runs.technique);
                    live = live & self.k.lt(end);
                    continue;
                }
            }
            let (jump, idling) = match in_one {
                Some(skip) => {
                    let jump = skip.jump(shape, line, position);
                    (jump, live & F32s::zero().lt(jump))
                }
                None => (one, Mask::none()),
            };
            // The others wait, so that sampling happens for as many rays as possible.
            let waits = 2 * idling.count() > live.count();
            let moving = if waits { idling } else { live };
            let here = segments.at(position, moving);
            let changed = moving & !here.eq(self.runs.segment);
            if changed.any() {
                live = live & !self.change_segments(segments, here, changed);
            }
            if idling.any() {
                let jumped = live & idling;
                self.k = jumped.select((k + jump).min(rays.count), k);
                self.skipped += self.k - k;
            }
            if waits {
                live = live & self.k.lt(end);
                continue;
            }
            let technique = self.runs.technique;
            let is_shown = F32s::zero().lt(technique) & technique.lt(F32s::splat(FINISHED));
            let shown = live & !idling & is_shown;
            let kept = self.scenery.objects[0].clips.keep(position, shown);
            if kept.any() {
                live = live & !self.sample_segments(segments, k, position, kept);
            }
            self.k = (live & !idling).select(k + one, self.k);
            live = live & self.k.lt(end);
        }
    }

    /// Rays whose run is as it began. Not so rules that begin with something else; they find only that they see something.
    #[inline(always)]
    fn sees_nothing(&self) -> Mask<S> {
        let zero = F32s::zero();
        let State {
            alpha,
            value,
            lost,
            number,
            ..
        } = self.state;
        alpha.eq(zero) & value.eq(zero) & lost.eq(zero) & number.eq(zero)
    }

    /// Ends the runs of the rays `changed`, which are in the segments `here`, and begins new ones; says which of the
    /// rays need no more.
    #[inline(always)]
    fn change_segments(
        &mut self,
        segments: &SegmentNumbers,
        here: F32s<S>,
        changed: Mask<S>,
    ) -> Mask<S> {
        self.end_runs(changed);
        self.runs.segment = changed.select(here, self.runs.segment);
        let segment = self.runs.segment.to_array();
        if !segments.groups.is_empty() {
            let group = F32s::from_array(lanes(|i| segments.group(segment[i])));
            let left = changed & !group.eq(self.runs.group);
            self.runs.end_groups(segments, left);
            self.runs.group = left.select(group, self.runs.group);
        }
        let technique = F32s::from_array(lanes(|i| segments.technique(segment[i])));
        let ended = changed & self.runs.are_complete(segments);
        let technique = ended.select(F32s::zero(), technique);
        self.runs.technique = changed.select(technique, self.runs.technique);
        self.begin_runs(segments, changed & !ended);
        ended
    }

    /// Adds lattice point `k` of the rays `kept` to their runs; says which of the rays need no more.
    #[inline(always)]
    fn sample_segments(
        &mut self,
        segments: &SegmentNumbers,
        k: F32s<S>,
        position: Vec3s<S>,
        kept: Mask<S>,
    ) -> Mask<S> {
        let (zero, one) = (F32s::zero(), F32s::splat(1.0));
        let objects = &self.scenery.objects;
        let value = self.value(&objects[0], position, kept);
        let sampled = kept & value.is_finite();
        if segments.gain_of_places > 0.0 {
            self.note_importance(segments.gain_of_places, position, sampled);
        }
        let mut ended = Mask::none();
        for (i, object) in objects.iter().enumerate() {
            let own = sampled & self.runs.technique.eq(F32s::splat(1.0 + i as f32));
            if !own.any() {
                continue;
            }
            let visible = self.add(object, k, position, own, value, one);
            self.visible += visible.select(one, zero);
            let done = own & with_rule!(object.composite, rule => rule.done(&self.state));
            if done.any() {
                self.end_runs_of(object, done);
                self.runs.technique = done.select(F32s::splat(FINISHED), self.runs.technique);
                ended = ended | (done & self.runs.are_complete(segments));
            }
        }
        ended
    }

    /// The importance of the places `position` of the rays `sampled` counts for their runs.
    #[inline(never)]
    fn note_importance(&mut self, gain: f32, position: Vec3s<S>, sampled: Mask<S>) {
        if let Some(places) = &self.scenery.important_places {
            let here = places.at(position) * F32s::splat(gain);
            self.runs.by_place = sampled.select(self.runs.by_place.max(here), self.runs.by_place);
        }
    }

    /// A new run for the rays `of`.
    #[inline(always)]
    fn begin_runs(&mut self, segments: &SegmentNumbers, of: Mask<S>) {
        let last_normal = self.state.last_normal;
        for (i, object) in self.scenery.objects.iter().enumerate() {
            let own = of & self.runs.technique.eq(F32s::splat(1.0 + i as f32));
            if own.any() {
                let start = with_rule!(object.composite, rule => match rule.is_covered_by_ray() {
                    true => rule.start_behind(self.runs.opacity(segments)),
                    false => rule.start(),
                });
                self.state = State::select(own, &start, &self.state);
            }
        }
        self.state.last_normal = last_normal;
        self.runs.by_place = of.select(F32s::zero(), self.runs.by_place);
    }

    /// Adds the last runs of all rays to what they have seen, which becomes their state; says where the first hit of a
    /// run lies at their place.
    #[inline(always)]
    pub(super) fn end_last_runs(&mut self) -> Mask<S> {
        self.end_runs(!Mask::none());
        if let Some(segments) = &self.scenery.segments {
            if !segments.groups.is_empty() {
                self.runs.end_groups(segments, !Mask::none());
            }
            (self.state.color, self.state.alpha) = self.runs.all.pixel(segments.rule);
        }
        self.state.place = self.runs.place;
        F32s::zero().lt(self.runs.has_place)
    }

    /// Adds the runs of the rays `of` to what they have seen.
    #[inline(always)]
    fn end_runs(&mut self, of: Mask<S>) {
        for (i, object) in self.scenery.objects.iter().enumerate() {
            let own = of & self.runs.technique.eq(F32s::splat(1.0 + i as f32));
            if own.any() {
                self.end_runs_of(object, own);
            }
        }
    }

    /// The same for runs that `object` has drawn.
    #[inline(never)]
    fn end_runs_of(&mut self, object: &Object<S>, of: Mask<S>) {
        vectorized::<S, _>(
            #[inline(always)]
            || self.end_runs_here(object, of),
        );
    }

    #[inline(always)]
    fn end_runs_here(&mut self, object: &Object<S>, of: Mask<S>) {
        let (zero, one) = (F32s::zero(), F32s::splat(1.0));
        // To the rule the other rays have seen nothing.
        let mut run = State::select(of, &self.state, &State::start(0.0));
        let crossing = Crossing {
            scenery: self.scenery,
            object,
            packet: self.rays,
            to_eye: &self.to_eye,
        };
        let has_depth = with_rule!(object.composite, rule => {
            rule.finish(&mut run, &crossing);
            rule.has_depth()
        });
        let Some(segments) = &self.scenery.segments else {
            return;
        };
        let of_runs = self.runs.segment.to_array();
        let factors = lanes(|i| segments.factors(of_runs[i]));
        let factor = |channel: usize| F32s::from_array(lanes(|i| factors[i][channel]));
        let color = each!([0, 1, 2], |channel| run.color[channel] * factor(channel));
        let alpha = run.alpha * factor(3);
        let importance = F32s::from_array(lanes(|i| segments.importance(of_runs[i])));
        let importance = importance + self.runs.by_place;
        let runs = &mut *self.runs;
        if has_depth {
            let first = of & zero.lt(run.alpha) & runs.has_place.eq(zero);
            runs.place = first.select(run.place, runs.place);
            runs.has_place = first.select(one, runs.has_place);
        }
        let ended = Run {
            color,
            alpha,
            importance,
        };
        runs.add(segments, of, &ended);
        self.state.last_normal = of.select3(run.last_normal, self.state.last_normal);
    }
}
