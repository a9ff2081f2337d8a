//! Slot reconstruct: the value at any place from the voxels around it.

mod b_spline;
mod catmull_rom;
mod nearest;
mod trilinear;

pub use b_spline::weights as b_spline_weights;

use crate::lanes::{F32s, I32s, Vec3s};
use crate::library::fetch::{Fetch, Linear, Shape};
use strahl_scene::plan::Reconstruct;
use strahl_volume::{Grid, Rescale, Samples, with_samples};

/// The values of a volume anywhere: fetch, reconstruction and rescale in one, chosen once per object.
///
/// A call through a table per packet costs little beside the eight times eight fetches behind it,
/// and the loop is compiled once instead of once per type of sample.
pub trait Values: Sync {
    /// The size of the grid.
    fn shape(&self) -> &Shape;
    /// The values at `position` (voxel space).
    fn at(&self, position: Vec3s) -> F32s;
    /// The values of single voxels; indices beyond the border give the voxel at the border.
    fn voxel(&self, voxel: [I32s; 3]) -> F32s;
}

/// The values of `samples` on `grid`.
pub fn values<'v>(
    grid: &Grid,
    samples: &'v Samples,
    rescale: Rescale,
    method: Reconstruct,
) -> Box<dyn Values + 'v> {
    with_samples!(samples, samples => of_fetch(Linear::new(grid, samples), rescale, method))
}

/// The values of voxels that any function gives.
pub fn of_fetch<'v, F: Fetch + 'v>(
    fetch: F,
    rescale: Rescale,
    method: Reconstruct,
) -> Box<dyn Values + 'v> {
    Box::new(Reconstruction {
        fetch,
        method,
        slope: rescale.slope as f32,
        intercept: rescale.intercept as f32,
    })
}

/// How values are found: reconstruction of stored numbers, then slope and intercept.
struct Reconstruction<F> {
    fetch: F,
    method: Reconstruct,
    slope: f32,
    intercept: f32,
}

impl<F> Reconstruction<F> {
    #[inline(always)]
    fn rescaled(&self, stored: F32s) -> F32s {
        stored * F32s::splat(self.slope) + F32s::splat(self.intercept)
    }
}

impl<F: Fetch> Values for Reconstruction<F> {
    fn shape(&self) -> &Shape {
        self.fetch.shape()
    }

    fn at(&self, position: Vec3s) -> F32s {
        self.rescaled(match self.method {
            Reconstruct::Nearest => nearest::stored(&self.fetch, position),
            Reconstruct::Trilinear => trilinear::stored(&self.fetch, position),
            // The fetched numbers are coefficients if the spline shall interpolate.
            Reconstruct::BSpline | Reconstruct::BSplineInterpolating => {
                b_spline::stored(&self.fetch, position)
            }
            Reconstruct::CatmullRom => catmull_rom::stored(&self.fetch, position),
        })
    }

    fn voxel(&self, voxel: [I32s; 3]) -> F32s {
        let shape = self.fetch.shape();
        self.rescaled(self.fetch.fetch(shape.index(shape.clamp_voxel(voxel))))
    }
}

/// A separable cubic kernel over the 4 × 4 × 4 voxels around a position, which is clamped to the hull
/// of the voxel centres, and so are the voxels.
#[inline(always)]
fn cubic<F: Fetch>(fetch: &F, position: Vec3s, weights: impl Fn(F32s) -> [F32s; 4]) -> F32s {
    let shape = fetch.shape();
    let clamped = shape.clamp(position);
    let cell = shape.cell(clamped);
    let weights = [0, 1, 2].map(|axis| weights(clamped[axis] - cell[axis].to_f32s()));
    let tap = |tap: usize| {
        let offset = I32s([tap as i32 - 1; _]);
        shape.clamp_voxel([cell[0] + offset, cell[1] + offset, cell[2] + offset])
    };
    let taps = [tap(0), tap(1), tap(2), tap(3)];
    let mut sum = F32s::ZERO;
    for z in 0..4 {
        let mut plane = F32s::ZERO;
        for y in 0..4 {
            let mut row = F32s::ZERO;
            for x in 0..4 {
                let index = shape.index([taps[x][0], taps[y][1], taps[z][2]]);
                row += fetch.fetch(index) * weights[0][x];
            }
            plane += row * weights[1][y];
        }
        sum += plane * weights[2][z];
    }
    sum
}
