use crate::lanes::{F32s, Vec3s, each};
use crate::levels::Level;
use crate::library::fetch::Fetch;

/// The stored number of the nearest voxel; halfway between two, the one with the higher index.
#[inline(always)]
pub fn stored<S: Level, F: Fetch<S>>(fetch: &F, position: Vec3s<S>) -> F32s<S> {
    let shape = fetch.shape();
    let half = F32s::splat(0.5);
    let clamped = shape.clamp([position[0] + half, position[1] + half, position[2] + half]);
    // SAFETY: a clamped position lies at a voxel or between voxels of the grid, and is rounded down.
    unsafe { fetch.fetch(each!(clamped, |c| F32s::to_i32s(c))) }
}
