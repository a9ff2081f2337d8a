use crate::lanes::{F32s, I32s, Vec3s};
use crate::levels::{Level, inlined};
use strahl_volume::Grid;

/// The size of a grid in the forms that reconstruction needs.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Index of the last voxel along each axis; exact, as an edge has at most 2^20 voxels.
    pub last: [f32; 3],
    /// Index of the last cell (between two voxels) along each axis; 0 for an axis of one voxel.
    pub last_cell: [i32; 3],
    /// From a voxel to its neighbor along each axis.
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

    /// A position clamped to the hull of the voxel centers.
    #[inline(always)]
    pub fn clamp<S: Level>(&self, position: Vec3s<S>) -> Vec3s<S> {
        let clamp = inlined(
            #[inline(always)]
            |axis: usize| {
                position[axis]
                    .max(F32s::zero())
                    .min(F32s::splat(self.last[axis]))
            },
        );
        [clamp(0), clamp(1), clamp(2)]
    }

    /// The cell that a clamped position lies in.
    #[inline(always)]
    pub fn cell<S: Level>(&self, clamped: Vec3s<S>) -> [I32s<S>; 3] {
        let cell = inlined(
            #[inline(always)]
            |axis: usize| clamped[axis].to_i32s().min(self.last_cell[axis]),
        );
        [cell(0), cell(1), cell(2)]
    }

    /// A voxel moved to the border if it lies beyond.
    #[inline(always)]
    pub fn clamp_voxel<S: Level>(&self, voxel: [I32s<S>; 3]) -> [I32s<S>; 3] {
        let clamp = inlined(
            #[inline(always)]
            |axis: usize| voxel[axis].max(0).min(self.last[axis] as i32),
        );
        [clamp(0), clamp(1), clamp(2)]
    }

    /// Index of the voxel (x, y, z) in one lane; 64 bits wide, as volumes may exceed 4 GiB.
    #[inline(always)]
    pub fn index<S: Level>(&self, voxel: [I32s<S>; 3], lane: usize) -> usize {
        voxel[0].lane(lane) as usize
            + self.stride[1] * voxel[1].lane(lane) as usize
            + self.stride[2] * voxel[2].lane(lane) as usize
    }
}
