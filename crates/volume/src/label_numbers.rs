//! Label volumes with numbers in place of ids.

use crate::{Cancelled, ContentId, Control, Key, LabelIds, LabelVolume, cores};
use std::collections::BTreeSet;

/// What a label volume holds, with the place of each id among all in place of the id: however large ids are,
/// a table has an entry for each number.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelNumbers {
    /// The ids that voxels have, ascending.
    pub ids: Vec<u32>,
    /// The number of each voxel's id, x fastest, in the narrowest type.
    pub numbers: LabelIds,
    /// Which cells have corners of several ids.
    pub borders: BorderCells,
}

/// Which cells, each between 2 × 2 × 2 voxels, have corners with different ids: a bit each, that of a cell at its first
/// corner. Those at the far faces have fewer corners.
#[derive(Clone, Debug, PartialEq)]
pub struct BorderCells {
    bits: Vec<u64>,
    words_per_row: usize,
    rows_per_slice: usize,
}

/// Key of the numbers of a label volume's ids.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelNumbersKey(pub ContentId);

impl Key for LabelNumbersKey {
    type Value = LabelNumbers;

    const NAME: &str = "numbers of labels";

    fn bytes(&self, value: &LabelNumbers) -> usize {
        let of_voxels = match &value.numbers {
            LabelIds::U8(numbers) => size_of_val(&numbers[..]),
            LabelIds::U16(numbers) => size_of_val(&numbers[..]),
            LabelIds::U32(numbers) => size_of_val(&numbers[..]),
        };
        of_voxels + size_of_val(&value.ids[..]) + size_of_val(&value.borders.bits[..])
    }
}

impl LabelVolume {
    /// The numbers of its ids.
    ///
    /// # Errors
    /// It was cancelled.
    pub fn numbers_under(&self, control: &Control) -> Result<LabelNumbers, Cancelled> {
        let (ids, numbers) = match self.ids() {
            LabelIds::U8(ids) => numbered(ids, control),
            LabelIds::U16(ids) => numbered(ids, control),
            LabelIds::U32(ids) => numbered(ids, control),
        }?;
        let dims = self.grid().dims();
        let borders = match &numbers {
            LabelIds::U8(numbers) => BorderCells::under(numbers, dims, control),
            LabelIds::U16(numbers) => BorderCells::under(numbers, dims, control),
            LabelIds::U32(numbers) => BorderCells::under(numbers, dims, control),
        }?;
        Ok(LabelNumbers {
            ids,
            numbers,
            borders,
        })
    }
}

impl BorderCells {
    fn under<T: PartialEq + Sync>(
        of_voxels: &[T],
        [nx, ny, nz]: [usize; 3],
        control: &Control,
    ) -> Result<BorderCells, Cancelled> {
        let words_per_row = nx.div_ceil(64);
        let mut bits = vec![0u64; words_per_row * ny * nz];
        let slices = bits.chunks_mut(words_per_row * ny).enumerate();
        cores::try_for_each(
            slices,
            || (),
            |(), (z, slice)| {
                control.check()?;
                for (y, words) in slice.chunks_mut(words_per_row).enumerate() {
                    let row = |y: usize, z: usize| {
                        let first = nx * (y.min(ny - 1) + ny * z.min(nz - 1));
                        &of_voxels[first..first + nx]
                    };
                    let rows = [row(y, z), row(y + 1, z), row(y, z + 1), row(y + 1, z + 1)];
                    for x in 0..nx {
                        let (id, next) = (&rows[0][x], (x + 1).min(nx - 1));
                        let differs = rows.iter().any(|row| row[x] != *id || row[next] != *id);
                        words[x / 64] |= u64::from(differs) << (x % 64);
                    }
                }
                Ok(())
            },
        )?;
        Ok(BorderCells {
            bits,
            words_per_row,
            rows_per_slice: ny,
        })
    }

    /// Whether the cell whose first corner is this voxel has corners with different ids.
    ///
    /// # Panics
    /// If there is no such voxel.
    #[inline]
    pub fn has(&self, [x, y, z]: [usize; 3]) -> bool {
        let row = y + self.rows_per_slice * z;
        self.bits[row * self.words_per_row + x / 64] >> (x % 64) & 1 == 1
    }
}

/// Voxels between two questions whether to go on.
const PART: usize = 1 << 16;

/// Labels lie in runs: whatever is asked of one is asked once.
fn runs<T: PartialEq>(ids: &[T]) -> impl Iterator<Item = &[T]> {
    ids.chunk_by(|a, b| a == b)
}

fn numbered<T: Copy + Into<u32> + PartialEq>(
    of_voxels: &[T],
    control: &Control,
) -> Result<(Vec<u32>, LabelIds), Cancelled> {
    let mut ids = BTreeSet::new();
    for part in of_voxels.chunks(PART) {
        control.check()?;
        ids.extend(runs(part).map(|run| -> u32 { run[0].into() }));
    }
    let ids: Vec<u32> = ids.into_iter().collect();
    let numbers = match ids.len() {
        0..=0x100 => LabelIds::U8(spread(of_voxels, &ids, control, |number| number as u8)?),
        0x101..=0x1_0000 => LabelIds::U16(spread(of_voxels, &ids, control, |n| n as u16)?),
        _ => LabelIds::U32(spread(of_voxels, &ids, control, |number| number as u32)?),
    };
    Ok((ids, numbers))
}

fn spread<T: Copy + Into<u32> + PartialEq, N: Copy>(
    of_voxels: &[T],
    ids: &[u32],
    control: &Control,
    narrow: impl Fn(usize) -> N,
) -> Result<Vec<N>, Cancelled> {
    let mut numbers = Vec::with_capacity(of_voxels.len());
    for part in of_voxels.chunks(PART) {
        control.check()?;
        for run in runs(part) {
            let id = run[0].into();
            let number = narrow(ids.partition_point(|other| *other < id));
            numbers.resize(numbers.len() + run.len(), number);
        }
    }
    Ok(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Grid, Metadata, Rescale, Samples, Volume};
    use glam::DVec3;

    fn of(samples: Samples) -> LabelNumbers {
        let grid = Grid::centred([samples.len(), 1, 1], DVec3::ONE).unwrap();
        let volume = Volume::new(grid, samples, Rescale::IDENTITY, Metadata::default()).unwrap();
        LabelVolume::from_volume(volume, Vec::new())
            .unwrap()
            .numbers_under(&Control::NONE)
            .unwrap()
    }

    #[test]
    fn numbers_stand_for_ids_in_their_order() {
        let wide = of(Samples::U32(vec![7, 7, u32::MAX, 0, 7]));
        assert_eq!(wide.ids, [0, 7, u32::MAX]);
        assert_eq!(wide.numbers, LabelIds::U8(vec![1, 1, 2, 0, 1]));
        let many: Vec<u16> = (0..300).rev().collect();
        let many = of(Samples::U16(many));
        let LabelIds::U16(numbers) = &many.numbers else {
            panic!("{:?}", many.numbers)
        };
        assert_eq!((many.ids.len(), numbers[0], numbers[299]), (300, 299, 0));
    }
    #[test]
    fn cells_at_borders_have_corners_of_several_ids() {
        let dims = [70, 5, 4];
        let grid = Grid::centred(dims, DVec3::ONE).unwrap();
        let count = dims.iter().product::<usize>();
        let ids: Vec<u8> = (0..count).map(|i| u8::from(i * i % 97 < 6)).collect();
        let samples = Samples::U8(ids);
        let volume = Volume::new(grid, samples, Rescale::IDENTITY, Metadata::default()).unwrap();
        let labels = LabelVolume::from_volume(volume, Vec::new()).unwrap();
        let borders = labels.numbers_under(&Control::NONE).unwrap().borders;
        let mut found = 0;
        for i in 0..count {
            let cell = [i % 70, i / 70 % 5, i / 350];
            let corner = |k: usize| {
                let at = |axis: usize| (cell[axis] + (k >> axis & 1)).min(dims[axis] - 1);
                labels.id(at(0), at(1), at(2))
            };
            let differs = (1..8).any(|k| corner(k) != corner(0));
            assert_eq!(borders.has(cell), differs, "{cell:?}");
            found += usize::from(differs);
        }
        assert!((100..count - 100).contains(&found), "{found}");
    }
}
