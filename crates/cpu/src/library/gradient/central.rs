use crate::lanes::{F32s, Vec3s};
use crate::library::{fetch::Fetch, reconstruct::Reconstruction};

/// Central differences of reconstructed values, one voxel to either side along each voxel axis.
#[inline(always)]
pub fn per_voxel<F: Fetch>(reconstruction: &Reconstruction, fetch: &F, position: Vec3s) -> Vec3s {
    let half = F32s::splat(0.5);
    let mut gradient = [F32s::ZERO; 3];
    for axis in 0..3 {
        let (mut behind, mut ahead) = (position, position);
        behind[axis] = position[axis] - F32s::splat(1.0);
        ahead[axis] = position[axis] + F32s::splat(1.0);
        let difference = reconstruction.value(fetch, ahead) - reconstruction.value(fetch, behind);
        gradient[axis] = difference * half;
    }
    gradient
}
