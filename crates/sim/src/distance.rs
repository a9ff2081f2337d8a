//! Distance coding in software: two raster passes with chessboard masks (document §8.1), and how far a ray may leap.
//!
//! The printed second pass forgets the voxel's own value, and clamps and divides in place, which corrupts what follows.
//! Here own = min(own, 1 + min of 13), then steps are made of distances separately.

use crate::distance_engine::{FARTHEST, in_columns};
use crate::spec::{Leaping, Optimisation};
use crate::stages::classify::Tables;
use crate::stages::fetch::Voxels;

/// The distance store: how many steps a ray may go from a cell, 0 where the cell is not empty.
#[derive(Clone, Debug)]
pub struct DistanceStore {
    dims: [i32; 3],
    shift: u32,
    steps: Vec<u8>,
    /// Clocks that the circuit has taken to code it; 0 for software.
    pub coding_clocks: u64,
}

impl DistanceStore {
    /// For a frame whose steps are at most `largest_step` voxels along every axis; `nominal_step` is what the document
    /// divides by. None without leaping.
    pub fn new(
        optimisation: &Optimisation,
        voxels: &Voxels,
        tables: &Tables,
        distance_bits: u32,
        nominal_step: f64,
        largest_step: f64,
    ) -> Option<DistanceStore> {
        let shift = optimisation.distance_block.trailing_zeros();
        let most = (1u32 << distance_bits) - 1;
        let code = |dims, empty: &[bool]| match optimisation.distance_engine {
            None => (chessboard(dims, empty), 0),
            Some(engine) => in_columns(dims, empty, engine),
        };
        match optimisation.leaping {
            Leaping::Off => None,
            Leaping::Safe => {
                let (dims, empty) = empty_cells(voxels, tables, optimisation.leap_homogeneous);
                let (dims, empty) = match shift {
                    0 => (dims, empty),
                    _ => blocks(dims, &empty, true),
                };
                let (distance, clocks) = code(dims, &empty);
                // Behind the layer of cells at −1, which no ray looks up but must not leap over.
                let inner = dims.map(|n| n - 1);
                let edge = f64::from(1u32 << shift);
                let steps = from_map(inner, |[x, y, z]| {
                    let d = distance[index(dims, [x + 1, y + 1, z + 1])];
                    match d {
                        0 => 0,
                        // All cells less than edge · (d − 1) + 1 away are empty.
                        d => leap(edge * f64::from(d - 1) / largest_step + 1.0, most),
                    }
                });
                Some(DistanceStore::of(inner, shift, steps, clocks))
            }
            Leaping::Document => {
                let dims = voxels.dims();
                let visible = tables.visible_up_to();
                let empty: Vec<bool> = voxels
                    .words()
                    .iter()
                    .map(|w| visible[*w as usize + 1] == visible[*w as usize])
                    .collect();
                let (dims, empty) = match shift {
                    0 => (dims, empty),
                    _ => blocks(dims, &empty, false),
                };
                let (distance, clocks) = code(dims, &empty);
                let edge = f64::from(1u32 << shift);
                let steps = from_map(dims, |at| match distance[index(dims, at)] {
                    0 => 0,
                    d => leap((edge * f64::from(d - 1) + 1.0) / nominal_step, most),
                });
                Some(DistanceStore::of(dims, shift, steps, clocks))
            }
        }
    }

    fn of(dims: [usize; 3], shift: u32, steps: Vec<u8>, coding_clocks: u64) -> DistanceStore {
        DistanceStore {
            dims: dims.map(|n| n as i32),
            shift,
            steps,
            coding_clocks,
        }
    }

    /// Words along x, y, z, and how many bits of a cell's coordinates they share.
    pub(crate) fn words(&self) -> ([usize; 3], u32) {
        (self.dims.map(|n| n as usize), self.shift)
    }

    /// A store as it was written, a word per cell of a volume of `dims` voxels; what was not written is 0.
    pub(crate) fn of_words(dims: [usize; 3], words: &[u8]) -> DistanceStore {
        let mut steps = words.to_vec();
        steps.resize(dims.iter().product(), 0);
        DistanceStore::of(dims, 0, steps, 0)
    }

    /// A word per cell of a volume of `dims` voxels.
    pub(crate) fn cells(&self, dims: [usize; 3]) -> Vec<u8> {
        from_map(dims, |at| self.steps(at.map(|c| c as i32)))
    }

    /// The distance word of a cell: steps to go, 0 where the cell is not empty or outside the store.
    #[inline(always)]
    pub fn steps(&self, cell: [i32; 3]) -> u8 {
        let [x, y, z] = cell.map(|c| c >> self.shift);
        let [nx, ny, nz] = self.dims;
        if (x as u32) < nx as u32 && (y as u32) < ny as u32 && (z as u32) < nz as u32 {
            self.steps[x as usize + nx as usize * (y as usize + ny as usize * z as usize)]
        } else {
            0
        }
    }

    /// Bytes of the store.
    pub fn bytes(&self) -> usize {
        self.steps.len()
    }
}

fn leap(steps: f64, most: u32) -> u8 {
    (steps.floor().max(1.0) as u32).min(most) as u8
}

fn index([nx, ny, _]: [usize; 3], [x, y, z]: [usize; 3]) -> usize {
    x + nx * (y + ny * z)
}

fn from_map<T>(dims: [usize; 3], mut f: impl FnMut([usize; 3]) -> T) -> Vec<T> {
    let mut all = Vec::with_capacity(dims.iter().product());
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                all.push(f([x, y, z]));
            }
        }
    }
    all
}

/// For cells −1 ..= n − 1 of every axis (index + 1), whether nothing in the cell can be seen: no word between the
/// smallest and the largest of its corners has opacity. Voxels outside are 0.
fn empty_cells(voxels: &Voxels, tables: &Tables, homogeneous: bool) -> ([usize; 3], Vec<bool>) {
    let visible = tables.visible_up_to();
    let dims = voxels.dims().map(|n| n + 1);
    let empty = from_map(dims, |at| {
        let [x, y, z] = at.map(|c| c as i32 - 1);
        let (mut low, mut high) = (u16::MAX, 0);
        for corner in 0..8 {
            let word = voxels.word([x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2)]);
            low = low.min(word);
            high = high.max(word);
        }
        visible[high as usize + 1] == visible[low as usize] || (homogeneous && low == high)
    });
    (dims, empty)
}

/// Blocks of 2³, empty where all are. With `has_border` the first layer along every axis is a block of its own.
fn blocks(dims: [usize; 3], empty: &[bool], has_border: bool) -> ([usize; 3], Vec<bool>) {
    let border = usize::from(has_border);
    let blocks = dims.map(|n| (n - border).div_ceil(2) + border);
    let range = |b: usize, n: usize| match (has_border, b) {
        (true, 0) => 0..1,
        (true, b) => 2 * b - 1..(2 * b + 1).min(n),
        (false, b) => 2 * b..(2 * b + 2).min(n),
    };
    let all = from_map(blocks, |[bx, by, bz]| {
        range(bz, dims[2]).all(|z| {
            range(by, dims[1]).all(|y| range(bx, dims[0]).all(|x| empty[index(dims, [x, y, z])]))
        })
    });
    (blocks, all)
}

/// Chessboard distance of every element to the next that is not empty, at most [`FARTHEST`]; outside all is empty.
pub fn chessboard(dims: [usize; 3], empty: &[bool]) -> Vec<u8> {
    // One layer of `FARTHEST` around everything stands for what is outside.
    let padded = dims.map(|n| n + 2);
    let row = padded[0];
    let plane = padded[0] * padded[1];
    let mut distance = vec![FARTHEST; plane * padded[2]];
    let near = [
        1,
        row - 1,
        row,
        row + 1,
        plane - row - 1,
        plane - row,
        plane - row + 1,
        plane - 1,
        plane,
        plane + 1,
        plane + row - 1,
        plane + row,
        plane + row + 1,
    ];
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                let at = index(padded, [x + 1, y + 1, z + 1]);
                distance[at] = match empty[index(dims, [x, y, z])] {
                    false => 0,
                    true => near
                        .iter()
                        .fold(FARTHEST, |m, n| m.min(distance[at - n]))
                        .saturating_add(1),
                };
            }
        }
    }
    for z in (0..dims[2]).rev() {
        for y in (0..dims[1]).rev() {
            for x in (0..dims[0]).rev() {
                let at = index(padded, [x + 1, y + 1, z + 1]);
                let after = near
                    .iter()
                    .fold(FARTHEST, |m, n| m.min(distance[at + n]))
                    .saturating_add(1);
                distance[at] = distance[at].min(after);
            }
        }
    }
    from_map(dims, |[x, y, z]| {
        distance[index(padded, [x + 1, y + 1, z + 1])]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn distances_are_those_of_a_search(
            nx in 1usize..9, ny in 1usize..9, nz in 1usize..9, seed in prop::collection::vec(0u8..20, 512),
        ) {
            let dims = [nx, ny, nz];
            let empty: Vec<bool> = (0..nx * ny * nz).map(|i| seed[i % seed.len()] > 0).collect();
            let got = chessboard(dims, &empty);
            let all: Vec<[usize; 3]> = from_map(dims, |at| at);
            for at in &all {
                let nearest = all.iter().filter(|b| !empty[index(dims, **b)]).map(|b| {
                    (0..3).map(|i| at[i].abs_diff(b[i])).max().unwrap_or(0)
                }).min();
                let expected = nearest.map_or(FARTHEST, |d| d.min(255) as u8);
                prop_assert_eq!(got[index(dims, *at)], expected);
            }
        }
    }
}
