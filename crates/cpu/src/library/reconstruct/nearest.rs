use crate::lanes::{F32s, Vec3s};
use crate::library::fetch::Fetch;

/// The stored number of the nearest voxel; halfway between two, the one with the higher index.
#[inline(always)]
pub fn stored<F: Fetch>(fetch: &F, position: Vec3s) -> F32s {
    let shape = fetch.shape();
    let half = F32s::splat(0.5);
    let clamped = shape.clamp([position[0] + half, position[1] + half, position[2] + half]);
    fetch.fetch(shape.index(clamped.map(F32s::to_i32s)))
}
