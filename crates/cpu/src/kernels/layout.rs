//! Ways to lay voxels of a byte in memory: what the renderer's own, rows along x, is to be judged by.

use crate::lanes::{F32s, I32s, LANES, PACKET, Vec3s, each, lanes, words};
use crate::levels::{InstructionSet, Level, Task, dispatch, inlined, vectorized};
use crate::library::fetch::{Corners, Fetch, Linear, Shape};
use crate::library::reconstruct::of_voxels;
use glam::DVec3;
use rayon::prelude::*;
use strahl_scene::plan::Reconstruct;
use strahl_volume::{Grid, Rescale};

/// A layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// As they come, x fastest.
    Rows,
    /// Blocks of 8³ voxels: every corner of a cell may lie in another one.
    Bricks,
    /// Blocks of 8³ voxels that share their faces with the next ones, 7³ cells: a cell lies in one.
    BricksWithBorders,
}

/// Voxels along the edge of a block.
const EDGE: usize = 8;
const BLOCK: usize = EDGE * EDGE * EDGE;

impl Layout {
    /// All of them.
    pub const ALL: [Layout; 3] = [Layout::Rows, Layout::Bricks, Layout::BricksWithBorders];

    /// From a block to the next, in voxels; none of rows.
    fn pitch(self) -> usize {
        match self {
            Layout::Rows | Layout::Bricks => EDGE,
            Layout::BricksWithBorders => EDGE - 1,
        }
    }
}

/// Voxels of a cube in a layout.
pub struct LaidOutVoxels<'v> {
    layout: Layout,
    grid: Grid,
    rows: &'v [u8],
    blocks: Vec<u8>,
}

impl<'v> LaidOutVoxels<'v> {
    /// Lays the voxels of `grid`, x fastest, on all cores.
    ///
    /// # Panics
    /// If their number is not that of the grid.
    pub fn new(layout: Layout, grid: Grid, rows: &'v [u8]) -> LaidOutVoxels<'v> {
        assert_eq!(rows.len(), grid.voxel_count());
        let mut blocks = Vec::new();
        if layout != Layout::Rows {
            let number = numbers(layout, &grid);
            // A word can be read anywhere.
            blocks = vec![0; number.iter().product::<usize>() * BLOCK + 3];
            let dims = grid.dims();
            let slices = blocks.par_chunks_exact_mut(number[0] * number[1] * BLOCK);
            slices.take(number[2]).enumerate().for_each(|(bz, slice)| {
                for (i, block) in slice.chunks_exact_mut(BLOCK).enumerate() {
                    let first = [i % number[0], i / number[0], bz].map(|b| b * layout.pitch());
                    for (row, to) in block.chunks_exact_mut(EDGE).enumerate() {
                        let y = (first[1] + row % EDGE).min(dims[1] - 1);
                        let z = (first[2] + row / EDGE).min(dims[2] - 1);
                        let from = &rows[dims[0] * (y + dims[1] * z)..][..dims[0]];
                        let there = EDGE.min(dims[0] - first[0]);
                        to[..there].copy_from_slice(&from[first[0]..][..there]);
                    }
                }
            });
        }
        LaidOutVoxels {
            layout,
            grid,
            rows,
            blocks,
        }
    }

    /// Bytes beside those that were handed over.
    pub fn bytes(&self) -> usize {
        self.blocks.len()
    }

    /// Samples along parallel rays in a `direction`, on one thread: a voxel apart in all directions, through the middle
    /// third of the volume, packet by packet as a picture has them. Gives their number and sum.
    pub fn cross(&self, set: InstructionSet, direction: [f64; 3]) -> (u64, f64) {
        dispatch(
            set,
            Crossing {
                laid: self,
                direction: DVec3::from_array(direction).normalize(),
            },
        )
    }
}

/// Blocks along each axis.
fn numbers(layout: Layout, grid: &Grid) -> [usize; 3] {
    let cells_or_voxels = |n: usize| match layout {
        Layout::BricksWithBorders => n - 1,
        _ => n,
    };
    grid.dims()
        .map(|n| cells_or_voxels(n).div_ceil(layout.pitch()))
}

/// Blocks of either kind.
struct Blocks<'v> {
    voxels: &'v [u8],
    shape: Shape,
    /// From a block to the next along each axis, in bytes.
    stride: [i32; 3],
    has_borders: bool,
}

/// From a voxel to the next inside a block.
const INSIDE: [i32; 3] = [1, EDGE as i32, (EDGE * EDGE) as i32];

impl Blocks<'_> {
    /// What voxels at `index` along an axis add to the offset, and those at the index behind.
    #[inline(always)]
    fn parts<S: Level>(&self, index: I32s<S>, axis: usize) -> [I32s<S>; 2] {
        let stride = I32s::splat(self.stride[axis]);
        let inside = I32s::splat(INSIDE[axis]);
        if self.has_borders {
            // A seventh, exact below 2^15.
            let block = (index * I32s::splat(9363)).shifted_down(16);
            let part = block * stride + (index + block * I32s::splat(1 - EDGE as i32)) * inside;
            return [part, part + inside];
        }
        let part = inlined(
            #[inline(always)]
            |index: I32s<S>| index.shifted_down(3) * stride + index.and(7) * inside,
        );
        [part(index), part(index + I32s::splat(1))]
    }

    #[inline(always)]
    fn word<S: Level>(&self, offset: I32s<S>) -> I32s<S> {
        // SAFETY: offsets are those of voxels, and there are three bytes behind the last.
        unsafe { words(self.voxels, offset) }
    }
}

impl<S: Level> Fetch<S> for Blocks<'_> {
    fn shape(&self) -> &Shape {
        &self.shape
    }

    #[inline(always)]
    unsafe fn fetch(&self, voxel: [I32s<S>; 3]) -> F32s<S> {
        let [x, y, z] = [
            self.parts(voxel[0], 0)[0],
            self.parts(voxel[1], 1)[0],
            self.parts(voxel[2], 2)[0],
        ];
        self.word(x + y + z).and(0xFF).to_f32s()
    }

    #[inline(always)]
    unsafe fn corners(&self, cell: [I32s<S>; 3]) -> Corners<S> {
        let x = self.parts(cell[0], 0);
        let y = self.parts(cell[1], 1);
        let z = self.parts(cell[2], 2);
        let pair = inlined(
            #[inline(always)]
            |row: I32s<S>| {
                let first = self.word(row + x[0]);
                let second = if self.has_borders {
                    first.shifted_down(8)
                } else {
                    self.word(row + x[1])
                };
                [first.and(0xFF).to_f32s(), second.and(0xFF).to_f32s()]
            },
        );
        [
            pair(y[0] + z[0]),
            pair(y[1] + z[0]),
            pair(y[0] + z[1]),
            pair(y[1] + z[1]),
        ]
    }
}

struct Crossing<'l, 'v> {
    laid: &'l LaidOutVoxels<'v>,
    direction: DVec3,
}

impl Task for Crossing<'_, '_> {
    type Output = (u64, f64);

    fn run<S: Level>(self) -> (u64, f64) {
        let LaidOutVoxels {
            layout,
            grid,
            rows,
            blocks,
        } = self.laid;
        let shape = Shape::new(grid);
        let trilinear = Reconstruct::Trilinear;
        let values = match layout {
            Layout::Rows => {
                of_voxels::<S, _>(Linear::new(grid, rows), Rescale::IDENTITY, trilinear)
            }
            Layout::Bricks | Layout::BricksWithBorders => {
                let [nx, ny, _] = numbers(*layout, grid);
                let fetch = Blocks {
                    voxels: blocks,
                    shape,
                    stride: [1, nx, nx * ny].map(|blocks| (blocks * BLOCK) as i32),
                    has_borders: *layout == Layout::BricksWithBorders,
                };
                of_voxels::<S, _>(fetch, Rescale::IDENTITY, trilinear)
            }
        };
        let (right, up) = self.direction.any_orthonormal_pair();
        let edge = DVec3::from_array(grid.dims().map(|n| n as f64));
        // The middle of a parallel projection, as far as rays stay inside.
        let size = (edge.min_element() / 3.0) as usize;
        let corner = (edge - 1.0 - (right + up + self.direction) * size as f64) * 0.5;
        let (mut number, mut sum) = (0, 0.0);
        const TILE: usize = 32;
        for tile in 0..(size / TILE).pow(2) {
            let tile = [tile % (size / TILE), tile / (size / TILE)];
            for packet in 0..TILE * TILE / LANES {
                let across = TILE / PACKET[0];
                let x = tile[0] * TILE + packet % across * PACKET[0];
                let y = tile[1] * TILE + packet / across * PACKET[1];
                let (corner, right, up) = (
                    corner + right * x as f64 + up * y as f64,
                    right.as_vec3(),
                    up.as_vec3(),
                );
                let of_packet = vectorized::<S, _>(
                    #[inline(always)]
                    || {
                        let place = |lane: usize, edge: usize| (lane % edge) as f32;
                        let x = F32s::from_array(lanes(|lane| place(lane, PACKET[0])));
                        let y = F32s::from_array(lanes(|lane| place(lane / PACKET[0], LANES)));
                        let mut position: Vec3s<S> = each!([0, 1, 2], |axis| {
                            F32s::splat(corner[axis] as f32)
                                + x * F32s::splat(right[axis])
                                + y * F32s::splat(up[axis])
                        });
                        let step =
                            each!([0, 1, 2], |axis| F32s::splat(self.direction[axis] as f32));
                        let mut sum = F32s::zero();
                        for _ in 0..size {
                            sum += values.at(position);
                            position = each!([0, 1, 2], |axis| position[axis] + step[axis]);
                        }
                        sum
                    },
                );
                number += (size * LANES) as u64;
                sum += (0..LANES)
                    .map(|lane| f64::from(of_packet.lane(lane)))
                    .sum::<f64>();
            }
        }
        (number, sum)
    }
}
