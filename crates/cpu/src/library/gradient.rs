//! Slot gradient: the change of the value, in world space, per mm.

mod central;

use crate::lanes::{F32s, Vec3s};
use crate::library::{fetch::Fetch, reconstruct::Reconstruction};
use strahl_scene::plan::{Gradient, Plan};

/// How gradients are found.
pub struct Gradients {
    method: Gradient,
    /// Gradient in voxel space → in world space: the transpose of `voxel_from_world`.
    world_from_voxel: [[f32; 3]; 3],
}

impl Gradients {
    /// The gradients of `plan`.
    pub fn new(plan: &Plan) -> Gradients {
        let transposed = plan.volume.grid.voxel_from_world().matrix3.transpose();
        let row = |r: usize| transposed.row(r).to_array().map(|v| v as f32);
        Gradients {
            method: plan.gradient,
            world_from_voxel: [row(0), row(1), row(2)],
        }
    }

    /// The gradient at `position` (voxel space).
    #[inline(always)]
    pub fn at<F: Fetch>(
        &self,
        reconstruction: &Reconstruction,
        fetch: &F,
        position: Vec3s,
    ) -> Vec3s {
        let in_voxel = match self.method {
            Gradient::Central => central::per_voxel(reconstruction, fetch, position),
        };
        self.world_from_voxel.map(|row| {
            in_voxel[0] * F32s::splat(row[0])
                + in_voxel[1] * F32s::splat(row[1])
                + in_voxel[2] * F32s::splat(row[2])
        })
    }
}
