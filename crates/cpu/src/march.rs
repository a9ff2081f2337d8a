//! The one ray loop.
//!
//! Rays go in packets. Every lane walks its own lattice; whatever accelerates the walk only decides
//! which lattice points are left out. Slots are chosen once per packet step, so that free
//! composition costs next to nothing. Rays can be stopped at any lattice point and go on from there.

mod adaptive;
mod counts;
mod packet;
mod points;
mod projection;
mod ray_history;
mod ray_memory;
mod reader;
mod runs;
mod segments;
mod through_labels;
mod through_one;
mod through_segments;
mod through_several;
mod through_voxels;
mod unlit_samples;

pub use counts::Counts;
pub use packet::Seen;
pub use projection::RunBounds;
pub use ray_memory::RayMemory;

use crate::lanes::LANES;
use crate::levels::{Level, Portable, vectorized};
use crate::library::composite::{Rule, with_rule};
use crate::ray_packet::RayPacket;
use crate::ray_state::RayState;
use crate::scenery::{Object, Scenery};
use crate::skip::Skip;
use packet::Packet;
use segments::{Inside, Shown};
use std::ops::Range;
use strahl_scene::plan::{Composite, Plan, Sampling};

impl<S: Level> Scenery<'_, S> {
    /// What a packet of rays sees.
    #[inline(always)]
    pub fn march(
        &self,
        rays: &RayPacket<S>,
        of_runs: &mut RunBounds<S>,
        memory: &mut RayMemory<S>,
        counts: &mut Counts,
    ) -> Seen {
        let mut packet = Packet::new(self, rays, memory);
        match (self.objects.as_slice(), self.composite) {
            _ if self.segments.is_some() => packet.advance(),
            // All of the lattice at once: where extreme values are likely first.
            ([object], Composite::Mip | Composite::Minip)
                if let Some(bounds) = object.skip.as_ref().and_then(Skip::bounds) =>
            {
                packet.project(object, bounds, of_runs);
            }
            _ => packet.advance(),
        }
        packet.end(counts);
        packet.finish()
    }

    /// Moves those rays of a packet on that stand at a lattice point of `interval`, until they stand behind it.
    #[inline(never)]
    pub fn march_through(
        &self,
        rays: &RayPacket<S>,
        interval: &Range<u32>,
        states: &mut [RayState; LANES],
        memory: &mut RayMemory<S>,
    ) {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let mut packet = Packet::new(self, rays, memory);
                packet.resume(states, interval);
                packet.advance();
                packet.store(states);
            },
        );
    }

    /// What a packet of rays has seen that have come as far as `states` say.
    #[inline(always)]
    pub fn seen(
        &self,
        rays: &RayPacket<S>,
        states: &[RayState; LANES],
        memory: &mut RayMemory<S>,
        counts: &mut Counts,
    ) -> Seen {
        let mut packet = Packet::new(self, rays, memory);
        packet.resume(states, &(0..0));
        packet.end(counts);
        packet.finish()
    }
}

/// A ray of `plan` before its first lattice point.
pub fn start(plan: &Plan) -> RayState {
    let state = with_rule!(plan.composite(), rule => rule.start::<Portable>());
    RayState {
        value: state.value.lane(0),
        ..RayState::default()
    }
}

impl<S: Level> Packet<'_, S> {
    /// Goes on by the loop of the Plan.
    #[inline(always)]
    fn advance(&mut self) {
        if let Some(segments) = &self.scenery.segments {
            return match &self.scenery.looks {
                Some(looks) => self.through_segments(segments, looks),
                None => self.through_labels(segments),
            };
        }
        match self.scenery.objects.as_slice() {
            [object] => match self.scenery.composite {
                Composite::EmissionAbsorption { .. } => self.by_rule(object),
                Composite::FirstHit { .. }
                | Composite::Mida { .. }
                | Composite::ContextPreserving { .. }
                | Composite::ImportanceAware { .. } => {
                    self.at_lattice_points(object);
                }
                _ => self.through_one(object),
            },
            _ => self.through_several(),
        }
    }

    /// Front to back through one volume by the Plan's rule of sampling.
    #[inline(always)]
    fn by_rule(&mut self, object: &Object<S>) {
        match self.scenery.plan.sampling {
            Sampling::Regular | Sampling::ByOpacity { .. } => self.at_lattice_points(object),
            Sampling::Refine { parts } => {
                self.by_segments(object, Shown::InParts(parts, Inside::Reconstructed));
            }
            Sampling::Split { parts, curve } => {
                self.by_segments(object, Shown::InParts(parts, Inside::Between(curve)));
            }
            Sampling::Integrated => {
                let integrals = object.integrals.as_ref();
                let integrals = integrals.expect("objects have them where the rule asks");
                self.by_segments(object, Shown::AsIntegrals(integrals));
            }
            Sampling::Adaptive { .. } => self.by_runs(object),
        }
    }

    /// Front to back through one volume, by the loop of its type of sample if there is one.
    #[inline(always)]
    fn at_lattice_points(&mut self, object: &Object<S>) {
        match object.stored_for(self.scenery.composite) {
            Some(stored) if S::HAS_LOOPS_PER_TYPE => self.through_voxels(object, stored),
            _ => self.through_one(object),
        }
    }
}
