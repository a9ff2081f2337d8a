//! The one ray loop.
//!
//! Rays go in packets. Every lane walks its own lattice; whatever accelerates the walk only decides
//! which lattice points are left out. Slots are chosen once per packet step, so that free
//! composition costs next to nothing.

mod adaptive;
mod backwards;
mod counts;
mod forwards;
mod packet;
mod projection;
mod segments;
mod through_several;
mod through_voxels;

pub use counts::Counts;
pub use packet::Seen;
pub use projection::OfRuns;

use crate::lanes::{F32s, each};
use crate::levels::Level;
use crate::library::composite::state::State;
use crate::library::composite::{maximum, minimum};
use crate::ray_packet::RayPacket;
use crate::scenery::{Object, Scenery};
use crate::skip::Skip;
use packet::Packet;
use segments::{Inside, Shown};
use strahl_scene::plan::{Composite, Sampling};

impl<S: Level> Scenery<'_, S> {
    /// What a packet of rays sees.
    #[inline(always)]
    pub fn march(&self, rays: &RayPacket<S>, of_runs: &mut OfRuns<S>, counts: &mut Counts) -> Seen {
        let mut packet = Packet {
            scenery: self,
            rays,
            to_eye: each!(rays.direction, |d| -d),
            state: State::start(match self.composite {
                Composite::Mip => maximum::START,
                Composite::Minip => minimum::START,
                _ => 0.0,
            }),
            sampled: F32s::zero(),
            visible: F32s::zero(),
            skipped: F32s::zero(),
        };
        let walked = match (self.objects.as_slice(), self.composite) {
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
        if let ([object], Sampling::Refine { parts }, Composite::Mip | Composite::Minip) =
            (self.objects.as_slice(), self.plan.sampling, self.composite)
        {
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
        match object.stored_for(self.scenery.composite, &self.scenery.shading) {
            Some(stored) if S::HAS_LOOPS_PER_TYPE => self.through_voxels(object, stored),
            _ => self.forwards(object),
        }
    }
}

/// Each lane is a whole number of at most 2^24, exact in f32.
#[inline(always)]
fn sum<S: Level>(numbers: F32s<S>) -> u64 {
    let numbers = numbers.to_i32s().to_array();
    numbers.iter().map(|&number| number as u64).sum()
}
