//! Front to back through segments whose samples and whose runs all add up by emission and absorption
//! ([`SegmentLooks`]). What [`Packet::through_labels`] does with any rules, up to rounding:
//!
//! - Which segment a place is in is asked where that matters; where no run is multiplied by an opacity, runs make no
//!   difference, and that is wherever a sample may be visible.
//! - All tables are looked up at once, and lit samples are collected until every lane has one. They are added to the
//!   pixel, not to the run: a run of opacity o that begins behind an opacity of A shows (1 − A)·o of each.

use super::packet::Packet;
use super::points::Points;
use super::reader::Reader;
use super::unlit_samples::{Batch, UnlitSamples};
use crate::lanes::{F32s, I32s, LANES, Mask, Vec3s, each};
use crate::levels::{Level, inlined, vectorized};
use crate::scenery::Stored;
use crate::segment_looks::{FINISHED, SegmentLooks};
use crate::segment_numbers::SegmentNumbers;

/// Samples that are to be lit, and the segments that they are in.
struct UnlitSegments {
    samples: UnlitSamples,
    segments: [f32; UnlitSamples::MOST],
}

impl UnlitSegments {
    /// None yet of the rays of `packet`.
    #[inline(always)]
    fn new<S: Level>(packet: &Packet<S>) -> UnlitSegments {
        UnlitSegments {
            samples: UnlitSamples::new(packet.to_eye, packet.runs.all.color),
            segments: [0.0; UnlitSamples::MOST],
        }
    }
}

/// How far the runs of a packet have come.
#[derive(Clone, Copy)]
struct Progress<S: Level> {
    /// The opacity of all runs that have ended.
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

    /// Takes note that the rays `looking` are in the segments `here`; says which of them need no more.
    #[inline(always)]
    fn look(&mut self, looks: &SegmentLooks, here: F32s<S>, looking: Mask<S>) -> Mask<S> {
        let changed = looking & !here.eq(self.segment);
        if !changed.any() {
            return changed;
        }
        self.end(looks, changed);
        let complete = changed & looks.are_complete(self.all);
        let technique = complete.select(F32s::zero(), looks.techniques(here));
        self.segment = changed.select(here, self.segment);
        self.technique = changed.select(technique, self.technique);
        complete
    }

    /// Adds samples of this opacity, where `visible`, to the runs; their shares of the pixel before the opacity of the
    /// segments.
    #[inline(always)]
    fn add(&mut self, visible: Mask<S>, opacity: F32s<S>) -> F32s<S> {
        let one = F32s::splat(1.0);
        let share = visible.select((one - self.run) * opacity, F32s::zero());
        self.run += share;
        (one - self.all) * share
    }

    /// Ends runs of the rays `of` that pass too little; says which of the rays need no more.
    #[inline(always)]
    fn finish(&mut self, looks: &SegmentLooks, of: Mask<S>) -> Mask<S> {
        let [of_run, _] = looks.stop_at_transmittance;
        let done = of & (F32s::splat(1.0) - self.run).lt(F32s::splat(of_run));
        if !done.any() {
            return done;
        }
        self.end(looks, done);
        self.technique = done.select(F32s::splat(FINISHED), self.technique);
        done & looks.are_complete(self.all)
    }
}

impl<S: Level> Packet<'_, S> {
    /// Through the segments of one volume; as [`through_labels`](Packet::through_labels), the last runs go on.
    #[inline(never)]
    pub(super) fn through_segments(&mut self, segments: &SegmentNumbers, looks: &SegmentLooks) {
        let of = (segments, looks);
        let object = &self.scenery.objects[0];
        if !looks.are_flat {
            return self.by_runs_of_segments(of);
        }
        match object.stored.as_ref().filter(|_| S::HAS_LOOPS_PER_TYPE) {
            Some(Stored::U8(voxels)) => self.by_samples(of, voxels),
            Some(Stored::U16(voxels)) => self.by_samples(of, voxels),
            Some(Stored::I16(voxels)) => self.by_samples(of, voxels),
            Some(Stored::F32(voxels)) => self.by_samples(of, voxels),
            None => self.by_samples(of, &object.values),
        }
    }

    /// Where runs make no difference.
    #[inline(never)]
    fn by_samples(&mut self, of: (&SegmentNumbers, &SegmentLooks), reader: &impl Reader<S>) {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let (segments, looks) = of;
                let (zero, one) = (F32s::zero(), F32s::splat(1.0));
                let object = &self.scenery.objects[0];
                let unseen = segments.unseen.as_deref();
                let cubes = unseen.and_then(|unseen| unseen.everywhere.as_ref());
                let cubes = cubes.and_then(|skip| skip.cubes(&self.rays.lines[0]));
                let mut waiting = UnlitSegments::new(self);
                // The ray ends by what all samples add up to.
                self.state.alpha = self.runs.all.alpha;
                self.walk(
                    object,
                    reader,
                    cubes,
                    #[inline(always)]
                    |packet, here, sample| {
                        let asked = sample.sampled & looks.tables.may_show(sample.value);
                        if !asked.any() {
                            return asked;
                        }
                        let (segment, technique) = match looks.only {
                            Some(technique) => (zero, F32s::splat(technique)),
                            None => {
                                let in_cells = (here.cell, here.part());
                                let segment = segments.at_points(here.position, in_cells, asked);
                                (segment, looks.techniques(segment))
                            }
                        };
                        let opacity = looks.tables.opacity_at(sample.value, technique);
                        let visible = asked & zero.lt(opacity);
                        let share = (one - packet.state.alpha) * object.of_step(opacity);
                        let share = visible.select(share, zero);
                        packet.state.alpha += share;
                        let of_sample = [sample.value, share, segment];
                        packet.see(of, &mut waiting, of_sample, here.position, visible);
                        visible
                    },
                );
                self.light_all_segments(of, &mut waiting);
                self.runs.all.alpha = self.state.alpha;
                self.state.alpha = zero;
            },
        );
    }

    /// Where runs make a difference.
    #[inline(never)]
    fn by_runs_of_segments(&mut self, of: (&SegmentNumbers, &SegmentLooks)) {
        vectorized::<S, _>(
            #[inline(always)]
            || self.by_runs_of_segments_here(of),
        );
    }

    #[inline(always)]
    fn by_runs_of_segments_here(&mut self, of: (&SegmentNumbers, &SegmentLooks)) {
        let (segments, looks) = of;
        let mut waiting = UnlitSegments::new(self);
        let mut progress = Progress {
            all: self.runs.all.alpha,
            run: self.state.alpha,
            segment: self.runs.segment,
            technique: self.runs.technique,
        };
        let (rays, line) = (self.rays, &self.rays.lines[0]);
        let (zero, one) = (F32s::zero(), F32s::splat(1.0));
        let finished = F32s::splat(FINISHED);
        let object = &self.scenery.objects[0];
        let shape = object.values.shape();
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
        let mut here = Points::at(shape, line.position(k + rays.jitter));
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
            let there = Points::at(shape, line.position(next + rays.jitter));
            let cubes_there = cubes_at(&there);
            let mut value = zero;
            let mut may_show = seeing;
            if seeing.any() {
                value = object.values.at(here.position);
                may_show = seeing & value.is_finite() & looks.tables.may_show(value);
            }
            let looking = may_show | ((seeing | empty) & !is_free);
            if looking.any() {
                let in_cells = (here.cell, here.part());
                let segment = segments.at_points(here.position, in_cells, looking);
                live = live & !progress.look(looks, segment, looking);
            }
            self.skipped += (empty & live).select(jumped - k, zero);
            self.sampled += (seeing & live).select(one, zero);
            let shown = zero.lt(progress.technique) & progress.technique.lt(finished);
            let showing = may_show & live & shown;
            if showing.any() {
                let opacity = looks.tables.opacity_at(value, progress.technique);
                let visible = showing & zero.lt(opacity);
                self.visible += visible.select(one, zero);
                let share = progress.add(visible, object.of_step(opacity));
                let of_sample = [value, share, progress.segment];
                self.see(of, &mut waiting, of_sample, here.position, visible);
                live = live & !progress.finish(looks, showing);
            }
            k = live.select(next, k);
            (here, cubes_here) = (there, cubes_there);
            live = live & k.lt(end);
        }
        self.k = k;
        self.light_all_segments(of, &mut waiting);
        self.runs.all.alpha = progress.all;
        self.state.alpha = progress.run;
        self.runs.segment = progress.segment;
        self.runs.technique = progress.technique;
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

    /// Lights all samples that wait; the runs have the colors that they add up to.
    #[inline(always)]
    fn light_all_segments(
        &mut self,
        of: (&SegmentNumbers, &SegmentLooks),
        waiting: &mut UnlitSegments,
    ) {
        if waiting.samples.number > 0 {
            self.light_segments(of, waiting);
        }
        self.runs.all.color = waiting.samples.colors();
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
                let batch = waiting.samples.batch();
                let segment = match looks.only {
                    Some(_) if looks.are_untinted => F32s::zero(),
                    Some(_) => segments.at(batch.position, batch.asked),
                    None => F32s::from_start(&waiting.segments),
                };
                let technique = match looks.only {
                    Some(technique) => F32s::splat(technique),
                    None => looks.techniques(segment),
                };
                let mut color = self.lit_color(looks, &batch, technique);
                if !looks.are_untinted {
                    let tints = looks.tints(segment);
                    color = each!([0, 1, 2], |c| tints[c] * color[c]);
                }
                waiting.samples.add(&batch, color);
                if batch.number == LANES {
                    waiting.segments.copy_within(LANES..2 * LANES, 0);
                }
            },
        );
    }

    /// The colors of samples under the lights, by the shading of their techniques.
    #[inline(always)]
    fn lit_color(&self, looks: &SegmentLooks, batch: &Batch<S>, technique: F32s<S>) -> Vec3s<S> {
        let mut unkept = [F32s::zero(); 3];
        let objects = &self.scenery.objects;
        let (position, to_eye) = (batch.position, batch.to_eye);
        let surface = looks.tables.at(batch.value, technique);
        if looks.are_lit_alike {
            let lit = objects[0].shade(surface, position, to_eye, batch.asked, &mut unkept);
            return lit.color;
        }
        let mut color = surface.color;
        for (i, object) in objects.iter().enumerate() {
            let own = batch.asked & technique.eq(F32s::splat(1.0 + i as f32));
            if own.any() && !object.shading.is_unlit() {
                let lit = object.shade(surface, position, to_eye, own, &mut unkept);
                color = own.select3(lit.color, color);
            }
        }
        color
    }
}
