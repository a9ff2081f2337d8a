//! The one ray loop.
//!
//! Rays go in packets. Every lane walks its own lattice; whatever accelerates the walk only decides
//! which lattice points are left out. Slots are chosen once per packet step, so that free
//! composition costs next to nothing.

use crate::lanes::{F32s, LANES, Mask, Vec3s, lanes, length, unit};
use crate::library::classify::Surface;
use crate::library::composite::{
    State, average, debug, emission_absorption, first_hit, maximum, mida, minimum,
};
use crate::ray::{Line, RayPacket};
use crate::scenery::{Look, Object, Scenery};
use strahl_scene::plan::{Composite, DebugView, Shade};

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

/// What a packet of rays sees.
pub struct Seen {
    /// Premultiplied, with what is behind.
    pub pixels: [[f32; 4]; LANES],
    /// Distance of the hit or of opaque geometry in mm, infinite without.
    pub depth_mm: [f32; LANES],
}

/// The rays of a packet on their way.
struct Packet<'s> {
    scenery: &'s Scenery<'s>,
    rays: &'s RayPacket,
    to_eye: Vec3s,
    state: State,
    sampled: F32s,
    visible: F32s,
    skipped: F32s,
}

impl Scenery<'_> {
    /// What a packet of rays sees.
    pub fn march(&self, rays: &RayPacket, counts: &mut Counts) -> Seen {
        let mut packet = Packet {
            scenery: self,
            rays,
            to_eye: rays.direction.map(|d| -d),
            state: State::start(match self.plan.composite {
                Composite::Mip => maximum::START,
                Composite::MinIp => minimum::START,
                _ => 0.0,
            }),
            sampled: F32s::ZERO,
            visible: F32s::ZERO,
            skipped: F32s::ZERO,
        };
        let walked = match (self.objects.as_slice(), self.plan.composite) {
            ([object], Composite::BackToFront) => packet.backwards(object),
            ([object], _) => packet.forwards(object),
            (_, Composite::BackToFront) => packet.backwards_through_several(),
            _ => packet.forwards_through_several(),
        };
        let in_volume = F32s::ZERO.lt(rays.count);
        counts.points += sum(rays.count);
        counts.samples += sum(packet.sampled);
        counts.visible += sum(packet.visible);
        counts.skipped += sum(packet.skipped);
        counts.rays_in_volume += in_volume.count();
        counts.ended_early += (in_volume & walked.lt(rays.count)).count();
        packet.finish()
    }
}

impl Packet<'_> {
    /// Front to back through one volume; how many lattice points each ray has walked.
    fn forwards(&mut self, object: &Object) -> F32s {
        let (rays, line) = (self.rays, &self.rays.lines[0]);
        let one = F32s::splat(1.0);
        let mut k = F32s::ZERO;
        let mut live = k.lt(rays.count);
        while live.any() {
            let position = line.position(k + rays.jitter);
            if let Some(skip) = &object.skip {
                let jump = skip.jump(object.values.shape(), line, position, &self.state);
                let empty = live & F32s::ZERO.lt(jump);
                if empty.any() {
                    // The others wait, so that sampling happens for as many rays as possible.
                    let next = empty.select((k + jump).min(rays.count), k);
                    self.skipped += next - k;
                    k = next;
                    live = live & k.lt(rays.count);
                    continue;
                }
            }
            let sampled = object.clips.keep(position, live);
            if sampled.any() {
                let value = self.value(object, position, sampled);
                // What is not finite is no value: no rule counts it.
                let sampled = sampled & value.is_finite();
                let visible = self.add(object, line, k, position, sampled, value);
                self.visible += visible.select(one, F32s::ZERO);
            }
            k = live.select(k + one, k);
            live = live & k.lt(rays.count) & !self.done();
        }
        k
    }

    /// Back to front through one volume: every sample.
    fn backwards(&mut self, object: &Object) -> F32s {
        let (rays, line) = (self.rays, &self.rays.lines[0]);
        let one = F32s::splat(1.0);
        let mut left = rays.count;
        let mut live = F32s::ZERO.lt(left);
        while live.any() {
            left = live.select(left - one, left);
            let position = line.position(left + rays.jitter);
            let look = self.look(object, position, live);
            let Surface { colour, opacity } = look.surface;
            emission_absorption::add_in_front(&mut self.state, look.visible, colour, opacity);
            self.visible += look.visible.select(one, F32s::ZERO);
            live = live & F32s::ZERO.lt(left);
        }
        rays.count
    }

    /// Front to back through several volumes: at each lattice point their looks are mixed.
    fn forwards_through_several(&mut self) -> F32s {
        let rays = self.rays;
        let one = F32s::splat(1.0);
        let mut k = F32s::ZERO;
        let mut live = k.lt(rays.count);
        while live.any() {
            let jump = self.jump_over_all(k);
            let empty = live & F32s::ZERO.lt(jump);
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
            self.visible += look.visible.select(one, F32s::ZERO);
            k = live.select(k + one, k);
            live = live & k.lt(rays.count) & !self.done();
        }
        k
    }

    /// Back to front through several volumes.
    fn backwards_through_several(&mut self) -> F32s {
        let one = F32s::splat(1.0);
        let mut left = self.rays.count;
        let mut live = F32s::ZERO.lt(left);
        while live.any() {
            left = live.select(left - one, left);
            let look = self.mixed(left, live);
            let Surface { colour, opacity } = look.surface;
            emission_absorption::add_in_front(&mut self.state, look.visible, colour, opacity);
            self.visible += look.visible.select(one, F32s::ZERO);
            live = live & F32s::ZERO.lt(left);
        }
        self.rays.count
    }

    /// How many lattice points from `k` on show nothing of any volume.
    fn jump_over_all(&self, k: F32s) -> F32s {
        let mut jump = self.rays.count - k;
        for (object, line) in self.scenery.objects.iter().zip(&self.rays.lines) {
            let inside = line.first.le(k) & k.lt(line.end);
            let before = k.lt(line.first);
            let own = match &object.skip {
                Some(skip) if inside.any() => {
                    let position = line.position(k + self.rays.jitter);
                    let jump = skip.jump(object.values.shape(), line, position, &self.state);
                    // Behind its last point it shows nothing either.
                    let to_end = (line.end - k).le(jump);
                    to_end.select(self.rays.count - k, jump)
                }
                _ => F32s::ZERO,
            };
            let elsewhere = before.select(line.first - k, self.rays.count - k);
            jump = jump.min(inside.select(own, elsewhere));
        }
        jump.max(F32s::ZERO)
    }

    /// The looks of all volumes at lattice point `k`, mixed so that their order does not matter:
    /// A = 1 − Π(1 − aᵢ), C = Σ aᵢ·cᵢ / Σ aᵢ, which is exact for short steps.
    fn mixed(&mut self, k: F32s, live: Mask) -> Look {
        let one = F32s::splat(1.0);
        let (mut colour, mut opacities, mut passes) = ([F32s::ZERO; 3], F32s::ZERO, one);
        let mut visible = Mask::NONE;
        for (object, line) in self.scenery.objects.iter().zip(&self.rays.lines) {
            let inside = live & line.first.le(k) & k.lt(line.end);
            if !inside.any() {
                continue;
            }
            let look = self.look(object, line.position(k + self.rays.jitter), inside);
            let opacity = look.visible.select(look.surface.opacity, F32s::ZERO);
            for (sum, c) in colour.iter_mut().zip(look.surface.colour) {
                *sum += look.visible.select(c * opacity, F32s::ZERO);
            }
            opacities += opacity;
            passes = passes * (one - opacity);
            visible = visible | look.visible;
        }
        let divisor = F32s::ZERO.lt(opacities).select(opacities, one);
        Look {
            surface: Surface {
                colour: colour.map(|c| c.over(divisor)),
                opacity: one - passes,
            },
            visible,
        }
    }

    /// The value of a sample, counted.
    #[inline(always)]
    fn value(&mut self, object: &Object, position: Vec3s, sampled: Mask) -> F32s {
        self.sampled += sampled.select(F32s::splat(1.0), F32s::ZERO);
        object.values.at(position)
    }

    /// The look of a volume at `position` where it is not clipped.
    #[inline(always)]
    fn look(&mut self, object: &Object, position: Vec3s, live: Mask) -> Look {
        let sampled = object.clips.keep(position, live);
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

    /// Adds lattice point `k` of the rays `sampled`; says which of them it showed something for.
    #[inline(always)]
    fn add(
        &mut self,
        object: &Object,
        line: &Line,
        k: F32s,
        position: Vec3s,
        sampled: Mask,
        value: F32s,
    ) -> Mask {
        let place = k + self.rays.jitter;
        match self.scenery.plan.composite {
            Composite::EmissionAbsorption { .. } | Composite::BackToFront => {
                let look = self.classified(object, value, position, sampled);
                let Surface { colour, opacity } = look.surface;
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
                let steep = length(object.gradient(position));
                maximum::add(&mut self.state, sampled, steep, place);
                sampled
            }
            Composite::FirstHit { threshold } => {
                let threshold = F32s::splat(threshold as f32);
                let hit = sampled & threshold.le(value);
                if hit.any() {
                    self.hit(object, line, k, threshold, hit);
                }
                hit
            }
            Composite::Debug(view) => self.inspect(view, object, place, position, sampled, value),
        }
    }

    #[inline(always)]
    fn classified(&mut self, object: &Object, value: F32s, position: Vec3s, sampled: Mask) -> Look {
        object.look(
            &self.scenery.shading,
            value,
            position,
            self.to_eye,
            sampled,
            &mut self.state.last_normal,
        )
    }

    /// Rays whose value reaches the threshold at lattice point `k` first.
    #[inline(never)]
    fn hit(&mut self, object: &Object, line: &Line, k: F32s, threshold: F32s, hit: Mask) {
        let jitter = self.rays.jitter;
        let reached = |s: F32s| {
            let position = line.position(s);
            let value = object.values.at(position);
            let reached = threshold.le(value) & value.is_finite();
            object.clips.keep(position, reached)
        };
        // Before the first sample lies the entry, at which a ray may already be inside.
        let first = k.eq(F32s::ZERO);
        let before = first.select(F32s::ZERO, k - F32s::splat(1.0) + jitter);
        let refined = first_hit::refine(before, k + jitter, reached);
        let at_entry = first & reached(F32s::ZERO);
        let place = at_entry.select(F32s::ZERO, refined);
        let position = line.position(place);
        let surface = object.classify(object.values.at(position), position);
        let colour = self.shade(object, surface, position, hit).colour;
        self.state.paint(hit, colour);
        self.state.place = hit.select(place, self.state.place);
    }

    fn shade(
        &mut self,
        object: &Object,
        surface: Surface,
        position: Vec3s,
        shaded: Mask,
    ) -> Surface {
        let shading = &self.scenery.shading;
        let last_normal = &mut self.state.last_normal;
        object.shade(shading, surface, position, self.to_eye, shaded, last_normal)
    }

    #[inline(never)]
    fn inspect(
        &mut self,
        view: DebugView,
        object: &Object,
        place: F32s,
        position: Vec3s,
        sampled: Mask,
        value: F32s,
    ) -> Mask {
        let shown = match view {
            DebugView::Entry | DebugView::Exit => sampled,
            DebugView::SampleCount { .. } => {
                let more = self.state.number + F32s::splat(1.0);
                self.state.number = sampled.select(more, self.state.number);
                return sampled;
            }
            _ => sampled & F32s::ZERO.lt(object.classify(value, position).opacity),
        };
        if shown.any() {
            let colour = match view {
                DebugView::Normal => {
                    let (normal, _) = unit(object.gradient(position));
                    debug::vector_colour(normal)
                }
                DebugView::GradientRaw => debug::vector_colour(object.gradient(position)),
                DebugView::GradientMagnitude { white_per_mm } => {
                    debug::grey(length(object.gradient(position)), 0.0, white_per_mm)
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
    fn distance_mm(&self, place: F32s) -> F32s {
        let step_mm = self.scenery.plan.lattice.step_mm;
        F32s(lanes(|i| {
            (self.rays.entry_mm[i] + f64::from(place.0[i]) * step_mm) as f32
        }))
    }

    #[inline(always)]
    fn done(&self) -> Mask {
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
            Composite::FirstHit { .. } => F32s::ZERO.lt(state.alpha),
            Composite::Debug(DebugView::Exit | DebugView::SampleCount { .. }) => Mask::NONE,
            Composite::Debug(_) => F32s::ZERO.lt(state.alpha),
            Composite::BackToFront
            | Composite::Mip
            | Composite::MinIp
            | Composite::Average
            | Composite::Gmip { .. } => Mask::NONE,
        }
    }

    /// The rule's own end, then what is behind under everything.
    fn finish(mut self) -> Seen {
        let found = F32s::ZERO.lt(self.state.number);
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
        let over =
            |c: F32s, channel: usize| c + behind * F32s(lanes(|i| self.rays.behind[i][channel]));
        let [r, g, b] = [0, 1, 2].map(|c| over(colour[c], c));
        let a = over(alpha, 3);
        let hits = matches!(self.scenery.plan.composite, Composite::FirstHit { .. });
        let distance = self.distance_mm(self.state.place);
        Seen {
            pixels: lanes(|i| [r.0[i], g.0[i], b.0[i], a.0[i]]),
            depth_mm: lanes(|i| {
                if hits && alpha.0[i] > 0.0 {
                    distance.0[i]
                } else {
                    self.rays.opaque_mm[i] as f32
                }
            }),
        }
    }

    /// `value` classified and shaded once, nothing where none was `found`.
    fn classify_once(&mut self, value: F32s, found: Mask) {
        let scenery = self.scenery;
        let object = &scenery.objects[0];
        let position = self.rays.lines[0].position(self.state.place);
        let mut surface = object.classify(value, position);
        if scenery.plan.shade != Shade::Unlit {
            surface = self.shade(object, surface, position, found);
        }
        let alpha = found.select(surface.opacity, F32s::ZERO);
        self.state.colour = surface.colour.map(|c| c * alpha);
        self.state.alpha = alpha;
    }
}

/// Each lane is a whole number of at most 2^24, exact in f32.
#[inline(always)]
fn sum(numbers: F32s) -> u64 {
    numbers.0.iter().map(|&n| n as u64).sum()
}
