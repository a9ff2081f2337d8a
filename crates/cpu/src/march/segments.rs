//! Steps in parts, or integrated: where the transfer function shows something between the values of two lattice points
//! in a row, samples lie closer, or all that lies between is one sample.
//!
//! The segment k of a ray goes from lattice point k − 1 to k. The first one begins before the ray enters, one more
//! behind the last lattice point ends when it has left; the points outside have the values at the border, as everywhere,
//! and of such segments only what lies inside is sampled. A segment shows nothing if the transfer function shows
//! nothing from one end's value to the other's. So does one between two bricks that show nothing and have a voxel in
//! common: then the ranges of both overlap, and together they reach from one end's value to the other's. That is what
//! skipping rests on here; segments that are longer than a brick are looked at wherever they leave one.

use super::packet::Packet;
use super::ray_history::RayHistory;
use crate::brick_number::EDGE;
use crate::lanes::{F32s, Mask, Vec3s, each};
use crate::levels::{Level, inlined, vectorized};
use crate::library::classify::{Integrals, Surface};
use crate::library::composite::emission_absorption;
use crate::line::Line;
use crate::scenery::{Look, Object};
use strahl_scene::plan::Curve;

/// How the samples inside a segment get their values.
#[derive(Clone, Copy)]
pub(super) enum Inside {
    /// From the volume.
    Reconstructed,
    /// From those of lattice points.
    Between(Curve),
}

/// What of a segment is shown.
#[derive(Clone, Copy)]
pub(super) enum Shown<'i> {
    /// So many samples in each step.
    InParts(u32, Inside),
    /// The integral over what lies between both ends.
    AsIntegrals(&'i Integrals),
}

/// Values of four lattice points in a row, as far as they are known: the two before the end of a segment, the end,
/// and the next one.
struct Window<S: Level> {
    /// The end of the segment.
    end: F32s<S>,
    values: [F32s<S>; 4],
    known: [Mask<S>; 4],
    /// The gradient at the lattice point `gradient_at`.
    gradient: Vec3s<S>,
    gradient_at: F32s<S>,
}

/// Places in a [`Window`].
const BEFORE: usize = 0;
const BEGIN: usize = 1;
const END: usize = 2;
const AFTER: usize = 3;

/// A segment of each ray.
#[derive(Clone, Copy)]
struct Segment<S: Level> {
    /// Number of the lattice point at its end.
    k: F32s<S>,
    /// Where it shows something.
    shows: Mask<S>,
    /// The values at its ends.
    ends: [F32s<S>; 2],
}

impl<S: Level> Window<S> {
    /// That before segment `k`.
    #[inline(always)]
    fn new(back: &RayHistory<S>, k: F32s<S>) -> Window<S> {
        let before = k - F32s::splat(1.0);
        let [a, b, c] = back.values;
        Window {
            end: before,
            values: [F32s::zero(), a, b, c],
            known: [Mask::none(), back.knows(0), back.knows(1), back.knows(2)],
            gradient: back.gradient,
            gradient_at: back.knows(3).select(before, F32s::splat(-9.0)),
        }
    }

    /// What is known when the ray stands at the end of segment `k`, which is not looked at yet.
    #[inline(always)]
    fn look_back(&self, k: F32s<S>) -> RayHistory<S> {
        let before = k - F32s::splat(1.0);
        let follows = self.end.eq(before);
        let [_, a, b, c] = self.values;
        let bit = inlined(
            #[inline(always)]
            |known: Mask<S>, bit: f32| known.select(F32s::splat(bit), F32s::zero()),
        );
        let [_, has_a, has_b, has_c] = self.known;
        RayHistory {
            values: [a, b, c],
            gradient: self.gradient,
            known: bit(follows & has_a, 1.0)
                + bit(follows & has_b, 2.0)
                + bit(follows & has_c, 4.0)
                + bit(self.gradient_at.eq(before), 8.0),
        }
    }

    /// Becomes the window of segment `k` of the rays `moved`.
    #[inline(always)]
    fn move_to(&mut self, k: F32s<S>, moved: Mask<S>) {
        let by_one = moved & (self.end + F32s::splat(1.0)).eq(k);
        for place in [BEFORE, BEGIN, END] {
            self.values[place] = by_one.select(self.values[place + 1], self.values[place]);
            self.known[place] = (by_one & self.known[place + 1]) | (self.known[place] & !moved);
        }
        self.known[AFTER] = self.known[AFTER] & !moved;
        self.end = moved.select(k, self.end);
    }
}

impl<S: Level> Packet<'_, S> {
    /// Front to back through one volume, segment by segment.
    #[inline(never)]
    pub(super) fn by_segments(&mut self, object: &Object<S>, shown: Shown) {
        vectorized::<S, _>(
            #[inline(always)]
            || self.by_segments_here(object, shown),
        );
    }

    #[inline(always)]
    fn by_segments_here(&mut self, object: &Object<S>, shown: Shown) {
        let (rays, line) = (self.rays, &self.rays.lines[0]);
        let (zero, one) = (F32s::zero(), F32s::splat(1.0));
        // How many lattice points from `k` on show nothing for certain; they lie in one empty cube.
        let jump_at = inlined(
            #[inline(always)]
            |k: F32s<S>| match &object.skip {
                Some(skip) => {
                    let position = line.position(k + rays.jitter);
                    skip.jump(object.values.shape(), line, position)
                }
                None => zero,
            },
        );
        let last = zero.lt(rays.tail).select(rays.count, rays.count - one);
        let neighbors = ends_in_neighbors(line);
        let (mut k, stop) = (self.k, self.end);
        let mut window = Window::new(self.look_back, k);
        let has_segments = match shown {
            Shown::InParts(..) => zero.lt(rays.count),
            // A ray between two lattice points is a segment as well.
            Shown::AsIntegrals(_) => zero.lt(rays.tail),
        };
        let stands = self.begin.le(k) & k.lt(stop) & k.le(last);
        let mut live = has_segments & stands & !self.done();
        // Whether the beginning of segment `k` shows nothing for certain.
        let mut nothing_before = zero.lt(jump_at(k - one));
        while live.any() {
            let jump = jump_at(k);
            let nothing_here = zero.lt(jump);
            let empty = live & nothing_before & nothing_here & neighbors;
            if empty.any() {
                // The others wait, so that segments are looked at for as many rays as possible.
                let next = empty.select(k + jump, k);
                self.skipped += next.min(rays.count) - k.min(rays.count);
                k = next;
                live = live & k.le(last) & k.lt(stop);
                continue;
            }
            window.move_to(k, live);
            self.know(&mut window, object, BEGIN, live);
            self.know(&mut window, object, END, live);
            // An end without a value takes the other's.
            let (begin, end) = (window.values[BEGIN], window.values[END]);
            let (has_begin, has_end) = (begin.is_finite(), end.is_finite());
            let ends = [has_begin.select(begin, end), has_end.select(end, begin)];
            let may_show = match &object.between {
                Some(between) => between.any(ends[0].min(ends[1]), ends[0].max(ends[1])),
                None => live,
            };
            let shows = live & (has_begin | has_end) & may_show;
            if shows.any() {
                let segment = Segment { k, shows, ends };
                match shown {
                    Shown::InParts(parts, inside) => {
                        self.add_segment(object, &mut window, &segment, parts, inside);
                    }
                    Shown::AsIntegrals(integrals) => {
                        self.add_integral(object, integrals, &segment);
                    }
                }
            }
            // Segments between the points of an empty cube show nothing either.
            let next = k + jump.max(one);
            self.skipped += live.select(next.min(rays.count) - (k + one).min(rays.count), zero);
            nothing_before = (live & nothing_here) | (nothing_before & !live);
            k = live.select(next, k);
            live = live & k.le(last) & k.lt(stop) & !self.done();
        }
        *self.look_back = window.look_back(k);
        self.k = k;
    }

    /// Finds the values at `place` of the window where they are `wanted` and not known.
    #[inline(always)]
    fn know(&mut self, window: &mut Window<S>, object: &Object<S>, place: usize, wanted: Mask<S>) {
        let lacking = wanted & !window.known[place];
        if lacking.any() {
            let point = window.end + F32s::splat(place as f32 - END as f32);
            let position = self.rays.lines[0].position(point + self.rays.jitter);
            let value = self.value(object, position, lacking);
            window.values[place] = lacking.select(value, window.values[place]);
            window.known[place] = window.known[place] | lacking;
        }
    }

    /// Adds the samples of a segment.
    #[inline(always)]
    fn add_segment(
        &mut self,
        object: &Object<S>,
        window: &mut Window<S>,
        segment: &Segment<S>,
        parts: u32,
        inside: Inside,
    ) {
        let (rays, line) = (self.rays, &self.rays.lines[0]);
        let (zero, one) = (F32s::zero(), F32s::splat(1.0));
        let Segment { k, shows, ends } = *segment;
        let mut around = ends;
        if let Inside::Between(Curve::Cubic) = inside {
            self.know(window, object, BEFORE, shows);
            self.know(window, object, AFTER, shows);
            let (before, after) = (window.values[BEFORE], window.values[AFTER]);
            around = [
                before.is_finite().select(before, ends[0]),
                after.is_finite().select(after, ends[1]),
            ];
        }
        let is_lit = !object.shading.is_unlit();
        let gradients = match inside {
            Inside::Between(_) if is_lit => self.gradients(object, window, segment),
            _ => [[zero; 3]; 2],
        };
        let not_first = zero.lt(k);
        let not_tail = k.lt(rays.count);
        for j in 1..=parts {
            let part = j as f32 / parts as f32;
            let in_step = rays.jitter + F32s::splat(part - 1.0);
            let in_ray =
                (not_first | zero.le(in_step)) & (not_tail | F32s::splat(j as f32).le(rays.tail));
            let sampled = shows & in_ray & !self.done();
            let position = line.position(k + in_step);
            let sampled = object.clips.keep(position, sampled);
            if !sampled.any() {
                continue;
            }
            let value = match inside {
                Inside::Reconstructed if j == parts => window.values[END],
                Inside::Reconstructed => self.value(object, position, sampled),
                // Exactly, which no curve is sure to give.
                Inside::Between(_) if j == parts => ends[1],
                Inside::Between(Curve::Linear) => ends[0].lerp(ends[1], F32s::splat(part)),
                Inside::Between(Curve::Cubic) => cubic(around[0], ends, around[1], part),
            };
            let sampled = sampled & value.is_finite();
            let look = match inside {
                Inside::Between(_) if is_lit => {
                    self.look_between(object, value, gradients, part, position, sampled)
                }
                _ => self.classified(object, value, position, sampled),
            };
            let Surface { color, opacity } = look.surface;
            emission_absorption::add(&mut self.state, look.visible, color, opacity);
            self.visible += look.visible.select(one, zero);
        }
    }

    /// Adds a segment as one sample: the integral over the values from one end to the other, with the clips and the
    /// light of its middle.
    #[inline(never)]
    fn add_integral(&mut self, object: &Object<S>, integrals: &Integrals, segment: &Segment<S>) {
        vectorized::<S, _>(
            #[inline(always)]
            || self.add_integral_here(object, integrals, segment),
        );
    }

    #[inline(always)]
    fn add_integral_here(
        &mut self,
        object: &Object<S>,
        integrals: &Integrals,
        segment: &Segment<S>,
    ) {
        let (rays, line) = (self.rays, &self.rays.lines[0]);
        let (zero, one, half) = (F32s::zero(), F32s::splat(1.0), F32s::splat(0.5));
        let Segment { k, shows, ends } = *segment;
        // Where on the segment the ray begins and ends.
        let (is_first, is_tail) = (k.eq(zero), k.eq(rays.count));
        let from = is_first.select(one - rays.jitter, zero);
        let to = is_tail.select(rays.tail, one);
        let share = to - from;
        let middle = k + (rays.jitter + (from + to) * half - one);
        let position = line.position(middle);
        let sampled = object.clips.keep(position, shows & zero.lt(share));
        if !sampled.any() {
            return;
        }
        let begin = is_first.select(ends[0].lerp(ends[1], from), ends[0]);
        let end = is_tail.select(ends[0].lerp(ends[1], to), ends[1]);
        let look = object.look_of_segment(
            integrals,
            [begin, end],
            share,
            position,
            self.to_eye,
            sampled,
            &mut self.state.last_normal,
        );
        let Surface { color, opacity } = look.surface;
        emission_absorption::add(&mut self.state, look.visible, color, opacity);
        self.visible += look.visible.select(one, zero);
    }

    /// The gradients at both ends of a segment.
    #[inline(always)]
    fn gradients(
        &mut self,
        object: &Object<S>,
        window: &mut Window<S>,
        segment: &Segment<S>,
    ) -> [Vec3s<S>; 2] {
        let line = &self.rays.lines[0];
        let (k, jitter) = (segment.k, self.rays.jitter);
        let before = k - F32s::splat(1.0);
        let lacking = segment.shows & !window.gradient_at.eq(before);
        let mut begin = window.gradient;
        if lacking.any() {
            let gradient = object.gradient(line.position(before + jitter), lacking);
            begin = lacking.select3(gradient, begin);
        }
        let end = object.gradient(line.position(k + jitter), segment.shows);
        window.gradient = segment.shows.select3(end, window.gradient);
        window.gradient_at = segment.shows.select(k, window.gradient_at);
        [begin, end]
    }

    /// The look of a value inside a segment under light: the gradient lies on the line between those at the ends.
    #[inline(always)]
    fn look_between(
        &mut self,
        object: &Object<S>,
        value: F32s<S>,
        [begin, end]: [Vec3s<S>; 2],
        part: f32,
        position: Vec3s<S>,
        sampled: Mask<S>,
    ) -> Look<S> {
        let gradient = if part == 1.0 {
            end
        } else {
            each!([0, 1, 2], |c| begin[c].lerp(end[c], F32s::splat(part)))
        };
        object.look_by(
            value,
            gradient,
            position,
            self.to_eye,
            sampled,
            &mut self.state.last_normal,
        )
    }
}

/// Where steps are so short that lattice points in a row lie in the same brick or in neighbors, which have a voxel
/// in common.
#[inline(always)]
fn ends_in_neighbors<S: Level>(line: &Line<S>) -> Mask<S> {
    // A little less than the edge: positions are rounded.
    let most = F32s::splat(0.99 * EDGE as f32);
    let [x, y, z] = each!(line.step_in_voxel, |step| step.abs().le(most));
    x & y & z
}

/// J. Lagrange's cubic through four values at −1, 0, 1, 2, at `part` from 0 to 1 and cut to between the middle ones.
/// (What lies beyond both would be shown nowhere else: whether a segment is looked at rests on its ends.)
#[inline(always)]
fn cubic<S: Level>(
    before: F32s<S>,
    [begin, end]: [F32s<S>; 2],
    after: F32s<S>,
    part: f32,
) -> F32s<S> {
    let t = part;
    let weights = [
        -t * (t - 1.0) * (t - 2.0) / 6.0,
        (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
        -(t + 1.0) * t * (t - 2.0) / 2.0,
        (t + 1.0) * t * (t - 1.0) / 6.0,
    ]
    .map(F32s::splat);
    let value = before * weights[0] + begin * weights[1] + end * weights[2] + after * weights[3];
    // Numbers so large that a product overflows leave NaN, which `max` takes for the other number.
    value.max(begin.min(end)).min(begin.max(end))
}
