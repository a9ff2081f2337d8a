//! The numbers of label voxels in bricks, in a few bits each: what the segment at a place is found from.

use crate::brick_number::{EDGE, brick_number};
use crate::lanes::{F32s, I32s, Mask, each, words_inside};
use crate::levels::{Level, inlined};
use strahl_volume::{ContentId, Control, Error, ErrorKind, Key, LabelIds, LabelNumbers, cores};

/// Corners of the cells of a brick along each axis.
const CORNERS: usize = EDGE + 1;

/// Of the corners of a brick: a byte for the pair along x that each cell has at each of its rows of corners, the next
/// one along y behind it. The lower half of a byte is the first of the pair.
const PAIR_BYTES: usize = CORNERS * EDGE * CORNERS;

/// The most numbers in a brick that half a byte tells apart.
const MOST: usize = 16;

/// The word of a brick with more of them.
const MANY: i32 = i32::MIN;

/// All bricks of a label volume. Cells lie between 2 × 2 × 2 voxels; an axis of one voxel has one layer of cells.
pub struct LabelBricks {
    /// Number of bricks along each axis.
    dims: [i32; 3],
    /// Of each brick the number of its corners counted from 1, where all have the same; [`MANY`]; or, less than 0, all bits
    /// of these inverted: where its block begins, in words of four bytes, and as the lowest bit whether it has more than
    /// two numbers.
    words: Vec<i32>,
    /// Of each other brick: its corners in halves of bytes, then the numbers that these stand for, ascending and counted
    /// from 1, in words.
    blocks: Vec<u8>,
}

/// What is at the corners of a cell of each lane.
pub struct Corners<S: Level> {
    /// Four bits each, x fastest: of those in front, and of those behind.
    low: I32s<S>,
    high: I32s<S>,
    /// Where the block of the brick begins.
    block: I32s<S>,
}

impl<S: Level> Corners<S> {
    /// The numbers by their order in the brick, x fastest.
    #[inline(always)]
    pub fn numbers(&self) -> [F32s<S>; 8] {
        let Corners { low, high, .. } = self;
        [
            low.and(15).to_f32s(),
            low.shifted_down(4).and(15).to_f32s(),
            low.shifted_down(8).and(15).to_f32s(),
            low.shifted_down(12).and(15).to_f32s(),
            high.and(15).to_f32s(),
            high.shifted_down(4).and(15).to_f32s(),
            high.shifted_down(8).and(15).to_f32s(),
            high.shifted_down(12).and(15).to_f32s(),
        ]
    }

    /// Which corners have the second of two numbers, x fastest.
    #[inline(always)]
    pub fn are_second(&self) -> [Mask<S>; 8] {
        let is_set = inlined(
            #[inline(always)]
            |word: I32s<S>, bit: i32| I32s::splat(0).lt(word.and(bit)),
        );
        let Corners { low, high, .. } = *self;
        [
            is_set(low, 1),
            is_set(low, 1 << 4),
            is_set(low, 1 << 8),
            is_set(low, 1 << 12),
            is_set(high, 1),
            is_set(high, 1 << 4),
            is_set(high, 1 << 8),
            is_set(high, 1 << 12),
        ]
    }
}

/// Key of the bricks of a label volume.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelBricksKey(pub ContentId);

impl Key for LabelBricksKey {
    type Value = LabelBricks;

    const NAME: &str = "bricks of labels";

    fn bytes(&self, value: &LabelBricks) -> usize {
        size_of_val(&value.words[..]) + value.blocks.len()
    }
}

impl LabelBricks {
    /// Those of `labels`, which have `dims` voxels along the axes.
    ///
    /// # Errors
    /// It was cancelled; there is no memory.
    pub fn under(
        labels: &LabelNumbers,
        dims: [usize; 3],
        control: &Control,
    ) -> Result<LabelBricks, Error> {
        match &labels.numbers {
            LabelIds::U8(numbers) => LabelBricks::of(numbers, dims, control),
            LabelIds::U16(numbers) => LabelBricks::of(numbers, dims, control),
            LabelIds::U32(numbers) => LabelBricks::of(numbers, dims, control),
        }
    }

    fn of<T: Copy + PartialEq + Into<u32> + Sync>(
        numbers: &[T],
        dims: [usize; 3],
        control: &Control,
    ) -> Result<LabelBricks, Error> {
        let [nx, ny, nz] = dims.map(|n| (n.max(2) - 1).div_ceil(EDGE));
        let mut slices = vec![(Vec::new(), Vec::new()); nz];
        cores::try_for_each(
            slices.iter_mut().enumerate(),
            || (),
            |(), (z, (words, blocks))| {
                reserve(words, nx * ny)?;
                for i in 0..nx * ny {
                    if i % nx == 0 {
                        control.check()?;
                        reserve(blocks, nx * (PAIR_BYTES + 4 * MOST))?;
                    }
                    words.push(append(numbers, dims, [i % nx, i / nx, z], blocks));
                }
                Ok::<_, Error>(())
            },
        )?;
        let mut all = LabelBricks {
            dims: [nx, ny, nz].map(|n| n as i32),
            words: Vec::new(),
            blocks: Vec::new(),
        };
        reserve(&mut all.words, nx * ny * nz)?;
        let blocks = slices.iter().map(|(_, blocks)| blocks.len());
        // A word can be read anywhere.
        reserve(&mut all.blocks, blocks.sum::<usize>() + 4)?;
        for (words, blocks) in slices {
            let before = all.blocks.len() / 4;
            // Words are gathered at 32-bit offsets.
            let fits = all.blocks.len() + blocks.len() <= i32::MAX as usize;
            all.words.extend(words.into_iter().map(|word| match word {
                MANY => MANY,
                block if block < 0 => match fits {
                    true => block - 2 * before as i32,
                    false => MANY,
                },
                number => number,
            }));
            if fits {
                all.blocks.extend(blocks);
            }
        }
        all.blocks.extend([0; 4]);
        Ok(all)
    }

    /// The word of the brick around each `cell`.
    #[inline(always)]
    pub fn words<S: Level>(&self, cell: [I32s<S>; 3]) -> I32s<S> {
        let number = brick_number(self.dims, cell);
        words_inside(bytemuck::cast_slice(&self.words), number.shifted_up(2))
    }

    /// The corners of each `cell`, of whose bricks these are the `words`; anything where [`is_read`](Self::is_read) says no.
    #[inline(always)]
    pub fn corners<S: Level>(&self, cell: [I32s<S>; 3], words: I32s<S>) -> Corners<S> {
        let block = (I32s::splat(-1) - words).shifted_down(1).shifted_up(2);
        let [x, y, z] = each!(cell, |c| c.and(EDGE as i32 - 1));
        let row = x + z * I32s::splat(EDGE as i32);
        let at = block + y + row * I32s::splat(CORNERS as i32);
        let low = words_inside(&self.blocks, at);
        let slice = I32s::splat((CORNERS * EDGE) as i32);
        let high = words_inside(&self.blocks, at + slice);
        Corners { low, high, block }
    }

    /// What numbers of `corners` stand for, counted from 1.
    #[inline(always)]
    pub fn meant<S: Level>(&self, corners: &Corners<S>, numbers: F32s<S>) -> F32s<S> {
        let number: I32s<S> = numbers.to_i32s();
        let first = corners.block + I32s::splat(PAIR_BYTES as i32);
        words_inside(&self.blocks, first + number.shifted_up(2)).to_f32s()
    }

    /// Where a brick that is not of one number has a block.
    #[inline(always)]
    pub fn is_read<S: Level>(words: I32s<S>) -> Mask<S> {
        I32s::splat(MANY).lt(words)
    }

    /// Where such a brick has more than two numbers.
    #[inline(always)]
    pub fn has_more_than_two<S: Level>(words: I32s<S>) -> Mask<S> {
        words.and(1).lt(I32s::splat(1))
    }
}

/// Makes room for so many more.
fn reserve<T>(list: &mut Vec<T>, more: usize) -> Result<(), Error> {
    let bytes = || (more as u64).saturating_mul(size_of::<T>() as u64);
    list.try_reserve(more)
        .map_err(|_| ErrorKind::NoMemory { bytes: bytes() }.into())
}

/// The word of a brick, as if its block were the first of all; what it needs is appended to `blocks`.
fn append<T: Copy + PartialEq + Into<u32>>(
    of_voxels: &[T],
    dims: [usize; 3],
    brick: [usize; 3],
    blocks: &mut Vec<u8>,
) -> i32 {
    let [nx, ny, nz] = dims;
    let [x0, y0, z0] = brick.map(|b| b * EDGE);
    let mut corners = [[[of_voxels[0]; CORNERS]; CORNERS]; CORNERS];
    for (z, slice) in corners.iter_mut().enumerate() {
        for (y, row) in slice.iter_mut().enumerate() {
            let first = nx * ((y0 + y).min(ny - 1) + ny * (z0 + z).min(nz - 1));
            let from = &of_voxels[first..first + nx];
            match from.get(x0..x0 + CORNERS) {
                Some(all) => row.copy_from_slice(all),
                None => (0..CORNERS).for_each(|x| row[x] = from[(x0 + x).min(nx - 1)]),
            }
        }
    }
    let all = corners.as_flattened().as_flattened();
    let first = all[0];
    if all.iter().all(|number| *number == first) {
        return (first.into() + 1) as i32;
    }
    let mut meant: Vec<u32> = Vec::with_capacity(MOST);
    for run in all.chunk_by(|a, b| a == b) {
        let number = run[0].into();
        if let Err(place) = meant.binary_search(&number) {
            if meant.len() == MOST {
                return MANY;
            }
            meant.insert(place, number);
        }
    }
    let block = (blocks.len() / 4) as i32;
    let order = |number: T| {
        let number = number.into();
        meant.partition_point(|other| *other < number) as u8
    };
    for slice in &corners {
        for x in 0..EDGE {
            let pairs = slice
                .iter()
                .map(|row| order(row[x]) | order(row[x + 1]) << 4);
            blocks.extend(pairs);
        }
    }
    blocks.extend(meant.iter().flat_map(|number| (number + 1).to_le_bytes()));
    !(2 * block + i32::from(meant.len() > 2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::levels::Portable;

    /// Numbers of voxels: clusters of few, in one corner each voxel its own.
    fn numbers([nx, ny, nz]: [usize; 3]) -> Vec<u16> {
        let number = |i: usize| {
            let [x, y, z] = [i % nx, i / nx % ny, i / (nx * ny)];
            match x < 7 && y < 7 && z < 7 {
                true => 300 + i as u16,
                false => ((x / 6 * 5 + y / 3 * 3 + z / 9) % 29) as u16,
            }
        };
        (0..nx * ny * nz).map(number).collect()
    }

    #[test]
    fn every_corner_of_every_cell_is_found_again() {
        for dims in [[21, 14, 11], [1, 6, 9], [5, 1, 1], [30, 29, 4]] {
            let numbers = numbers(dims);
            let bricks = LabelBricks::of(&numbers, dims, &Control::NONE).unwrap();
            let (mut seen, mut of_two) = ([0; 3], 0);
            for i in 0..numbers.len() {
                let cell = [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])];
                if (0..3).any(|axis| cell[axis] > dims[axis].saturating_sub(2)) {
                    continue;
                }
                let expected: Vec<u16> = (0..8)
                    .map(|corner| {
                        let at =
                            |axis: usize| (cell[axis] + (corner >> axis & 1)).min(dims[axis] - 1);
                        numbers[at(0) + dims[0] * (at(1) + dims[1] * at(2))]
                    })
                    .collect();
                let in_lanes = each!(cell, |c| I32s::<Portable>::splat(c as i32));
                let word = bricks.words(in_lanes);
                if 0 < word.lane(3) {
                    assert!(expected.iter().all(|n| i32::from(*n) + 1 == word.lane(3)));
                    seen[0] += 1;
                } else if word.lane(3) == MANY {
                    assert!(!LabelBricks::is_read(word).any());
                    seen[1] += 1;
                } else {
                    let corners = bricks.corners(in_lanes, word);
                    let second = corners.are_second();
                    let is_of_two = !LabelBricks::has_more_than_two(word).any();
                    for (i, found) in corners.numbers().into_iter().enumerate() {
                        let meant = bricks.meant(&corners, found);
                        assert_eq!(meant.lane(3), f32::from(expected[i]) + 1.0, "{cell:?}");
                        assert!(!is_of_two || second[i].any() == (found.lane(3) == 1.0));
                    }
                    of_two += usize::from(is_of_two);
                    seen[2] += 1;
                }
            }
            assert!(
                (1..seen[2]).contains(&of_two) || dims[0] < 21,
                "{of_two} of {seen:?}"
            );
            assert!(
                seen[2] > 0 && (dims[0] != 21 || seen.iter().all(|n| *n > 50)),
                "{seen:?}"
            );
        }
    }
}
