//! The first place on the ray where the value reaches a threshold.

use super::rule::{Crossing, Rule, Sample};
use super::state::State;
use super::visible_values::VisibleValues;
use crate::lanes::{F32s, Mask};
use crate::levels::{Level, inlined, vectorized};

/// The first sample whose value reaches `threshold`, and where between it and the one before that happens; opaque.
///
/// Until [`finish`](Rule::finish) a ray remembers the number of that lattice point: where between the points the place
/// lies is looked for when all rays of the packet have ended.
#[derive(Clone, Copy)]
pub struct FirstHit {
    pub threshold: f32,
}

impl FirstHit {
    /// Ends the rays whose value reaches the threshold at lattice point `k`.
    #[inline(always)]
    pub fn meet<S: Level>(
        &self,
        state: &mut State<S>,
        k: F32s<S>,
        value: F32s<S>,
        sampled: Mask<S>,
    ) -> Mask<S> {
        let hit = sampled & F32s::splat(self.threshold).le(value);
        state.place = hit.select(k, state.place);
        state.alpha = hit.select(F32s::splat(1.0), state.alpha);
        hit
    }

    /// The look of the rays that have met the threshold.
    #[inline(never)]
    fn hit<S: Level>(&self, state: &mut State<S>, rays: &Crossing<S>) {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let hit = F32s::zero().lt(state.alpha);
                if hit.any() {
                    self.hit_here(state, rays, hit);
                }
            },
        );
    }

    #[inline(always)]
    fn hit_here<S: Level>(&self, state: &mut State<S>, rays: &Crossing<S>, hit: Mask<S>) {
        let (object, line) = (rays.object, rays.line());
        let (k, jitter) = (state.place, rays.packet.jitter);
        let threshold = F32s::splat(self.threshold);
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
        let refined = refine(before, k + jitter, reached);
        let at_entry = first & reached(F32s::zero());
        let place = at_entry.select(F32s::zero(), refined);
        let position = line.position(place);
        let surface = object.classify(object.values.at(position), position, hit);
        // Refined, it may lie before the border of its segment.
        let places = [position, line.position(k + jitter)];
        let color = object
            .shade_within(surface, places, *rays.to_eye, hit, &mut state.last_normal)
            .color;
        state.paint(hit, color);
        state.place = hit.select(place, state.place);
    }
}

impl Rule for FirstHit {
    fn has_depth(&self) -> bool {
        true
    }

    fn sees(&self) -> VisibleValues {
        VisibleValues::From(self.threshold)
    }

    #[inline(always)]
    fn add<S: Level>(&self, state: &mut State<S>, sample: &Sample<S>) -> Mask<S> {
        self.meet(state, sample.k, sample.value, sample.sampled)
    }

    #[inline(always)]
    fn done<S: Level>(&self, state: &State<S>) -> Mask<S> {
        F32s::zero().lt(state.alpha)
    }

    #[inline(always)]
    fn finish<S: Level>(&self, state: &mut State<S>, rays: &Crossing<S>) {
        self.hit(state, rays);
    }
}

/// Halvings of the bracket around a hit: the place is exact to 1/4096 of a step.
const HALVINGS: u32 = 12;

/// Where in the bracket between `outside` and `inside` (lattice coordinates of two samples, the
/// threshold reached at the second only) the threshold is reached first, by bisection. The upper end
/// of the last bracket is returned, so that the threshold is reached there. `reached` says at which
/// lattice coordinates it is.
///
/// Bisection, not a secant: it needs no value outside, so that it also finds the face of a clip box,
/// and it cannot leave the bracket.
#[inline(always)]
fn refine<S: Level>(
    mut outside: F32s<S>,
    mut inside: F32s<S>,
    reached: impl Fn(F32s<S>) -> Mask<S>,
) -> F32s<S> {
    for _ in 0..HALVINGS {
        let middle = (outside + inside) * F32s::splat(0.5);
        let reached = reached(middle);
        inside = reached.select(middle, inside);
        outside = reached.select(outside, middle);
    }
    inside
}
