//! Front to back through segments whose samples and whose runs all add up by emission and absorption
//! ([`SegmentLooks`]). What [`Packet::through_labels`] does with any rules, up to rounding:
//!
//! - Which segment a place is in is asked where that matters; where no run is multiplied by an opacity, runs make no
//!   difference, and that is wherever a sample may be visible.
//! - All tables are looked up at once, and lit samples are collected until every lane has one. They are added to the
//!   pixel, not to the run: a run of opacity o that begins behind an opacity of A shows (1 − A)·o of each.

use super::packet::Packet;
use super::points::Points;
use super::unlit_samples::UnlitSamples;
use crate::lanes::{F32s, I32s, LANES, Mask, Vec3s, each, lanes, to_rows};
use crate::levels::{Level, inlined, vectorized};
use crate::library::classify::Surface;
use crate::library::fetch::{Fetch, Linear, Shape};
use crate::library::reconstruct::{Values, trilinear};
use crate::scenery::{Object, Stored};
use crate::segment_looks::{FINISHED, SegmentLooks};
use crate::segment_numbers::SegmentNumbers;
use strahl_volume::Sample;

/// What values come from.
trait Reader<S: Level> {
    fn shape(&self) -> &Shape;
    /// Those at `points` in the volume of `object`.
    fn values(&self, object: &Object<S>, points: &Points<S>) -> F32s<S>;
}

impl<S: Level, T: Sample> Reader<S> for Linear<'_, T> {
    #[inline(always)]
    fn shape(&self) -> &Shape {
        <Self as Fetch<S>>::shape(self)
    }

    #[inline(always)]
    fn values(&self, object: &Object<S>, points: &Points<S>) -> F32s<S> {
        // SAFETY: points are made of this shape.
        let corners = unsafe { self.corners(points.cell) };
        object.rescaled(trilinear::between(corners, points.part()))
    }
}

impl<S: Level> Reader<S> for &dyn Values<S> {
    #[inline(always)]
    fn shape(&self) -> &Shape {
        Values::shape(*self)
    }

    #[inline(always)]
    fn values(&self, _: &Object<S>, points: &Points<S>) -> F32s<S> {
        self.at(points.position)
    }
}

/// Samples that are to be lit, and the segments that they are in.
struct UnlitSegments {
    samples: UnlitSamples,
    segments: [f32; UnlitSamples::MOST],
}

/// How far the runs of a packet have come.
#[derive(Clone, Copy)]
struct Progress<S: Level> {
    /// The opacity of all runs that have ended; where runs make no difference that of all samples.
    all: F32s<S>,
    /// That of the run.
    run: F32s<S>,
    segment: F32s<S>,
    /// Counted from 1; 0 where the segment is hidden, or [`FINISHED`].
    technique: F32s<S>,
}

impl<S: Level> Progress<S> {
    /// Ends the runs of the rays `of`.
    #[inline(always)]
    fn end(&mut self, looks: &SegmentLooks, of: Mask<S>) {
        let zero = F32s::zero();
        let of = of & zero.lt(self.run);
        if of.any() {
            let opacity = self.run * looks.opacities(self.segment);
            let share = (F32s::splat(1.0) - self.all) * opacity;
            self.all += of.select(share, zero);
            self.run = of.select(zero, self.run);
        }
    }

    /// Puts the rays `of` into the segments `here`.
    #[inline(always)]
    fn begin(&mut self, looks: &SegmentLooks, here: F32s<S>, of: Mask<S>) {
        self.segment = of.select(here, self.segment);
        self.technique = of.select(looks.techniques(here), self.technique);
    }
}

impl<S: Level> Packet<'_, S> {
    /// Through the segments of one volume; as [`through_labels`](Packet::through_labels), the last runs go on.
    #[inline(never)]
    pub(super) fn through_segments(&mut self, segments: &SegmentNumbers, looks: &SegmentLooks) {
        let object = &self.scenery.objects[0];
        match object.stored.as_ref().filter(|_| S::HAS_LOOPS_PER_TYPE) {
            Some(Stored::U8(voxels)) => self.by_reader(segments, looks, voxels),
            Some(Stored::U16(voxels)) => self.by_reader(segments, looks, voxels),
            Some(Stored::I16(voxels)) => self.by_reader(segments, looks, voxels),
            Some(Stored::F32(voxels)) => self.by_reader(segments, looks, voxels),
            None => self.by_reader(segments, looks, &object.values),
        }
    }

    #[inline(never)]
    fn by_reader(
        &mut self,
        segments: &SegmentNumbers,
        looks: &SegmentLooks,
        reader: &impl Reader<S>,
    ) {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let mut waiting = UnlitSegments {
                    samples: UnlitSamples::new(self.to_eye, self.runs.all.color),
                    segments: [0.0; UnlitSamples::MOST],
                };
                let progress = Progress {
                    all: self.runs.all.alpha,
                    run: self.state.alpha,
                    segment: self.runs.segment,
                    technique: self.runs.technique,
                };
                let progress = match looks.are_flat {
                    true => self.by_samples(progress, (segments, looks), reader, &mut waiting),
                    false => self.by_runs_of(progress, (segments, looks), reader, &mut waiting),
                };
                while waiting.samples.number > 0 {
                    self.light_segments((segments, looks), &mut waiting);
                }
                let sums = &waiting.samples.sums;
                let channel = inlined(
                    #[inline(always)]
                    |c: usize| F32s::from_array(lanes(|lane| sums[lane][c])),
                );
                self.runs.all.color = each!([0, 1, 2], |c| channel(c));
                self.runs.all.alpha = progress.all;
                self.state.alpha = progress.run;
                self.runs.segment = progress.segment;
                self.runs.technique = progress.technique;
            },
        );
    }

    /// Where runs make no difference.
    #[inline(always)]
    fn by_samples(
        &mut self,
        mut progress: Progress<S>,
        (segments, looks): (&SegmentNumbers, &SegmentLooks),
        reader: &impl Reader<S>,
        waiting: &mut UnlitSegments,
    ) -> Progress<S> {
        let (rays, line) = (self.rays, &self.rays.lines[0]);
        let (zero, one) = (F32s::zero(), F32s::splat(1.0));
        let object = &self.scenery.objects[0];
        let unseen = segments.unseen.as_deref();
        let cubes = unseen.and_then(|unseen| unseen.everywhere.as_ref());
        let cubes = cubes.and_then(|skip| skip.cubes(line));
        let (mut k, end) = (self.k, self.end.min(rays.count));
        let mut live = self.begin.le(k) & k.lt(end) & !looks.are_complete(progress.all);
        let mut here = Points::at(reader.shape(), line.position(k + rays.jitter));
        let mut cube = cubes.as_ref().map(|cubes| cubes.at(here.cell));
        while live.any() {
            let (mut seeing, mut jumped) = (live, k);
            if let (Some(cubes), Some(cube)) = (&cubes, &mut cube) {
                let empty = live & I32s::splat(0).lt(*cube);
                if empty.any() {
                    let jump = cubes.points(*cube, here.cell, here.position, line);
                    jumped = empty.select((k + jump).min(rays.count), k);
                    self.skipped += jumped - k;
                    if 2 * empty.count() > live.count() {
                        // The others wait, so that sampling happens for as many rays as possible.
                        k = jumped;
                        live = live & k.lt(end);
                        here = Points::at(reader.shape(), line.position(k + rays.jitter));
                        *cube = cubes.at(here.cell);
                        continue;
                    }
                    seeing = live & !empty;
                }
            }
            let next = seeing.select(k + one, jumped);
            let there = Points::at(reader.shape(), line.position(next + rays.jitter));
            let next_cube = cubes.as_ref().map(|cubes| cubes.at(there.cell));
            let value = reader.values(object, &here);
            self.sampled += seeing.select(one, zero);
            let sampled = seeing & value.is_finite();
            let may_show = sampled & looks.tables.may_show(value);
            if may_show.any() {
                let (segment, technique) = match looks.only {
                    Some(technique) => (zero, F32s::splat(technique)),
                    None => {
                        let in_cells = (here.cell, here.part());
                        let segment = segments.at_points(here.position, in_cells, may_show);
                        (segment, looks.techniques(segment))
                    }
                };
                let opacity = looks.tables.opacity_at(value, technique);
                let visible = may_show & zero.lt(opacity);
                let share = (one - progress.all) * object.of_step(opacity);
                let share = visible.select(share, zero);
                progress.all += share;
                self.visible += visible.select(one, zero);
                let of_sample = [value, share, segment];
                self.see(
                    (segments, looks),
                    waiting,
                    of_sample,
                    here.position,
                    visible,
                );
            }
            (k, here, cube) = (next, there, next_cube);
            live = live & k.lt(end) & !looks.are_complete(progress.all);
        }
        self.k = k;
        progress
    }

    /// Where runs make a difference.
    #[inline(always)]
    fn by_runs_of(
        &mut self,
        mut progress: Progress<S>,
        (segments, looks): (&SegmentNumbers, &SegmentLooks),
        reader: &impl Reader<S>,
        waiting: &mut UnlitSegments,
    ) -> Progress<S> {
        let (rays, line) = (self.rays, &self.rays.lines[0]);
        let (zero, one) = (F32s::zero(), F32s::splat(1.0));
        let finished = F32s::splat(FINISHED);
        let object = &self.scenery.objects[0];
        let unseen = segments.unseen.as_deref();
        let everywhere = unseen.and_then(|unseen| unseen.everywhere.as_ref());
        let everywhere = everywhere.and_then(|skip| skip.cubes(line));
        let in_one = unseen.and_then(|unseen| unseen.in_one.as_ref());
        let in_one = in_one.and_then(|skip| skip.cubes(line));
        let (mut k, end) = (self.k, self.end.min(rays.count));
        let mut live = self.begin.le(k) & k.lt(end) & !looks.are_complete(progress.all);
        let cubes_at = inlined(
            #[inline(always)]
            |here: &Points<S>| {
                let nothing = I32s::splat(0);
                let of_free = match &everywhere {
                    Some(cubes) => cubes.at(here.cell),
                    None => nothing,
                };
                let of_one = match &in_one {
                    Some(cubes) => cubes.at(here.cell),
                    None => nothing,
                };
                [of_free, of_one]
            },
        );
        let mut here = Points::at(reader.shape(), line.position(k + rays.jitter));
        let mut cubes_here = cubes_at(&here);
        while live.any() {
            // A run ends before anything behind it is left out, unless it may as well begin behind it.
            let is_free = progress.run.eq(zero) & progress.technique.lt(finished);
            let nothing = I32s::splat(0);
            let [free_cube, cube] = cubes_here;
            let cube = (is_free & nothing.lt(free_cube)).select_i32s(free_cube, cube);
            let empty = live & nothing.lt(cube);
            let leaping = empty & is_free & nothing.lt(free_cube);
            let (mut seeing, mut jumped) = (live, k);
            if let (true, Some(cubes)) = (empty.any(), everywhere.as_ref().or(in_one.as_ref())) {
                let jump = cubes.points(cube, here.cell, here.position, line);
                jumped = empty.select((k + jump).min(rays.count), k);
                // The others wait, so that sampling happens for as many rays as possible.
                seeing = match 2 * empty.count() > live.count() {
                    true => Mask::none(),
                    false => live & !empty,
                };
                // Whatever comes next is a new run.
                progress.segment = leaping.select(zero, progress.segment);
                progress.technique = leaping.select(zero, progress.technique);
            }
            // Rays that end here need not stand anywhere.
            let next = empty.select(jumped, seeing.select(k + one, k));
            let there = Points::at(reader.shape(), line.position(next + rays.jitter));
            let cubes_there = cubes_at(&there);
            let mut value = zero;
            let mut may_show = seeing;
            if seeing.any() {
                value = reader.values(object, &here);
                may_show = seeing & value.is_finite() & looks.tables.may_show(value);
            }
            let looking = may_show | ((seeing | empty) & !is_free);
            if looking.any() {
                let in_cells = (here.cell, here.part());
                let segment = segments.at_points(here.position, in_cells, looking);
                let changed = looking & !segment.eq(progress.segment);
                if changed.any() {
                    progress.end(looks, changed);
                    progress.begin(looks, segment, changed);
                    let complete = changed & looks.are_complete(progress.all);
                    progress.technique = complete.select(zero, progress.technique);
                    live = live & !complete;
                }
            }
            self.skipped += (empty & live).select(jumped - k, zero);
            self.sampled += (seeing & live).select(one, zero);
            let shown = zero.lt(progress.technique) & progress.technique.lt(finished);
            let showing = may_show & live & shown;
            if showing.any() {
                let opacity = looks.tables.opacity_at(value, progress.technique);
                let visible = showing & zero.lt(opacity);
                let share = (one - progress.run) * object.of_step(opacity);
                let share = visible.select(share, zero);
                progress.run += share;
                self.visible += visible.select(one, zero);
                let share = (one - progress.all) * share;
                let of_sample = [value, share, progress.segment];
                self.see(
                    (segments, looks),
                    waiting,
                    of_sample,
                    here.position,
                    visible,
                );
                let stop = F32s::splat(looks.stop_at_transmittance[0]);
                let done = showing & (one - progress.run).lt(stop);
                if done.any() {
                    progress.end(looks, done);
                    progress.technique = done.select(finished, progress.technique);
                    live = live & !(done & looks.are_complete(progress.all));
                }
            }
            k = live.select(next, k);
            (here, cubes_here) = (there, cubes_there);
            live = live & k.lt(end);
        }
        self.k = k;
        progress
    }

    /// Takes samples, each with its value, its share of the pixel and its segment, for light.
    #[inline(always)]
    fn see(
        &self,
        of: (&SegmentNumbers, &SegmentLooks),
        waiting: &mut UnlitSegments,
        [value, share, segment]: [F32s<S>; 3],
        position: Vec3s<S>,
        visible: Mask<S>,
    ) {
        visible.append(segment, &mut waiting.segments, waiting.samples.number);
        waiting.samples.push(position, value, share, visible);
        if waiting.samples.number >= LANES {
            self.light_segments(of, waiting);
        }
    }

    /// Lights as many samples as there are lanes, or all that wait, and adds them to their rays.
    #[inline(never)]
    fn light_segments(
        &self,
        (segments, looks): (&SegmentNumbers, &SegmentLooks),
        waiting: &mut UnlitSegments,
    ) {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let samples = &mut waiting.samples;
                let number = samples.number.min(LANES);
                let lane_numbers = F32s::from_array(lanes(|i| i as f32));
                let asked = lane_numbers.lt(F32s::splat(number as f32));
                let [x, y, z, value, share, ray] = samples.first();
                let position = [x, y, z];
                let ray: I32s<S> = ray.to_i32s();
                let to_eye = each!(&samples.to_eye, |to_eye| F32s::picked(to_eye, ray));
                let segment = match looks.only {
                    Some(_) if looks.are_untinted => F32s::zero(),
                    Some(_) => segments.at(position, asked),
                    None => F32s::from_start(&waiting.segments),
                };
                let technique = match looks.only {
                    Some(technique) => F32s::splat(technique),
                    None => looks.techniques(segment),
                };
                let surface = looks.tables.at(value, technique);
                let color = self.lit_color(looks, surface, technique, position, to_eye, asked);
                let tints = match looks.are_untinted {
                    true => [F32s::splat(1.0); 3],
                    false => looks.tints(segment),
                };
                let [r, g, b] = each!([0, 1, 2], |c| share * (tints[c] * color[c]));
                let seen = to_rows([r, g, b, F32s::zero()]);
                let rays = ray.to_array();
                for (seen, ray) in seen.iter().zip(rays).take(number) {
                    let sum = &mut samples.sums[ray as usize % LANES];
                    for (sum, seen) in sum.iter_mut().zip(seen) {
                        *sum += seen;
                    }
                }
                samples.drop_first(number);
                if number == LANES {
                    waiting.segments.copy_within(LANES..2 * LANES, 0);
                }
            },
        );
    }

    /// The colors of samples under the lights, by the shading of their techniques.
    #[inline(always)]
    fn lit_color(
        &self,
        looks: &SegmentLooks,
        surface: Surface<S>,
        technique: F32s<S>,
        position: Vec3s<S>,
        to_eye: Vec3s<S>,
        asked: Mask<S>,
    ) -> Vec3s<S> {
        let mut unkept = [F32s::zero(); 3];
        let objects = &self.scenery.objects;
        if looks.are_lit_alike {
            let lit = objects[0].shade(surface, position, to_eye, asked, &mut unkept);
            return lit.color;
        }
        let mut color = surface.color;
        for (i, object) in objects.iter().enumerate() {
            let own = asked & technique.eq(F32s::splat(1.0 + i as f32));
            if own.any() && !object.shading.is_unlit() {
                let lit = object.shade(surface, position, to_eye, own, &mut unkept);
                color = own.select3(lit.color, color);
            }
        }
        color
    }
}
