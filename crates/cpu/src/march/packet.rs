//! A packet of rays on its way, and what every loop does at a lattice point.

use super::counts::Counts;
use super::ray_history::RayHistory;
use super::ray_memory::RayMemory;
use super::runs::{Runs, Sum};
use crate::lanes::{F32s, LANES, Mask, Vec3s, each, lanes, to_rows};
use crate::levels::{Level, inlined, vectorized};
use crate::library::composite::{Crossing, Rule, Sample, State, with_rule};
use crate::line::{MAX_POINTS, NEVER};
use crate::ray_packet::RayPacket;
use crate::ray_state::{NUMBERS, RayState};
use crate::scenery::{Look, Object, Scenery};
use std::ops::Range;
use strahl_scene::plan::Sampling;

/// What a packet of rays sees.
pub struct Seen {
    /// Premultiplied, with what is behind.
    pub pixels: [[f32; 4]; LANES],
    /// Distance of the hit or of opaque geometry in mm, infinite without.
    pub depth_mm: [f32; LANES],
}

/// The rays of a packet on their way.
pub(super) struct Packet<'s, S: Level> {
    pub(super) scenery: &'s Scenery<'s, S>,
    pub(super) rays: &'s RayPacket<S>,
    pub(super) to_eye: Vec3s<S>,
    pub(super) state: State<S>,
    /// Number of lattice points behind each ray, in the order in which the rule goes: where it stands.
    pub(super) k: F32s<S>,
    /// It moves from there on …
    pub(super) begin: F32s<S>,
    /// … to here.
    pub(super) end: F32s<S>,
    /// See [`RayStrides::last_alpha`](crate::strides::StridesAlong::last_alpha).
    pub(super) last_alpha: F32s<S>,
    pub(super) look_back: &'s mut RayHistory<S>,
    pub(super) runs: &'s mut Runs<S>,
    pub(super) sampled: F32s<S>,
    pub(super) visible: F32s<S>,
    pub(super) skipped: F32s<S>,
}

impl<'s, S: Level> Packet<'s, S> {
    /// Rays before their first lattice point, to be moved to their ends.
    #[inline(always)]
    pub(super) fn new(
        scenery: &'s Scenery<'s, S>,
        rays: &'s RayPacket<S>,
        memory: &'s mut RayMemory<S>,
    ) -> Packet<'s, S> {
        memory.clear(scenery);
        Packet {
            scenery,
            rays,
            to_eye: each!(rays.direction, |d| -d),
            state: with_rule!(scenery.composite, rule => rule.start()),
            k: F32s::zero(),
            begin: F32s::zero(),
            end: F32s::splat(NEVER),
            last_alpha: F32s::zero(),
            look_back: &mut memory.look_back,
            runs: &mut memory.runs,
            sampled: F32s::zero(),
            visible: F32s::zero(),
            skipped: F32s::zero(),
        }
    }

    /// Becomes rays that have come as far as `states` say, to be moved through `interval` of the lattice.
    #[inline(never)]
    pub(super) fn resume(&mut self, states: &[RayState; LANES], interval: &Range<u32>) {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let mut columns = [[0.0; LANES]; NUMBERS];
                for (lane, state) in states.iter().enumerate() {
                    for (column, number) in columns.iter_mut().zip(state.numbers()) {
                        column[lane] = number;
                    }
                }
                for (number, column) in self.numbers().into_iter().zip(columns) {
                    *number = F32s::from_array(column);
                }
                let [begin, end] = [interval.start, interval.end].map(|k| {
                    let is_on_ray = f64::from(k) <= MAX_POINTS;
                    F32s::splat(if is_on_ray { k as f32 } else { NEVER })
                });
                let is_back_to_front =
                    with_rule!(self.scenery.composite, rule => rule.is_back_to_front());
                [self.begin, self.end] = if is_back_to_front {
                    let count = self.rays.count;
                    [(count - end).max(F32s::zero()), count - begin]
                } else {
                    [begin, end]
                };
            },
        );
    }

    /// Writes down how far the rays have come.
    #[inline(never)]
    pub(super) fn store(&mut self, states: &mut [RayState; LANES]) {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let mut rows = [[0.0; NUMBERS]; LANES];
                for (i, number) in self.numbers().into_iter().enumerate() {
                    for (row, number) in rows.iter_mut().zip(number.to_array()) {
                        row[i] = number;
                    }
                }
                for (state, row) in states.iter_mut().zip(rows) {
                    *state = RayState::from_numbers(row);
                }
            },
        );
    }

    /// In the order of [`RayState::numbers`].
    #[inline(always)]
    fn numbers(&mut self) -> [&mut F32s<S>; NUMBERS] {
        let State {
            color: [r, g, b],
            alpha,
            value,
            place,
            lost,
            number,
            last_normal: [nx, ny, nz],
        } = &mut self.state;
        let RayHistory {
            values: [before, begin, end],
            gradient: [gx, gy, gz],
            known,
        } = &mut *self.look_back;
        let Runs {
            segment,
            technique,
            group,
            all:
                Sum {
                    color: [seen_r, seen_g, seen_b],
                    alpha: seen_alpha,
                    weight: seen_weight,
                    number: seen_runs,
                },
            of_group:
                Sum {
                    color: [group_r, group_g, group_b],
                    alpha: group_alpha,
                    weight: group_weight,
                    number: group_runs,
                },
            by_place,
            group_by_place,
            place: hit_place,
            has_place,
        } = &mut *self.runs;
        // Segments are sampled at lattice points only, and look back at nothing.
        let [last_alpha, before, begin, end, gx, gy, gz, known] =
            match self.scenery.segments.is_some() {
                true => [
                    group_alpha,
                    group_r,
                    group_g,
                    group_b,
                    group_weight,
                    group_runs,
                    group_by_place,
                    group,
                ],
                false => [&mut self.last_alpha, before, begin, end, gx, gy, gz, known],
            };
        [
            &mut self.k,
            r,
            g,
            b,
            alpha,
            value,
            place,
            lost,
            number,
            nx,
            ny,
            nz,
            last_alpha,
            before,
            begin,
            end,
            gx,
            gy,
            gz,
            known,
            segment,
            technique,
            seen_r,
            seen_g,
            seen_b,
            seen_alpha,
            seen_weight,
            seen_runs,
            by_place,
            hit_place,
            has_place,
            &mut self.sampled,
            &mut self.visible,
            &mut self.skipped,
        ]
    }

    /// Where the rays stand, where they stop, and which of them move.
    #[inline(always)]
    pub(super) fn stand(&self) -> (F32s<S>, F32s<S>, Mask<S>) {
        let end = self.end.min(self.rays.count);
        let live = self.begin.le(self.k) & self.k.lt(end) & !self.done();
        (self.k, end, live)
    }

    /// Looks for what rules of sampling look for when the ray has ended, and counts what all has cost.
    #[inline(never)]
    pub(super) fn end(&mut self, counts: &mut Counts) {
        vectorized::<S, _>(
            #[inline(always)]
            || self.end_here(counts),
        );
    }

    #[inline(always)]
    fn end_here(&mut self, counts: &mut Counts) {
        let sees = with_rule!(self.scenery.composite, rule => rule.sees());
        if let ([object], Sampling::Refine { parts }, true) = (
            self.scenery.objects.as_slice(),
            self.scenery.plan.sampling,
            sees.is_extreme(),
        ) {
            self.refine_projection(object, parts);
        }
        let count = self.rays.count;
        let in_volume = F32s::zero().lt(count);
        counts.points += sum(count);
        counts.samples += sum(self.sampled);
        counts.visible += sum(self.visible);
        counts.skipped += sum(self.skipped);
        counts.rays_in_volume += in_volume.count();
        counts.ended_early += (in_volume & self.k.lt(count)).count();
    }

    /// The lattice points behind those that show nothing for certain, for rays of `live` that are at such; `None` if no ray
    /// is. The others wait, so that sampling happens for as many rays as possible. The caller counts what is skipped.
    #[inline(always)]
    pub(super) fn behind_nothing(
        &self,
        object: &Object<S>,
        position: Vec3s<S>,
        k: F32s<S>,
        live: Mask<S>,
    ) -> Option<F32s<S>> {
        let skip = object.skip.as_ref()?;
        let jump = skip.jump(object.values.shape(), &self.rays.lines[0], position);
        let empty = live & F32s::zero().lt(jump);
        if !empty.any() {
            return None;
        }
        Some(empty.select((k + jump).min(self.rays.count), k))
    }

    /// Which rays of `live` are to be moved on, and which of them are to be `sampled`: where many samples are rejected, only
    /// their rays, without a sample. The others wait, so that sampling happens for as many rays as possible. `extreme` is
    /// the value of the state.
    #[inline(always)]
    pub(super) fn moving_and_sampled(
        object: &Object<S>,
        position: Vec3s<S>,
        extreme: F32s<S>,
        live: Mask<S>,
        sampled: Mask<S>,
    ) -> (Mask<S>, Mask<S>) {
        if object.rejection.is_none() {
            return (live, sampled);
        }
        let seen = object.unless_rejected(position, extreme, sampled);
        let rejected = live & !seen;
        if 2 * rejected.count() > live.count() {
            (rejected, Mask::none())
        } else {
            (live, seen)
        }
    }

    /// The value of a sample, counted.
    #[inline(always)]
    pub(super) fn value(
        &mut self,
        object: &Object<S>,
        position: Vec3s<S>,
        sampled: Mask<S>,
    ) -> F32s<S> {
        self.sampled += sampled.select(F32s::splat(1.0), F32s::zero());
        object.values.at(position)
    }

    /// The look of a volume at `position` where it is not clipped.
    #[inline(always)]
    pub(super) fn look(
        &mut self,
        object: &Object<S>,
        position: Vec3s<S>,
        live: Mask<S>,
    ) -> Look<S> {
        let sampled = object.clips.keep(position, live);
        let sampled = object.unless_rejected(position, self.state.value, sampled);
        if !sampled.any() {
            return Look::nothing();
        }
        let value = self.value(object, position, sampled);
        object.look(
            value,
            position,
            self.to_eye,
            sampled & value.is_finite(),
            &mut self.state.last_normal,
        )
    }

    /// Adds lattice point `k` of the rays `sampled` by the rule of `object`, for as many as a `stride` has where there are
    /// strides; says which of them it showed something for.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        object: &Object<S>,
        k: F32s<S>,
        position: Vec3s<S>,
        sampled: Mask<S>,
        value: F32s<S>,
        stride: F32s<S>,
    ) -> Mask<S> {
        let sample = Sample {
            crossing: Crossing {
                scenery: self.scenery,
                object,
                packet: self.rays,
                to_eye: &self.to_eye,
            },
            k,
            stride,
            position,
            value,
            sampled,
        };
        with_rule!(object.composite, rule => rule.add(&mut self.state, &sample))
    }

    /// Color, and opacity of one step, of a value of `object`.
    #[inline(always)]
    pub(super) fn classified(
        &mut self,
        object: &Object<S>,
        value: F32s<S>,
        position: Vec3s<S>,
        sampled: Mask<S>,
    ) -> Look<S> {
        object.look(
            value,
            position,
            self.to_eye,
            sampled,
            &mut self.state.last_normal,
        )
    }

    /// Which rays need no more.
    #[inline(always)]
    pub(super) fn done(&self) -> Mask<S> {
        with_rule!(self.scenery.composite, rule => rule.done(&self.state))
    }

    /// The rule's own end, then what is behind under everything.
    #[inline(never)]
    pub(super) fn finish(&mut self) -> Seen {
        vectorized::<S, _>(
            #[inline(always)]
            || self.finish_here(),
        )
    }

    #[inline(always)]
    fn finish_here(&mut self) -> Seen {
        let to_eye = self.to_eye;
        let crossing = Crossing {
            scenery: self.scenery,
            object: &self.scenery.objects[0],
            packet: self.rays,
            to_eye: &to_eye,
        };
        let hit = if self.scenery.segments.is_some() {
            self.end_last_runs()
        } else {
            with_rule!(self.scenery.composite, rule => {
                rule.finish(&mut self.state, &crossing);
                match rule.has_depth() {
                    true => F32s::zero().lt(self.state.alpha),
                    false => Mask::none(),
                }
            })
        };
        let State { color, alpha, .. } = self.state;
        let behind = F32s::splat(1.0) - alpha;
        let over = inlined(
            #[inline(always)]
            |c: F32s<S>, channel: usize| c + behind * self.rays.behind[channel],
        );
        let [r, g, b] = each!([0, 1, 2], |c| over(color[c], c));
        let a = over(alpha, 3);
        let depth_mm = if self.scenery.plan.with_depth {
            let distance = crossing.distance_mm(self.state.place);
            let is_hit = hit.select(F32s::splat(1.0), F32s::zero());
            lanes(|i| {
                if is_hit.lane(i) > 0.0 {
                    distance.lane(i)
                } else {
                    self.rays.opaque_mm[i] as f32
                }
            })
        } else {
            [f32::INFINITY; LANES]
        };
        Seen {
            pixels: to_rows([r, g, b, a]),
            depth_mm,
        }
    }
}

/// Each lane is a whole number of at most 2^24, exact in f32.
#[inline(always)]
fn sum<S: Level>(numbers: F32s<S>) -> u64 {
    let numbers = numbers.to_i32s().to_array();
    numbers.iter().map(|&number| number as u64).sum()
}
