//! The one ray loop.
//!
//! Rays go in packets. Every lane walks its own lattice; whatever accelerates the walk only decides
//! which lattice points are left out. Slots are chosen once per packet step, so that free
//! composition costs next to nothing.

use crate::elementary::opacity_of_length;
use crate::lanes::{F32s, LANES, Mask, Vec3s, lanes};
use crate::library::classify::Table;
use crate::library::clip_sample::SampleClips;
use crate::library::composite::{State, average, emission_absorption, first_hit, maximum, minimum};
use crate::library::fetch::Fetch;
use crate::library::gradient::Gradients;
use crate::library::reconstruct::Reconstruction;
use crate::library::shade::Shading;
use crate::ray::RayPacket;
use crate::skip::Skip;
use strahl_scene::plan::{Composite, Plan};

/// A Plan with everything prepared that is the same for all rays: the functions in the slots.
pub struct Slots<'p> {
    clips: SampleClips,
    reconstruction: Reconstruction,
    table: Table<'p>,
    /// step/reference, the exponent of the opacity correction.
    steps_per_reference: f32,
    gradients: Gradients,
    shading: Shading,
    composite: Composite,
    background: [f32; 4],
    skip: Option<Skip>,
}

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

impl<'p> Slots<'p> {
    /// The slots of `plan`.
    pub fn new(plan: &'p Plan, skip: Option<Skip>) -> Slots<'p> {
        Slots {
            clips: SampleClips::new(plan),
            reconstruction: Reconstruction::new(plan.reconstruct, &plan.volume),
            table: Table::new(&plan.classify),
            steps_per_reference: (plan.lattice.step_mm / f64::from(plan.classify.reference_mm()))
                as f32,
            gradients: Gradients::new(plan),
            shading: Shading::new(plan),
            composite: plan.composite,
            background: plan.background,
            skip,
        }
    }

    /// The pixels of a packet of rays.
    #[inline(always)]
    pub fn march<F: Fetch>(
        &self,
        fetch: &F,
        rays: &RayPacket,
        counts: &mut Counts,
    ) -> [[f32; 4]; LANES] {
        let mut k = F32s::ZERO;
        let mut live = k.lt(rays.count);
        let mut state = self.start();
        let mut skipped = F32s::ZERO;
        let (mut sampled_points, mut visible_points) = (F32s::ZERO, F32s::ZERO);
        let one = F32s::splat(1.0);

        while live.any() {
            let s = k + rays.jitter;
            let position = rays.position(s);
            if let Some(skip) = &self.skip {
                let jump = skip.jump(fetch.shape(), rays, position, &state);
                let empty = live & F32s::ZERO.lt(jump);
                if empty.any() {
                    // The others wait, so that sampling happens for as many rays as possible.
                    let next = empty.select((k + jump).min(rays.count), k);
                    skipped += next - k;
                    k = next;
                    live = live & k.lt(rays.count);
                    continue;
                }
            }
            let sampled = self.clips.keep(position, live);
            if sampled.any() {
                let value = self.reconstruction.value(fetch, position);
                sampled_points += sampled.select(one, F32s::ZERO);
                // What is not finite is no value: no rule counts it.
                let sampled = sampled & value.is_finite();
                let visible = self.add(fetch, rays, k, position, sampled, value, &mut state);
                visible_points += visible.select(one, F32s::ZERO);
            }
            k = live.select(k + one, k);
            live = live & k.lt(rays.count) & !self.done(&state);
        }

        let in_volume = F32s::ZERO.lt(rays.count);
        counts.points += sum(rays.count);
        counts.samples += sum(sampled_points);
        counts.visible += sum(visible_points);
        counts.skipped += sum(skipped);
        counts.rays_in_volume += in_volume.count();
        counts.ended_early += (in_volume & k.lt(rays.count)).count();
        self.finish(state)
    }

    #[inline(always)]
    fn start(&self) -> State {
        State::start(match self.composite {
            Composite::EmissionAbsorption { .. } | Composite::FirstHit { .. } => 0.0,
            Composite::Mip => maximum::START,
            Composite::MinIp => minimum::START,
            Composite::Average => average::START,
        })
    }

    /// Adds lattice point `k` of the rays `sampled`; says which of them it showed something for.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)] // what the rules need is what a sample is
    fn add<F: Fetch>(
        &self,
        fetch: &F,
        rays: &RayPacket,
        k: F32s,
        position: Vec3s,
        sampled: Mask,
        value: F32s,
        state: &mut State,
    ) -> Mask {
        match self.composite {
            Composite::EmissionAbsorption { .. } => {
                let surface = self.table.at(value);
                let visible = sampled & F32s::ZERO.lt(surface.opacity);
                if visible.any() {
                    let opacity = if self.steps_per_reference == 1.0 {
                        surface.opacity
                    } else {
                        opacity_of_length(surface.opacity, self.steps_per_reference)
                    };
                    let colour = self.shade(fetch, rays, position, surface.colour);
                    emission_absorption::add(state, visible, colour, opacity);
                }
                visible
            }
            Composite::Mip => {
                maximum::add(state, sampled, value);
                sampled
            }
            Composite::MinIp => {
                minimum::add(state, sampled, value);
                sampled
            }
            Composite::Average => {
                average::add(state, sampled, value);
                sampled
            }
            Composite::FirstHit { threshold } => {
                let threshold = F32s::splat(threshold as f32);
                let hit = sampled & threshold.le(value);
                if hit.any() {
                    let reached = |s: F32s| {
                        let position = rays.position(s);
                        let value = self.reconstruction.value(fetch, position);
                        self.clips
                            .keep(position, threshold.le(value) & value.is_finite())
                    };
                    // Before the first sample lies the entry, at which a ray may already be inside.
                    let first = k.eq(F32s::ZERO);
                    let before = first.select(F32s::ZERO, k - F32s::splat(1.0) + rays.jitter);
                    let refined = first_hit::refine(before, k + rays.jitter, reached);
                    let at_entry = first & reached(F32s::ZERO);
                    let position = rays.position(at_entry.select(F32s::ZERO, refined));
                    let value = self.reconstruction.value(fetch, position);
                    let surface = self.table.at(value).colour;
                    let colour = self.shade(fetch, rays, position, surface);
                    first_hit::add(state, hit, colour);
                }
                hit
            }
        }
    }

    #[inline(never)]
    fn shade<F: Fetch>(
        &self,
        fetch: &F,
        rays: &RayPacket,
        position: Vec3s,
        surface: Vec3s,
    ) -> Vec3s {
        let gradient = || self.gradients.at(&self.reconstruction, fetch, position);
        self.shading.colour(surface, gradient, rays.direction)
    }

    #[inline(always)]
    fn done(&self, state: &State) -> Mask {
        match self.composite {
            Composite::EmissionAbsorption {
                stop_at_transmittance,
            } => emission_absorption::done(state, stop_at_transmittance),
            Composite::FirstHit { .. } => F32s::ZERO.lt(state.alpha),
            Composite::Mip | Composite::MinIp | Composite::Average => Mask::NONE,
        }
    }

    /// The rule's own end, then the background under everything.
    #[inline(always)]
    fn finish(&self, state: State) -> [[f32; 4]; LANES] {
        let State { colour, alpha, .. } = match self.composite {
            Composite::EmissionAbsorption { .. } | Composite::FirstHit { .. } => state,
            Composite::Mip => maximum::finish(state, &self.table),
            Composite::MinIp => minimum::finish(state, &self.table),
            Composite::Average => average::finish(state, &self.table),
        };
        let behind = F32s::splat(1.0) - alpha;
        let over = |c: F32s, background: f32| c + behind * F32s::splat(background);
        let [r, g, b, a] = self.background;
        let (r, g, b) = (over(colour[0], r), over(colour[1], g), over(colour[2], b));
        let a = over(alpha, a);
        lanes(|i| [r.0[i], g.0[i], b.0[i], a.0[i]])
    }
}

/// Each lane is a whole number of at most 2^24, exact in f32.
#[inline(always)]
fn sum(numbers: F32s) -> u64 {
    numbers.0.iter().map(|&n| n as u64).sum()
}
