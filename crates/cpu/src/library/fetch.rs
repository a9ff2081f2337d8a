//! Slot fetch: stored numbers of single voxels, or those that a function gives.

mod marschner_lobb;
mod noise;

pub use marschner_lobb::MarschnerLobb;
pub use noise::Noise;

use crate::lanes::{F32s, I32s, LANES, Vec3s, lanes};
use strahl_volume::{Grid, Sample};

/// Where the voxels of a grid come from. Implemented per stored type and layout; everything above
/// works on numbers.
pub trait Fetch: Sync {
    /// The size of the grid.
    fn shape(&self) -> &Shape;
    /// The stored numbers of the voxels at `index` (x + nx·(y + ny·z), inside the grid).
    fn fetch(&self, index: [usize; LANES]) -> F32s;
}

/// The size of a grid in the forms that reconstruction needs.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Index of the last voxel along each axis.
    pub last: [f32; 3],
    /// Index of the last cell (between two voxels) along each axis; 0 for an axis of one voxel.
    pub last_cell: [i32; 3],
    /// From a voxel to its neighbour along each axis.
    pub stride: [usize; 3],
    /// The same, but 0 for an axis of one voxel: from the lower to the upper corner of a cell.
    pub across: [usize; 3],
}

impl Shape {
    /// The size of `grid`.
    pub fn new(grid: &Grid) -> Shape {
        let dims = grid.dims();
        let stride = [1, dims[0], dims[0] * dims[1]];
        Shape {
            last: dims.map(|n| (n - 1) as f32),
            last_cell: dims.map(|n| n.saturating_sub(2) as i32),
            stride,
            across: [0, 1, 2].map(|axis| if dims[axis] > 1 { stride[axis] } else { 0 }),
        }
    }

    /// A position clamped to the hull of the voxel centres.
    #[inline(always)]
    pub fn clamp(&self, position: Vec3s) -> Vec3s {
        let clamp = |axis: usize| {
            position[axis]
                .max(F32s::ZERO)
                .min(F32s::splat(self.last[axis]))
        };
        [clamp(0), clamp(1), clamp(2)]
    }

    /// The cell that a clamped position lies in.
    #[inline(always)]
    pub fn cell(&self, clamped: Vec3s) -> [I32s; 3] {
        let cell = |axis: usize| clamped[axis].to_i32s().min(self.last_cell[axis]);
        [cell(0), cell(1), cell(2)]
    }

    /// The voxel with this index.
    #[inline(always)]
    pub fn voxel(&self, index: usize) -> [usize; 3] {
        let [_, row, slice] = self.stride;
        [index % row, index % slice / row, index / slice]
    }

    /// A voxel moved to the border if it lies beyond.
    #[inline(always)]
    pub fn clamp_voxel(&self, voxel: [I32s; 3]) -> [I32s; 3] {
        let clamp = |axis: usize| voxel[axis].max(0).min(self.last[axis] as i32);
        [clamp(0), clamp(1), clamp(2)]
    }

    /// Index of the voxel (x, y, z); 64 bits wide, as volumes may exceed 4 GiB.
    #[inline(always)]
    pub fn index(&self, voxel: [I32s; 3]) -> [usize; LANES] {
        lanes(|i| {
            voxel[0].0[i] as usize
                + self.stride[1] * voxel[1].0[i] as usize
                + self.stride[2] * voxel[2].0[i] as usize
        })
    }
}

/// Voxels as they lie in memory, x fastest.
pub struct Linear<'v, T> {
    samples: &'v [T],
    shape: Shape,
}

impl<'v, T: Sample> Linear<'v, T> {
    /// The voxels of `grid`.
    ///
    /// # Panics
    /// If their number is not that of the grid.
    pub fn new(grid: &Grid, samples: &'v [T]) -> Linear<'v, T> {
        assert_eq!(samples.len(), grid.voxel_count());
        Linear {
            samples,
            shape: Shape::new(grid),
        }
    }
}

impl<T: Sample> Fetch for Linear<'_, T> {
    #[inline(always)]
    fn shape(&self) -> &Shape {
        &self.shape
    }

    #[inline(always)]
    fn fetch(&self, index: [usize; LANES]) -> F32s {
        F32s(lanes(|i| self.samples[index[i]].to_f32()))
    }
}
