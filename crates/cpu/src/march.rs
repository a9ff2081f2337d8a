//! The one ray loop.
//!
//! Rays go in packets. Every lane walks its own lattice; whatever accelerates the walk only decides
//! which lattice points are left out. Slots are chosen once per packet step, so that free
//! composition costs next to nothing.

mod adaptive;
mod projection;
mod segments;
mod through_voxels;

pub use projection::OfRuns;

use crate::doubles::F64s;
use crate::lanes::{F32s, LANES, Mask, Vec3s, each, lanes, length, to_rows, unit};
use crate::levels::{Level, inlined, vectorized};
use crate::library::classify::Surface;
use crate::library::composite::{
    State, average, debug, emission_absorption, first_hit, maximum, mida, minimum,
};
use crate::ray::{Line, RayPacket};
use crate::scenery::{Look, Object, Scenery};
use crate::skip::Skip;
use segments::{Inside, Shown};
use strahl_scene::plan::{Composite, DebugView, Sampling, Shade};

/// What a packet of rays has cost.
#[derive(Clone, Copy, Default)]
pub struct Counts {
    /// Lattice points of all rays.
    pub points: u64,
    /// Of these, how many were reconstructed …
    pub samples: u64,
    /// … how many of those changed the pixel …
    pub visible: u64,
    /// … and how many points bricks left out.
    pub skipped: u64,
    /// Rays with at least one lattice point.
    pub rays_in_volume: u64,
    /// Rays that ended before their last lattice point.
    pub ended_early: u64,
}

impl Counts {
    /// Those of both.
    pub fn plus(self, other: Counts) -> Counts {
        Counts {
            points: self.points + other.points,
            samples: self.samples + other.samples,
            visible: self.visible + other.visible,
            skipped: self.skipped + other.skipped,
            rays_in_volume: self.rays_in_volume + other.rays_in_volume,
            ended_early: self.ended_early + other.ended_early,
        }
    }
}

/// What a packet of rays sees.
pub struct Seen {
    /// Premultiplied, with what is behind.
    pub pixels: [[f32; 4]; LANES],
    /// Distance of the hit or of opaque geometry in mm, infinite without.
    pub depth_mm: [f32; LANES],
}

/// The rays of a packet on their way.
struct Packet<'s, S: Level> {
    scenery: &'s Scenery<'s, S>,
    rays: &'s RayPacket<S>,
    to_eye: Vec3s<S>,
    state: State<S>,
    sampled: F32s<S>,
    visible: F32s<S>,
    skipped: F32s<S>,
}

impl<S: Level> Scenery<'_, S> {
    /// What a packet of rays sees.
    #[inline(always)]
    pub fn march(&self, rays: &RayPacket<S>, of_runs: &mut OfRuns<S>, counts: &mut Counts) -> Seen {
        let mut packet = Packet {
            scenery: self,
            rays,
            to_eye: each!(rays.direction, |d| -d),
            state: State::start(match self.plan.composite {
                Composite::Mip => maximum::START,
                Composite::MinIp => minimum::START,
                _ => 0.0,
            }),
            sampled: F32s::zero(),
            visible: F32s::zero(),
            skipped: F32s::zero(),
        };
        let walked = match (self.objects.as_slice(), self.plan.composite) {
            ([object], Composite::EmissionAbsorption { .. }) => packet.by_rule(object),
            ([object], Composite::FirstHit { .. }) => packet.at_lattice_points(object),
            ([object], Composite::BackToFront) => packet.backwards(object),
            ([object], _) => match object.skip.as_ref().and_then(Skip::bounds) {
                Some(bounds) => {
                    packet.project(object, bounds, of_runs);
                    rays.count
                }
                None => packet.forwards(object),
            },
            (_, Composite::BackToFront) => packet.backwards_through_several(),
            _ => packet.forwards_through_several(),
        };
        if let ([object], Sampling::Refine { parts }, Composite::Mip | Composite::MinIp) = (
            self.objects.as_slice(),
            self.plan.sampling,
            self.plan.composite,
        ) {
            packet.refine_projection(object, parts);
        }
        let in_volume = F32s::zero().lt(rays.count);
        counts.points += sum(rays.count);
        counts.samples += sum(packet.sampled);
        counts.visible += sum(packet.visible);
        counts.skipped += sum(packet.skipped);
        counts.rays_in_volume += in_volume.count();
        counts.ended_early += (in_volume & walked.lt(rays.count)).count();
        packet.finish()
    }
}

impl<S: Level> Packet<'_, S> {
    /// Front to back through one volume; how many lattice points each ray has walked.
    #[inline(always)]
    fn forwards(&mut self, object: &Object<S>) -> F32s<S> {
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
        if let Composite::FirstHit { threshold } = self.scenery.plan.composite {
            self.hit(object, F32s::splat(threshold as f32));
        }
        k
    }

    /// The lattice points behind those that show nothing for certain, for rays of `live` that are at such; `None` if no ray
    /// is. The others wait, so that sampling happens for as many rays as possible.
    #[inline(always)]
    fn behind_nothing(
        &mut self,
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
        let next = empty.select((k + jump).min(self.rays.count), k);
        self.skipped += next - k;
        Some(next)
    }

    /// Which rays of `live` are to be moved on, and which of them are to be `sampled`: where many samples are rejected, only
    /// their rays, without a sample. The others wait, so that sampling happens for as many rays as possible.
    #[inline(always)]
    fn moving_and_sampled(
        &self,
        object: &Object<S>,
        position: Vec3s<S>,
        live: Mask<S>,
        sampled: Mask<S>,
    ) -> (Mask<S>, Mask<S>) {
        if object.rejection.is_none() {
            return (live, sampled);
        }
        let seen = object.unless_rejected(position, self.state.value, sampled);
        let rejected = live & !seen;
        if 2 * rejected.count() > live.count() {
            (rejected, Mask::none())
        } else {
            (live, seen)
        }
    }

    /// Front to back through one volume by the Plan's rule of sampling.
    #[inline(always)]
    fn by_rule(&mut self, object: &Object<S>) -> F32s<S> {
        match self.scenery.plan.sampling {
            Sampling::Regular | Sampling::ByOpacity { .. } => self.at_lattice_points(object),
            Sampling::Refine { parts } => {
                self.by_segments(object, Shown::InParts(parts, Inside::Reconstructed))
            }
            Sampling::Split { parts, curve } => {
                self.by_segments(object, Shown::InParts(parts, Inside::Between(curve)))
            }
            Sampling::Integrated => {
                let integrals = object.integrals.as_ref();
                let integrals = integrals.expect("objects have them where the rule asks");
                self.by_segments(object, Shown::AsIntegrals(integrals))
            }
            Sampling::Adaptive { .. } => self.by_runs(object),
        }
    }

    /// Front to back through one volume, by the loop of its type of sample if there is one.
    #[inline(always)]
    fn at_lattice_points(&mut self, object: &Object<S>) -> F32s<S> {
        match object.stored_for(self.scenery.plan.composite, &self.scenery.shading) {
            Some(stored) if S::HAS_LOOPS_PER_TYPE => self.through_voxels(object, stored),
            _ => self.forwards(object),
        }
    }

    /// Back to front through one volume: every sample.
    #[inline(never)]
    fn backwards(&mut self, object: &Object<S>) -> F32s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || self.backwards_here(object),
        )
    }

    #[inline(always)]
    fn backwards_here(&mut self, object: &Object<S>) -> F32s<S> {
        let (rays, line) = (self.rays, &self.rays.lines[0]);
        let one = F32s::splat(1.0);
        let mut left = rays.count;
        let mut live = F32s::zero().lt(left);
        while live.any() {
            left = live.select(left - one, left);
            let position = line.position(left + rays.jitter);
            let look = self.look(object, position, live);
            let Surface { colour, opacity } = look.surface;
            emission_absorption::add_in_front(&mut self.state, look.visible, colour, opacity);
            self.visible += look.visible.select(one, F32s::zero());
            live = live & F32s::zero().lt(left);
        }
        rays.count
    }

    /// Front to back through several volumes: at each lattice point their looks are mixed.
    #[inline(never)]
    fn forwards_through_several(&mut self) -> F32s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || self.forwards_through_several_here(),
        )
    }

    #[inline(always)]
    fn forwards_through_several_here(&mut self) -> F32s<S> {
        let rays = self.rays;
        let one = F32s::splat(1.0);
        let mut k = F32s::zero();
        let mut live = k.lt(rays.count);
        while live.any() {
            let jump = self.jump_over_all(k);
            let empty = live & F32s::zero().lt(jump);
            if empty.any() {
                let next = empty.select((k + jump).min(rays.count), k);
                self.skipped += next - k;
                k = next;
                live = live & k.lt(rays.count);
                continue;
            }
            let look = self.mixed(k, live);
            let Surface { colour, opacity } = look.surface;
            emission_absorption::add(&mut self.state, look.visible, colour, opacity);
            self.visible += look.visible.select(one, F32s::zero());
            k = live.select(k + one, k);
            live = live & k.lt(rays.count) & !self.done();
        }
        k
    }

    /// Back to front through several volumes.
    #[inline(never)]
    fn backwards_through_several(&mut self) -> F32s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || self.backwards_through_several_here(),
        )
    }

    #[inline(always)]
    fn backwards_through_several_here(&mut self) -> F32s<S> {
        let one = F32s::splat(1.0);
        let mut left = self.rays.count;
        let mut live = F32s::zero().lt(left);
        while live.any() {
            left = live.select(left - one, left);
            let look = self.mixed(left, live);
            let Surface { colour, opacity } = look.surface;
            emission_absorption::add_in_front(&mut self.state, look.visible, colour, opacity);
            self.visible += look.visible.select(one, F32s::zero());
            live = live & F32s::zero().lt(left);
        }
        self.rays.count
    }

    /// How many lattice points from `k` on show nothing of any volume.
    #[inline(always)]
    fn jump_over_all(&self, k: F32s<S>) -> F32s<S> {
        let mut jump = self.rays.count - k;
        for (object, line) in self.scenery.objects.iter().zip(&self.rays.lines) {
            let inside = line.first.le(k) & k.lt(line.end);
            let before = k.lt(line.first);
            let own = match &object.skip {
                Some(skip) if inside.any() => {
                    let position = line.position(k + self.rays.jitter);
                    let jump = skip.jump(object.values.shape(), line, position);
                    // Behind its last point it shows nothing either.
                    let to_end = (line.end - k).le(jump);
                    to_end.select(self.rays.count - k, jump)
                }
                _ => F32s::zero(),
            };
            let elsewhere = before.select(line.first - k, self.rays.count - k);
            jump = jump.min(inside.select(own, elsewhere));
        }
        jump.max(F32s::zero())
    }

    /// The looks of all volumes at lattice point `k`, mixed so that their order does not matter:
    /// A = 1 − Π(1 − aᵢ), C = Σ aᵢ·cᵢ / Σ aᵢ, which is exact for short steps.
    #[inline(always)]
    fn mixed(&mut self, k: F32s<S>, live: Mask<S>) -> Look<S> {
        let one = F32s::splat(1.0);
        let (mut colour, mut opacities, mut passes) = ([F32s::zero(); 3], F32s::zero(), one);
        let mut visible = Mask::none();
        for (object, line) in self.scenery.objects.iter().zip(&self.rays.lines) {
            let inside = live & line.first.le(k) & k.lt(line.end);
            if !inside.any() {
                continue;
            }
            let look = self.look(object, line.position(k + self.rays.jitter), inside);
            let opacity = look.visible.select(look.surface.opacity, F32s::zero());
            for (sum, c) in colour.iter_mut().zip(look.surface.colour) {
                *sum += look.visible.select(c * opacity, F32s::zero());
            }
            opacities += opacity;
            passes = passes * (one - opacity);
            visible = visible | look.visible;
        }
        let divisor = F32s::zero().lt(opacities).select(opacities, one);
        Look {
            surface: Surface {
                colour: each!(colour, |c| c.over(divisor)),
                opacity: one - passes,
            },
            visible,
        }
    }

    /// The value of a sample, counted.
    #[inline(always)]
    fn value(&mut self, object: &Object<S>, position: Vec3s<S>, sampled: Mask<S>) -> F32s<S> {
        self.sampled += sampled.select(F32s::splat(1.0), F32s::zero());
        object.values.at(position)
    }

    /// The look of a volume at `position` where it is not clipped.
    #[inline(always)]
    fn look(&mut self, object: &Object<S>, position: Vec3s<S>, live: Mask<S>) -> Look<S> {
        let sampled = object.clips.keep(position, live);
        let sampled = object.unless_rejected(position, self.state.value, sampled);
        if !sampled.any() {
            return Look::nothing();
        }
        let value = self.value(object, position, sampled);
        object.look(
            &self.scenery.shading,
            value,
            position,
            self.to_eye,
            sampled & value.is_finite(),
            &mut self.state.last_normal,
        )
    }

    /// Adds lattice point `k` of the rays `sampled`, for as many as a `stride` has where there are strides; says which of them
    /// it showed something for.
    #[inline(always)]
    fn add(
        &mut self,
        object: &Object<S>,
        k: F32s<S>,
        position: Vec3s<S>,
        sampled: Mask<S>,
        value: F32s<S>,
        stride: F32s<S>,
    ) -> Mask<S> {
        let place = k + self.rays.jitter;
        match self.scenery.plan.composite {
            Composite::EmissionAbsorption { .. } | Composite::BackToFront => {
                let look = self.classified(object, value, position, sampled);
                let Surface { colour, opacity } = look.surface;
                let opacity = object.of_stride(opacity, stride);
                emission_absorption::add(&mut self.state, look.visible, colour, opacity);
                look.visible
            }
            Composite::Mida {
                low, high, blend, ..
            } => {
                mida::fade(&mut self.state, sampled, value, low, high, blend);
                let look = self.classified(object, value, position, sampled);
                let Surface { colour, opacity } = look.surface;
                mida::add(&mut self.state, look.visible, colour, opacity);
                look.visible
            }
            Composite::Mip => {
                maximum::add(&mut self.state, sampled, value, place);
                sampled
            }
            Composite::MinIp => {
                minimum::add(&mut self.state, sampled, value, place);
                sampled
            }
            Composite::Average => {
                average::add(&mut self.state, sampled, value);
                self.state.place = sampled.select(place, self.state.place);
                sampled
            }
            Composite::Gmip { .. } => {
                let steep = length(object.gradient(position, sampled));
                maximum::add(&mut self.state, sampled, steep, place);
                sampled
            }
            Composite::FirstHit { threshold } => {
                self.meet(F32s::splat(threshold as f32), k, value, sampled)
            }
            Composite::Debug(view) => self.inspect(view, object, place, position, sampled, value),
        }
    }

    #[inline(always)]
    fn classified(
        &mut self,
        object: &Object<S>,
        value: F32s<S>,
        position: Vec3s<S>,
        sampled: Mask<S>,
    ) -> Look<S> {
        object.look(
            &self.scenery.shading,
            value,
            position,
            self.to_eye,
            sampled,
            &mut self.state.last_normal,
        )
    }

    /// Ends the rays whose value reaches the threshold at lattice point `k`, and remembers that: where between the
    /// points it lies is looked for when all rays of the packet have ended.
    #[inline(always)]
    fn meet(
        &mut self,
        threshold: F32s<S>,
        k: F32s<S>,
        value: F32s<S>,
        sampled: Mask<S>,
    ) -> Mask<S> {
        let hit = sampled & threshold.le(value);
        self.state.place = hit.select(k, self.state.place);
        self.state.alpha = hit.select(F32s::splat(1.0), self.state.alpha);
        hit
    }

    /// The look of the rays that have met the threshold.
    #[inline(never)]
    fn hit(&mut self, object: &Object<S>, threshold: F32s<S>) {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let hit = F32s::zero().lt(self.state.alpha);
                if hit.any() {
                    self.hit_here(object, &self.rays.lines[0], threshold, hit);
                }
            },
        );
    }

    #[inline(always)]
    fn hit_here(&mut self, object: &Object<S>, line: &Line<S>, threshold: F32s<S>, hit: Mask<S>) {
        let (k, jitter) = (self.state.place, self.rays.jitter);
        let reached = inlined(
            #[inline(always)]
            |s: F32s<S>| {
                let position = line.position(s);
                let value = object.values.at(position);
                let reached = threshold.le(value) & value.is_finite();
                object.clips.keep(position, reached)
            },
        );
        // Before the first sample lies the entry, at which a ray may already be inside.
        let first = k.eq(F32s::zero());
        let before = first.select(F32s::zero(), k - F32s::splat(1.0) + jitter);
        let refined = first_hit::refine(before, k + jitter, reached);
        let at_entry = first & reached(F32s::zero());
        let place = at_entry.select(F32s::zero(), refined);
        let position = line.position(place);
        let surface = object.classify(object.values.at(position), position, hit);
        let colour = self.shade(object, surface, position, hit).colour;
        self.state.paint(hit, colour);
        self.state.place = hit.select(place, self.state.place);
    }

    #[inline(always)]
    fn shade(
        &mut self,
        object: &Object<S>,
        surface: Surface<S>,
        position: Vec3s<S>,
        shaded: Mask<S>,
    ) -> Surface<S> {
        let shading = &self.scenery.shading;
        let last_normal = &mut self.state.last_normal;
        object.shade(shading, surface, position, self.to_eye, shaded, last_normal)
    }

    #[inline(never)]
    fn inspect(
        &mut self,
        view: DebugView,
        object: &Object<S>,
        place: F32s<S>,
        position: Vec3s<S>,
        sampled: Mask<S>,
        value: F32s<S>,
    ) -> Mask<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || self.inspect_here(view, object, place, position, sampled, value),
        )
    }

    #[inline(always)]
    fn inspect_here(
        &mut self,
        view: DebugView,
        object: &Object<S>,
        place: F32s<S>,
        position: Vec3s<S>,
        sampled: Mask<S>,
        value: F32s<S>,
    ) -> Mask<S> {
        let shown = match view {
            DebugView::Entry | DebugView::Exit => sampled,
            DebugView::SampleCount { .. } => {
                let more = self.state.number + F32s::splat(1.0);
                self.state.number = sampled.select(more, self.state.number);
                return sampled;
            }
            _ => sampled & F32s::zero().lt(object.classify(value, position, sampled).opacity),
        };
        if shown.any() {
            let colour = match view {
                DebugView::Normal => {
                    let (normal, _) = unit(object.gradient(position, shown));
                    debug::vector_colour(normal)
                }
                DebugView::GradientRaw => debug::vector_colour(object.gradient(position, shown)),
                DebugView::GradientMagnitude { white_per_mm } => {
                    debug::grey(length(object.gradient(position, shown)), 0.0, white_per_mm)
                }
                DebugView::Depth { near_mm, far_mm } => {
                    debug::grey(self.distance_mm(place), near_mm, far_mm)
                }
                DebugView::Entry | DebugView::Exit | DebugView::SampleCount { .. } => {
                    debug::position_colour(object.values.shape(), position)
                }
            };
            self.state.paint(shown, colour);
            self.state.place = shown.select(place, self.state.place);
        }
        shown
    }

    /// How far a lattice coordinate is from the ray's start.
    #[inline(always)]
    fn distance_mm(&self, place: F32s<S>) -> F32s<S> {
        let step_mm = F64s::splat(self.scenery.plan.lattice.step_mm);
        (self.rays.entry_mm + F64s::from_single(place) * step_mm).to_single()
    }

    #[inline(always)]
    fn done(&self) -> Mask<S> {
        let state = &self.state;
        match self.scenery.plan.composite {
            Composite::EmissionAbsorption {
                stop_at_transmittance,
            } => emission_absorption::done(state, stop_at_transmittance),
            Composite::Mida {
                stop_at_transmittance,
                blend,
                ..
            } => mida::done(state, stop_at_transmittance, blend),
            Composite::FirstHit { .. } => F32s::zero().lt(state.alpha),
            Composite::Debug(DebugView::Exit | DebugView::SampleCount { .. }) => Mask::none(),
            Composite::Debug(_) => F32s::zero().lt(state.alpha),
            Composite::BackToFront
            | Composite::Mip
            | Composite::MinIp
            | Composite::Average
            | Composite::Gmip { .. } => Mask::none(),
        }
    }

    /// The rule's own end, then what is behind under everything.
    #[inline(always)]
    fn finish(&mut self) -> Seen {
        let found = F32s::zero().lt(self.state.number);
        match self.scenery.plan.composite {
            Composite::Mip | Composite::MinIp => self.classify_once(self.state.value, found),
            Composite::Average => self.classify_once(average::mean(&self.state), found),
            Composite::Gmip { white_per_mm } => {
                let grey = debug::grey(self.state.value, 0.0, white_per_mm);
                self.state.paint(found, grey);
            }
            Composite::Debug(DebugView::SampleCount { white }) => {
                let grey = debug::grey(self.state.number, 0.0, white);
                self.state.paint(found, grey);
            }
            _ => {}
        }
        let State { colour, alpha, .. } = self.state;
        let behind = F32s::splat(1.0) - alpha;
        let over = inlined(
            #[inline(always)]
            |c: F32s<S>, channel: usize| c + behind * self.rays.behind[channel],
        );
        let [r, g, b] = each!([0, 1, 2], |c| over(colour[c], c));
        let a = over(alpha, 3);
        Seen {
            pixels: to_rows([r, g, b, a]),
            depth_mm: if self.scenery.plan.with_depth {
                self.depth_mm()
            } else {
                [f32::INFINITY; LANES]
            },
        }
    }

    /// How far away what is seen lies.
    #[inline(always)]
    fn depth_mm(&self) -> [f32; LANES] {
        let hits = matches!(self.scenery.plan.composite, Composite::FirstHit { .. });
        let distance = self.distance_mm(self.state.place);
        lanes(|i| {
            if hits && self.state.alpha.lane(i) > 0.0 {
                distance.lane(i)
            } else {
                self.rays.opaque_mm[i] as f32
            }
        })
    }

    /// `value` classified and shaded once, nothing where none was `found`.
    #[inline(always)]
    fn classify_once(&mut self, value: F32s<S>, found: Mask<S>) {
        let scenery = self.scenery;
        let object = &scenery.objects[0];
        let position = self.rays.lines[0].position(self.state.place);
        let mut surface = object.classify(value, position, found);
        if scenery.plan.shade != Shade::Unlit {
            surface = self.shade(object, surface, position, found);
        }
        let alpha = found.select(surface.opacity, F32s::zero());
        self.state.colour = each!(surface.colour, |c| c * alpha);
        self.state.alpha = alpha;
    }
}

/// Each lane is a whole number of at most 2^24, exact in f32.
#[inline(always)]
fn sum<S: Level>(numbers: F32s<S>) -> u64 {
    let numbers = numbers.to_i32s().to_array();
    numbers.iter().map(|&number| number as u64).sum()
}
