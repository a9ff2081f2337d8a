//! Label volumes with numbers in place of ids.

use crate::{ContentId, Control, Error, Key, LabelIds, LabelVolume, memory};
use std::collections::BTreeSet;

/// What a label volume holds, with the place of each id among all in place of the id: however large ids are,
/// a table has an entry for each number.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelNumbers {
    /// The ids that voxels have, ascending.
    pub ids: Vec<u32>,
    /// The number of each voxel's id, x fastest, in the narrowest type.
    pub numbers: LabelIds,
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
        of_voxels + size_of_val(&value.ids[..])
    }
}

impl LabelVolume {
    /// The numbers of its ids.
    ///
    /// # Errors
    /// It was cancelled; no memory.
    pub fn numbers_under(&self, control: &Control) -> Result<LabelNumbers, Error> {
        let (ids, numbers) = match self.ids() {
            LabelIds::U8(ids) => numbered(ids, control),
            LabelIds::U16(ids) => numbered(ids, control),
            LabelIds::U32(ids) => numbered(ids, control),
        }?;
        Ok(LabelNumbers { ids, numbers })
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
) -> Result<(Vec<u32>, LabelIds), Error> {
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
) -> Result<Vec<N>, Error> {
    let mut numbers = memory::reserved(of_voxels.len())?;
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
        let grid = Grid::centered([samples.len(), 1, 1], DVec3::ONE).unwrap();
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
}
