//! The bricks that the cells of a volume lie in, and their numbers.

use crate::lanes::{I32s, each};
use crate::levels::Level;

/// Cells along the edge of the bricks: of the samples of typical scans half as many lie in visible
/// bricks of 4 as in those of 8; the octants' cubes are then 12.5 % of a `u8` volume.
pub const EDGE: usize = 4;

/// Of a cell's number, to that of its brick.
pub const SHIFT: u32 = EDGE.trailing_zeros();

/// The number of the brick that each cell lies in, of `dims` bricks along the axes.
#[inline(always)]
pub fn brick_number<S: Level>(dims: [i32; 3], cell: [I32s<S>; 3]) -> I32s<S> {
    brick_number_of(dims, SHIFT, cell)
}

/// The same for bricks of 2^`shift` cells along the edge.
#[inline(always)]
pub fn brick_number_of<S: Level>(dims: [i32; 3], shift: u32, cell: [I32s<S>; 3]) -> I32s<S> {
    let brick = each!(cell, |c| c.shifted_down(shift));
    let slice = dims[0] * dims[1];
    brick[0] + brick[1] * I32s::splat(dims[0]) + brick[2] * I32s::splat(slice)
}
