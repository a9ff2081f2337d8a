//! A packet of rays on its way, and what every loop does at a lattice point.

use crate::doubles::F64s;
use crate::lanes::{F32s, LANES, Mask, Vec3s, each, lanes, length, to_rows, unit};
use crate::levels::{Level, inlined, vectorized};
use crate::library::classify::Surface;
use crate::library::composite::state::State;
use crate::library::composite::{
    average, debug, emission_absorption, first_hit, maximum, mida, minimum,
};
use crate::line::Line;
use crate::ray_packet::RayPacket;
use crate::scenery::{Look, Object, Scenery};
use strahl_scene::plan::{Composite, DebugView, Shade};

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
    pub(super) sampled: F32s<S>,
    pub(super) visible: F32s<S>,
    pub(super) skipped: F32s<S>,
}

impl<S: Level> Packet<'_, S> {
    /// The lattice points behind those that show nothing for certain, for rays of `live` that are at such; `None` if no ray
    /// is. The others wait, so that sampling happens for as many rays as possible.
    #[inline(always)]
    pub(super) fn behind_nothing(
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
    pub(super) fn moving_and_sampled(
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
    pub(super) fn add(
        &mut self,
        object: &Object<S>,
        k: F32s<S>,
        position: Vec3s<S>,
        sampled: Mask<S>,
        value: F32s<S>,
        stride: F32s<S>,
    ) -> Mask<S> {
        let place = k + self.rays.jitter;
        match self.scenery.composite {
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
            Composite::Minip => {
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
                self.meet(F32s::splat(threshold), k, value, sampled)
            }
            Composite::Debug(view) => self.inspect(view, object, place, position, sampled, value),
        }
    }

    #[inline(always)]
    pub(super) fn classified(
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
    pub(super) fn meet(
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
    pub(super) fn hit(&mut self, object: &Object<S>, threshold: F32s<S>) {
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
    pub(super) fn hit_here(
        &mut self,
        object: &Object<S>,
        line: &Line<S>,
        threshold: F32s<S>,
        hit: Mask<S>,
    ) {
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
    pub(super) fn shade(
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
    pub(super) fn inspect(
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
    pub(super) fn inspect_here(
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
    pub(super) fn distance_mm(&self, place: F32s<S>) -> F32s<S> {
        let step_mm = F64s::splat(self.scenery.plan.lattice.step_mm);
        (self.rays.entry_mm + F64s::from_single(place) * step_mm).to_single()
    }

    #[inline(always)]
    pub(super) fn done(&self) -> Mask<S> {
        let state = &self.state;
        match self.scenery.composite {
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
            | Composite::Minip
            | Composite::Average
            | Composite::Gmip { .. } => Mask::none(),
        }
    }

    /// The rule's own end, then what is behind under everything.
    #[inline(always)]
    pub(super) fn finish(&mut self) -> Seen {
        let found = F32s::zero().lt(self.state.number);
        match self.scenery.composite {
            Composite::Mip | Composite::Minip => self.classify_once(self.state.value, found),
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
    pub(super) fn depth_mm(&self) -> [f32; LANES] {
        let hits = matches!(self.scenery.composite, Composite::FirstHit { .. });
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
    #[inline(never)]
    pub(super) fn classify_once(&mut self, value: F32s<S>, found: Mask<S>) {
        vectorized::<S, _>(
            #[inline(always)]
            || self.classify_once_here(value, found),
        );
    }

    #[inline(always)]
    fn classify_once_here(&mut self, value: F32s<S>, found: Mask<S>) {
        let scenery = self.scenery;
        let object = &scenery.objects[0];
        let position = self.rays.lines[0].position(self.state.place);
        let mut surface = object.classify(value, position, found);
        if scenery.plan.technique().shade != Shade::Unlit {
            surface = self.shade(object, surface, position, found);
        }
        let alpha = found.select(surface.opacity, F32s::zero());
        self.state.colour = each!(surface.colour, |c| c * alpha);
        self.state.alpha = alpha;
    }
}
