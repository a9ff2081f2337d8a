//! The ray loop of most pictures: emission and absorption through a table, the first hit, or rules that draw many samples
//! of every ray, in one volume of trilinear values. It gives the bytes of [`Packet::forwards`], which does the same with any functions.
//!
//! What it does otherwise: it is compiled for each type of sample, so that position and cell serve the
//! bricks and the voxels; the brick of the next lattice point is asked for before this one is sampled, so
//! that the answer need not be waited for; and lit samples are collected until every lane has one (the
//! opacity, which decides what later samples count for, needs no light).

use super::packet::Packet;
use super::points::Points;
use super::reader::Reader;
use super::unlit_samples::UnlitSamples;
use crate::lanes::{F32s, I32s, LANES, Mask};
use crate::levels::{Level, vectorized};
use crate::library::classify::Surface;
use crate::library::composite::context_preserving::ContextPreserving;
use crate::library::composite::first_hit::FirstHit;
use crate::library::composite::importance_aware::ImportanceAware;
use crate::library::composite::mida::Mida;
use crate::library::composite::{self, Crossing, Rule, emission_absorption};
use crate::library::fetch::Linear;
use crate::scenery::{Object, Stored};
use crate::skip::Cubes;
use strahl_scene::plan::Composite;
use strahl_volume::Sample;

impl<S: Level> Packet<'_, S> {
    /// Front to back through the voxels `stored` of `object`, for which [`Object::stored_for`] gave them.
    #[inline(always)]
    pub(super) fn through_voxels(&mut self, object: &Object<S>, stored: &Stored) {
        match stored {
            Stored::U8(voxels) => self.through(object, voxels),
            Stored::U16(voxels) => self.through(object, voxels),
            Stored::I16(voxels) => self.through(object, voxels),
            Stored::F32(voxels) => self.through(object, voxels),
        }
    }

    #[inline(always)]
    fn through<T: Sample>(&mut self, object: &Object<S>, voxels: &Linear<T>) {
        match self.scenery.composite {
            Composite::FirstHit { threshold } => {
                self.until_hit(object, voxels, FirstHit { threshold });
            }
            Composite::Mida {
                low,
                high,
                blend,
                stop_at_transmittance,
            } => {
                let rule = Mida {
                    low,
                    high,
                    blend,
                    stop_at_transmittance,
                };
                self.by_rule_of(object, voxels, rule);
            }
            Composite::ContextPreserving {
                cut_depth,
                cut_sharpness,
                full_per_mm,
                nearest_mm,
                farthest_mm,
                stop_at_transmittance,
                covered_by,
            } => {
                let rule = ContextPreserving {
                    cut_depth,
                    cut_sharpness,
                    full_per_mm,
                    nearest_mm,
                    farthest_mm,
                    stop_at_transmittance,
                    covered_by,
                };
                self.by_rule_of(object, voxels, rule);
            }
            Composite::ImportanceAware {
                measure,
                gain,
                first,
                second,
                third,
                full_per_mm,
                low,
                high,
            } => {
                let rule = ImportanceAware {
                    measure,
                    gain,
                    first,
                    second,
                    third,
                    full_per_mm,
                    low,
                    high,
                };
                self.by_rule_of(object, voxels, rule);
            }
            _ if object.shading.is_unlit() => self.unlit(object, voxels),
            _ => self.lit(object, voxels),
        }
    }

    #[inline(never)]
    fn until_hit<T: Sample>(&mut self, object: &Object<S>, voxels: &Linear<T>, rule: FirstHit) {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                self.walk(
                    object,
                    voxels,
                    self.cubes(object),
                    #[inline(always)]
                    |packet, _, sample| {
                        rule.meet(&mut packet.state, sample.k, sample.value, sample.sampled)
                    },
                );
            },
        );
    }

    #[inline(never)]
    fn by_rule_of<T: Sample>(&mut self, object: &Object<S>, voxels: &Linear<T>, rule: impl Rule) {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                self.walk(
                    object,
                    voxels,
                    self.cubes(object),
                    #[inline(always)]
                    |packet, _, sample| rule.add(&mut packet.state, sample),
                );
            },
        );
    }

    #[inline(never)]
    fn unlit<T: Sample>(&mut self, object: &Object<S>, voxels: &Linear<T>) {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                self.walk(
                    object,
                    voxels,
                    self.cubes(object),
                    #[inline(always)]
                    |packet, _, sample| {
                        let Surface { color, opacity } = object.table.at(sample.value);
                        let visible = sample.sampled & F32s::zero().lt(opacity);
                        let opacity = object.of_stride(object.of_step(opacity), sample.stride);
                        emission_absorption::add(&mut packet.state, visible, color, opacity);
                        visible
                    },
                )
            },
        )
    }

    #[inline(never)]
    fn lit<T: Sample>(&mut self, object: &Object<S>, voxels: &Linear<T>) {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let mut waiting = UnlitSamples::new(self.to_eye, self.state.color);
                self.walk(
                    object,
                    voxels,
                    self.cubes(object),
                    #[inline(always)]
                    |packet, _, sample| {
                        let mut alpha = packet.state.alpha;
                        let visible = packet.collect(object, &mut alpha, &mut waiting, sample);
                        packet.state.alpha = alpha;
                        visible
                    },
                );
                self.light_all(object, &mut waiting);
            },
        );
    }

    /// What can be left out of `object`.
    #[inline(always)]
    fn cubes<'o>(&self, object: &'o Object<S>) -> Option<Cubes<'o, S>> {
        let skip = object.skip.as_ref()?;
        skip.cubes(&self.rays.lines[0])
    }

    /// From lattice point to lattice point, leaving out the `cubes` that show nothing; `see` adds a sample at some points to
    /// the rays that are sampled, and says for which of them it showed something.
    #[inline(always)]
    pub(super) fn walk(
        &mut self,
        object: &Object<S>,
        reader: &impl Reader<S>,
        cubes: Option<Cubes<S>>,
        mut see: impl FnMut(&mut Self, &Points<S>, &composite::Sample<S>) -> Mask<S>,
    ) {
        let (rays, line) = (self.rays, &self.rays.lines[0]);
        let one = F32s::splat(1.0);
        let to_eye = self.to_eye;
        let crossing = Crossing {
            scenery: self.scenery,
            object,
            packet: rays,
            to_eye: &to_eye,
        };
        let shape = reader.shape();
        let strides = object.strides.as_ref();
        let mut strides = strides.map(|strides| strides.along(line, self.last_alpha));
        let (mut k, end, mut live) = self.stand();
        if !live.any() {
            return;
        }
        let mut here = Points::at(shape, line.position(k + rays.jitter));
        let mut cube = cubes.as_ref().map(|cubes| cubes.at(here.cell));
        loop {
            let mut seeing = live;
            let mut jumped = k;
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
                        if !live.any() {
                            break;
                        }
                        here = Points::at(shape, line.position(k + rays.jitter));
                        *cube = cubes.at(here.cell);
                        continue;
                    }
                    seeing = live & !empty;
                }
            }
            let stride = match &mut strides {
                Some(strides) => strides.at(here.cell, seeing, self.state.alpha, rays.count - k),
                None => one,
            };
            let next = seeing.select(k + stride, jumped);
            let there = Points::at(shape, line.position(next + rays.jitter));
            let next_cube = cubes.as_ref().map(|cubes| cubes.at(there.cell));
            let value = reader.values(object, &here);
            self.sampled += seeing.select(one, F32s::zero());
            let sample = composite::Sample {
                crossing,
                k,
                stride,
                position: here.position,
                value,
                // What is not finite is no value.
                sampled: seeing & value.is_finite(),
            };
            let visible = see(self, &here, &sample);
            self.visible += visible.select(one, F32s::zero());
            (k, here, cube) = (next, there, next_cube);
            live = live & k.lt(end) & !self.done();
            if !live.any() {
                break;
            }
        }
        self.k = k;
        if let Some(strides) = strides {
            self.last_alpha = strides.last_alpha;
        }
    }

    /// Adds the opacity of a sample to `alpha`; what is visible of it waits for light.
    #[inline(always)]
    pub(super) fn collect(
        &self,
        object: &Object<S>,
        alpha: &mut F32s<S>,
        waiting: &mut UnlitSamples,
        sample: &composite::Sample<S>,
    ) -> Mask<S> {
        let opacity = object.table.opacity_at(sample.value);
        let visible = sample.sampled & F32s::zero().lt(opacity);
        let opacity = object.of_stride(object.of_step(opacity), sample.stride);
        let share = (F32s::splat(1.0) - *alpha) * opacity;
        let share = visible.select(share, F32s::zero());
        *alpha += share;
        waiting.push(sample.position, sample.value, share, visible);
        if waiting.number >= LANES {
            self.light(object, waiting);
        }
        visible
    }

    /// Lights all samples that wait; the rays have the colors that they add up to.
    #[inline(always)]
    pub(super) fn light_all(&mut self, object: &Object<S>, waiting: &mut UnlitSamples) {
        if waiting.number > 0 {
            self.light(object, waiting);
        }
        self.state.color = waiting.colors();
    }

    /// Lights as many samples as there are lanes, or all that wait, and adds them to their rays.
    #[inline(never)]
    fn light(&self, object: &Object<S>, waiting: &mut UnlitSamples) {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let batch = waiting.batch();
                let surface = object.table.at(batch.value);
                let mut unkept = [F32s::zero(); 3];
                let (position, to_eye) = (batch.position, batch.to_eye);
                let surface = object.shade(surface, position, to_eye, batch.asked, &mut unkept);
                waiting.add(&batch, surface.color);
            },
        );
    }
}
