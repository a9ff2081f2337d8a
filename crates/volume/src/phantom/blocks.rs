//! Sampling a field block by block, with less to compute where little of it matters.

use super::number::Interval;
use super::solid::Point;
use crate::rows::for_each_row;
use crate::{Control, Error, Grid, Work, memory};
use glam::DVec3;

/// Edge of a block in voxels, and thickness of the slab that one task fills.
const BLOCK: usize = 8;

/// Samples that are filled with nothing at once.
const PIECE: usize = 1 << 20;

/// One number per voxel of an axis-aligned `grid`, x fastest.
///
/// For every block of voxels `prune` gets its box and writes to the scratch what matters there; where it says
/// that nothing does the numbers are `nothing`, elsewhere `at` gives them for each voxel center. As
/// every number depends on its own voxel only, the bytes are the same at any number of threads.
///
/// # Errors
/// No memory for the samples; `control` was cancelled.
pub fn fill<T: Copy + Send + Sync, S>(
    grid: &Grid,
    nothing: T,
    scratch: impl Fn() -> S + Sync,
    prune: impl Fn(Point<Interval>, &mut S) -> bool + Sync,
    at: impl Fn(Point<f64>, &S) -> T + Sync,
    control: &Control,
) -> Result<Vec<T>, Error> {
    let [nx, ny, nz] = grid.dims();
    let count = grid.voxel_count();
    let mut samples = memory::reserved(count)?;
    while samples.len() < count {
        control.check()?;
        samples.resize(count.min(samples.len() + PIECE), nothing);
    }

    let world_from_voxel = grid.world_from_voxel();
    let world = |x: usize, y: usize, z: usize| {
        world_from_voxel.transform_point3(DVec3::new(x as f64, y as f64, z as f64))
    };
    let fill_slab = |slab: usize, samples: &mut [T]| {
        let mut scratch = scratch();
        let z0 = slab * BLOCK;
        let nz = samples.len() / (nx * ny);
        for y0 in (0..ny).step_by(BLOCK) {
            let y1 = (y0 + BLOCK).min(ny);
            for x0 in (0..nx).step_by(BLOCK) {
                if control.is_cancelled() {
                    return;
                }
                let x1 = (x0 + BLOCK).min(nx);
                let (lo, hi) = (world(x0, y0, z0), world(x1 - 1, y1 - 1, z0 + nz - 1));
                let bounds = [
                    Interval::new(lo.x, hi.x),
                    Interval::new(lo.y, hi.y),
                    Interval::new(lo.z, hi.z),
                ];
                if !prune(bounds, &mut scratch) {
                    continue;
                }
                for z in 0..nz {
                    for y in y0..y1 {
                        for x in x0..x1 {
                            samples[x + nx * (y + ny * z)] =
                                at(world(x, y, z0 + z).to_array(), &scratch);
                        }
                    }
                }
            }
        }
    };
    let parts = control.parts(Work::Reading, nz.div_ceil(BLOCK));
    for_each_row(&mut samples, nx * ny * BLOCK, &parts, fill_slab)?;
    Ok(samples)
}
