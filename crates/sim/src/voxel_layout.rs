//! Which module, bank, row and column a voxel lies in (document §7.5).
//!
//! | target | M8 | M1 interleaved | M1 linear |
//! |---|---|---|---|
//! | module | x⁰ y⁰ z⁰ | – | – |
//! | column (512) | next 3 bits of each | lowest 3 bits of each | x, 9 bits |
//! | bank (4) | next bit of x and y | the same | z³ z⁴ |
//! | chip (2) | next bit of z | the same | z⁵ |
//! | row | the rest | the same | y, 9 bits; z⁰⁻² |
//!
//! Other numbers of columns and banks deal their bits out to x, y, z in turn. Rows of blocks are counted without gaps, and
//! those beyond the rows of a bank lie in the next pair of chips.

use crate::Error;
use crate::spec::{Memory, MemoryModel};

/// Place of a voxel in its module.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Bank, counted over all chips of the module.
    pub bank: u32,
    /// Row of that bank.
    pub row: u32,
    /// Word of that row.
    pub column: u32,
}

/// Places as sums over tables, one table per axis.
#[derive(Clone, Debug)]
pub struct VoxelLayout {
    /// 8 or 1.
    pub modules: usize,
    /// Banks of a module, over all its chips.
    pub banks: usize,
    /// Voxels along x, y, z.
    pub dims: [i32; 3],
    /// Low bits of a coordinate that do not change the row, all ones.
    pub block_mask: [i32; 3],
    /// Rows that the volume takes in every bank, and how many there are.
    pub rows_needed: [u64; 2],
    axes: [Vec<Place>; 3],
    rows: u32,
    banks_per_pair: u32,
    is_spread: bool,
}

impl VoxelLayout {
    /// The layout of a volume.
    ///
    /// # Errors
    /// If it does not fit into the memory.
    pub fn new(memory: &Memory, dims: [usize; 3]) -> Result<VoxelLayout, Error> {
        let bank_bits = memory.banks.ilog2();
        let pair = memory.chips.min(2);
        let mut axes: [Vec<Place>; 3] = dims.map(|n| vec![Place::default(); n]);
        let mut block_mask = [0; 3];
        let rows_needed;
        match memory.model {
            MemoryModel::M8 | MemoryModel::M1Interleaved => {
                let module_bits = u32::from(memory.model == MemoryModel::M8);
                let column_bits = memory.columns.ilog2();
                let columns = [
                    column_bits.div_ceil(3),
                    (column_bits + 1) / 3,
                    column_bits / 3,
                ];
                let banks = [bank_bits.div_ceil(2), bank_bits / 2, pair.ilog2()];
                let mut counts = [0; 3];
                for axis in 0..3 {
                    let below = module_bits + columns[axis];
                    block_mask[axis] = (1 << below) - 1;
                    counts[axis] = ((dims[axis] as u32 - 1) >> (below + banks[axis])) + 1;
                }
                let stride = [1, counts[0], counts[0] * counts[1]];
                let column_shift = [0, columns[0], columns[0] + columns[1]];
                let bank_shift = [0, banks[0], bank_bits];
                for axis in 0..3 {
                    let below = module_bits + columns[axis];
                    for (i, place) in axes[axis].iter_mut().enumerate() {
                        let i = i as u32;
                        let low = |bits: u32| (1u32 << bits) - 1;
                        *place = Place {
                            column: (i >> module_bits & low(columns[axis])) << column_shift[axis],
                            bank: (i >> below & low(banks[axis])) << bank_shift[axis],
                            row: (i >> (below + banks[axis])) * stride[axis],
                        };
                    }
                }
                rows_needed = counts.iter().map(|n| u64::from(*n)).product::<u64>();
            }
            MemoryModel::M1Linear => {
                if let Some(n) = dims.iter().find(|n| **n > 512) {
                    let problem =
                        format!("the linear layout has 9 bits per axis, the volume {n} voxels");
                    return Err(Error::field("memory.model", "m1-linear", problem));
                }
                if memory.columns != 512 || memory.rows < 4096 {
                    let text = format!("{} × {}", memory.columns, memory.rows);
                    let problem = "the linear layout needs 512 columns and 4096 rows";
                    return Err(Error::field("memory.columns × memory.rows", text, problem));
                }
                block_mask = [511, 0, 0];
                for (i, place) in axes[0].iter_mut().enumerate() {
                    place.column = i as u32;
                }
                for (i, place) in axes[1].iter_mut().enumerate() {
                    place.row = i as u32;
                }
                for (i, place) in axes[2].iter_mut().enumerate() {
                    place.row = (i as u32 & 7) << 9;
                    place.bank = i as u32 >> 3;
                }
                let banks_needed = (dims[2] as u32).div_ceil(8);
                let banks = memory.banks * memory.chips;
                if banks_needed > banks {
                    let problem =
                        format!("the volume needs {banks_needed} banks, the memory has {banks}");
                    return Err(Error::field("memory.chips", memory.chips, problem));
                }
                rows_needed = 4096;
            }
        }
        let pairs = memory.chips / pair;
        let most = u64::from(memory.rows)
            * if memory.model == MemoryModel::M1Linear {
                1
            } else {
                u64::from(pairs)
            };
        if rows_needed > most {
            return Err(Error::field(
                "memory.rows",
                memory.rows,
                format!(
                    "the volume needs {rows_needed} rows in every bank, {} × {pairs} pairs of chips have {most}",
                    memory.rows
                ),
            ));
        }
        Ok(VoxelLayout {
            modules: if memory.model == MemoryModel::M8 {
                8
            } else {
                1
            },
            banks: (memory.banks * memory.chips) as usize,
            dims: dims.map(|n| n as i32),
            block_mask,
            rows_needed: [rows_needed, most],
            axes,
            rows: memory.rows,
            banks_per_pair: memory.banks * pair,
            is_spread: rows_needed > u64::from(memory.rows),
        })
    }

    /// Where a voxel of the volume lies in its module.
    #[inline(always)]
    pub fn place(&self, [x, y, z]: [i32; 3]) -> Place {
        let (a, b, c) = (
            self.axes[0][x as usize],
            self.axes[1][y as usize],
            self.axes[2][z as usize],
        );
        let place = Place {
            bank: a.bank + b.bank + c.bank,
            row: a.row + b.row + c.row,
            column: a.column + b.column + c.column,
        };
        if self.is_spread {
            self.spread(place)
        } else {
            place
        }
    }

    #[cold]
    fn spread(&self, place: Place) -> Place {
        Place {
            bank: place.bank + place.row / self.rows * self.banks_per_pair,
            row: place.row % self.rows,
            column: place.column,
        }
    }

    /// The module of a voxel.
    #[inline(always)]
    pub fn module(&self, [x, y, z]: [i32; 3]) -> usize {
        match self.modules {
            8 => ((x & 1) | (y & 1) << 1 | (z & 1) << 2) as usize,
            _ => 0,
        }
    }

    /// Whether all neighbours of a cell lie in the row of S0 (in their modules), and exist.
    #[inline(always)]
    pub fn is_one_row(&self, [x, y, z]: [i32; 3]) -> bool {
        let [mx, my, mz] = self.block_mask;
        let [nx, ny, nz] = self.dims;
        (x & mx) != mx
            && (y & my) != my
            && (z & mz) != mz
            && (x as u32) < (nx - 1) as u32
            && (y as u32) < (ny - 1) as u32
            && (z as u32) < (nz - 1) as u32
    }

    /// Whether the voxel exists.
    #[inline(always)]
    pub fn is_valid(&self, [x, y, z]: [i32; 3]) -> bool {
        let [nx, ny, nz] = self.dims;
        (x as u32) < nx as u32 && (y as u32) < ny as u32 && (z as u32) < nz as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    fn check(memory: Memory, dims: [usize; 3]) {
        let layout = VoxelLayout::new(&memory, dims).unwrap();
        let mut seen = HashSet::new();
        for z in 0..dims[2] as i32 {
            for y in 0..dims[1] as i32 {
                for x in 0..dims[0] as i32 {
                    let at = [x, y, z];
                    let place = layout.place(at);
                    assert!(place.column < memory.columns && place.row < memory.rows);
                    assert!((place.bank as usize) < layout.banks);
                    let key = (layout.module(at), place.bank, place.row, place.column);
                    assert!(seen.insert(key), "{at:?} lies where another voxel does");
                }
            }
        }
    }

    #[test]
    fn no_two_voxels_share_a_word() {
        let memory = Memory::default();
        check(memory, [70, 33, 40]);
        check(
            Memory {
                model: MemoryModel::M1Interleaved,
                ..memory
            },
            [70, 33, 40],
        );
        check(
            Memory {
                model: MemoryModel::M1Linear,
                ..memory
            },
            [70, 33, 40],
        );
        check(
            Memory {
                rows: 3,
                chips: 8,
                ..memory
            },
            [70, 33, 40],
        );
        check(
            Memory {
                columns: 32,
                banks: 16,
                ..memory
            },
            [70, 33, 40],
        );
        check(
            Memory {
                columns: 1024,
                banks: 8,
                chips: 1,
                ..memory
            },
            [70, 33, 40],
        );
    }

    #[test]
    fn the_documents_table() {
        let layout = VoxelLayout::new(&Memory::default(), [512, 512, 512]).unwrap();
        // Neighbouring blocks of 16³ lie in eight different banks of the pair.
        let banks: HashSet<u32> = (0..8)
            .map(|i| {
                layout
                    .place([16 * (i & 1), 16 * (i >> 1 & 1), 16 * (i >> 2)])
                    .bank
            })
            .collect();
        assert_eq!(banks.len(), 8);
        // The last voxel of 512³ uses the last row: 16 chips of 128 Mbit are exactly full.
        assert_eq!(
            layout.place([511, 511, 511]),
            Place {
                bank: 7,
                row: 4095,
                column: 511
            }
        );
        assert_eq!(layout.place([14, 2, 6]).column, 0b011_001_111);
    }

    #[test]
    fn a_memory_that_is_too_small_is_refused() {
        let memory = Memory {
            rows: 2048,
            ..Memory::default()
        };
        let message = VoxelLayout::new(&memory, [512, 512, 512])
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("memory.rows") && message.contains("4096"),
            "{message}"
        );
    }
}
