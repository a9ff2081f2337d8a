//! Slot reconstruct: the value at any place from the voxels around it.

mod nearest;
mod trilinear;

use crate::lanes::{F32s, Vec3s};
use crate::library::fetch::Fetch;
use strahl_scene::plan::{PlanVolume, Reconstruct};

/// How values are found: reconstruction of stored numbers, then slope and intercept.
#[derive(Clone, Copy)]
pub struct Reconstruction {
    method: Reconstruct,
    slope: f32,
    intercept: f32,
}

impl Reconstruction {
    /// The reconstruction of a Plan.
    pub fn new(method: Reconstruct, volume: &PlanVolume) -> Reconstruction {
        Reconstruction {
            method,
            slope: volume.rescale.slope as f32,
            intercept: volume.rescale.intercept as f32,
        }
    }

    /// The values at `position` (voxel space).
    ///
    /// A call of its own: the loop asks for values in ten places, for eight sample types, and copies
    /// of eight times eight fetches in all of them take minutes to compile and fill the cache.
    #[inline(never)]
    pub fn value<F: Fetch>(&self, fetch: &F, position: Vec3s) -> F32s {
        let stored = match self.method {
            Reconstruct::Nearest => nearest::stored(fetch, position),
            Reconstruct::Trilinear => trilinear::stored(fetch, position),
        };
        stored * F32s::splat(self.slope) + F32s::splat(self.intercept)
    }
}
