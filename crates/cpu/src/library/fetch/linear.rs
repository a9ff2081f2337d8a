use super::shape::Shape;
use super::voxels::{Corners, Fetch, Surroundings};
use crate::lanes::{F32s, I32s, each, lanes, words};
use crate::levels::{Level, inlined};
use strahl_volume::{Grid, Sample, SampleType};

/// Voxels as they lie in memory, x fastest.
pub struct Linear<'v, T> {
    samples: &'v [T],
    shape: Shape,
    /// Whether words of four bytes can be gathered: small enough for 32-bit offsets.
    is_gathered: bool,
}

impl<'v, T: Sample> Linear<'v, T> {
    /// The voxels of `grid`.
    ///
    /// # Panics
    /// If their number is not that of the grid.
    pub fn new(grid: &Grid, samples: &'v [T]) -> Linear<'v, T> {
        assert_eq!(samples.len(), grid.voxel_count());
        let bytes = size_of_val(samples);
        let has_words = !matches!(T::TYPE, SampleType::U32 | SampleType::F64);
        Linear {
            samples,
            shape: Shape::new(grid),
            is_gathered: has_words
                && cfg!(target_endian = "little")
                && (4..=i32::MAX as usize).contains(&bytes),
        }
    }

    const SIZE: i32 = size_of::<T>() as i32;

    /// In bytes, where `is_gathered`.
    #[inline(always)]
    fn offset<S: Level>(&self, voxel: [I32s<S>; 3]) -> I32s<S> {
        let [_, row, slice] = self.shape.stride;
        let index =
            voxel[0] + voxel[1] * I32s::splat(row as i32) + voxel[2] * I32s::splat(slice as i32);
        index * I32s::splat(Self::SIZE)
    }

    /// The words that begin `bytes` behind `offset`.
    ///
    /// # Safety
    /// They lie inside the samples.
    #[inline(always)]
    unsafe fn words<S: Level>(&self, offset: I32s<S>, bytes: i32) -> I32s<S> {
        let all: &[u8] = bytemuck::cast_slice(self.samples);
        let offset = offset + I32s::splat(bytes);
        // SAFETY: as the caller promises.
        unsafe { words(all, offset) }
    }

    /// The numbers `further` samples behind voxels, without gathering.
    #[cold]
    #[inline(never)]
    fn one_by_one<S: Level>(&self, voxel: [I32s<S>; 3], further: usize) -> F32s<S> {
        let number = |lane| self.samples[self.shape.index(voxel, lane) + further].to_f32();
        F32s::from_array(lanes(number))
    }

    /// The number whose lowest byte is byte `AT` of each word.
    #[inline(always)]
    fn number<S: Level, const AT: u32>(words: I32s<S>) -> F32s<S> {
        let unsigned = inlined(
            #[inline(always)]
            |bits: u32| {
                let number = words.shifted_down(8 * AT).and((1 << bits) - 1);
                number.to_f32s()
            },
        );
        let signed = inlined(
            #[inline(always)]
            |bits: u32| {
                let top = words.shifted_up(32 - 8 * AT - bits);
                top.shifted_down(32 - bits).to_f32s()
            },
        );
        match T::TYPE {
            SampleType::U8 => unsigned(8),
            SampleType::I8 => signed(8),
            SampleType::U16 => unsigned(16),
            SampleType::I16 => signed(16),
            SampleType::I32 => words.to_f32s(),
            SampleType::F32 => words.as_bits(),
            SampleType::U32 | SampleType::F64 => unreachable!("these are not gathered"),
        }
    }

    /// The number at `offset`, and the one behind it.
    ///
    /// # Safety
    /// Two samples, and four bytes, lie there inside the samples.
    #[inline(always)]
    unsafe fn pair<S: Level>(&self, offset: I32s<S>, bytes: i32) -> [F32s<S>; 2] {
        // SAFETY: as the caller promises.
        unsafe {
            let first = self.words(offset, bytes);
            match Self::SIZE {
                1 => [Self::number::<S, 0>(first), Self::number::<S, 1>(first)],
                2 => [Self::number::<S, 0>(first), Self::number::<S, 2>(first)],
                _ => {
                    let second = self.words(offset, bytes + Self::SIZE);
                    [Self::number::<S, 0>(first), Self::number::<S, 0>(second)]
                }
            }
        }
    }

    /// Four numbers from `offset` on.
    ///
    /// # Safety
    /// They lie inside the samples.
    #[inline(always)]
    unsafe fn four_at<S: Level>(&self, offset: I32s<S>, bytes: i32) -> [F32s<S>; 4] {
        // SAFETY: as the caller promises.
        unsafe {
            if Self::SIZE == 1 {
                let words = self.words(offset, bytes);
                return [
                    Self::number::<S, 0>(words),
                    Self::number::<S, 1>(words),
                    Self::number::<S, 2>(words),
                    Self::number::<S, 3>(words),
                ];
            }
            let [a, b] = self.pair(offset, bytes);
            let [c, d] = self.pair(offset, bytes + 2 * Self::SIZE);
            [a, b, c, d]
        }
    }
}

impl<S: Level, T: Sample> Fetch<S> for Linear<'_, T> {
    #[inline(always)]
    fn shape(&self) -> &Shape {
        &self.shape
    }

    #[inline(always)]
    unsafe fn fetch(&self, voxel: [I32s<S>; 3]) -> F32s<S> {
        let last_word = size_of_val(self.samples) as i64 - 4;
        if self.is_gathered {
            let offset = self.offset(voxel);
            if Self::SIZE == 4 || !I32s::splat(last_word as i32).lt(offset).any() {
                // SAFETY: `voxel` lies inside the grid, and four bytes from there on do.
                return Self::number::<S, 0>(unsafe { self.words(offset, 0) });
            }
        }
        self.one_by_one(voxel, 0)
    }

    #[inline(always)]
    unsafe fn corners(&self, cell: [I32s<S>; 3]) -> Corners<S> {
        let [dx, dy, dz] = self.shape.across;
        let bytes = |stride: usize| stride as i32 * Self::SIZE;
        if self.is_gathered && dx == 1 {
            // The last pair of a cell is read as one word, which may end behind it.
            let last = size_of_val(self.samples) as i32 - 4.max(2 * Self::SIZE) - bytes(dy + dz);
            let offset = self.offset(cell);
            if !I32s::splat(last).lt(offset).any() {
                // SAFETY: the furthest pair begins at most at `last`.
                return unsafe {
                    [
                        self.pair(offset, 0),
                        self.pair(offset, bytes(dy)),
                        self.pair(offset, bytes(dz)),
                        self.pair(offset, bytes(dy + dz)),
                    ]
                };
            }
        }
        let pair = inlined(
            #[inline(always)]
            |rows: usize| {
                [
                    self.one_by_one(cell, rows),
                    self.one_by_one(cell, rows + dx),
                ]
            },
        );
        [pair(0), pair(dy), pair(dz), pair(dy + dz)]
    }

    #[inline(always)]
    unsafe fn four(&self, voxel: [I32s<S>; 3]) -> Option<[F32s<S>; 4]> {
        if !self.is_gathered {
            return None;
        }
        // SAFETY: all four lie inside the grid; of the smallest type they are a word of four bytes.
        Some(unsafe { self.four_at(self.offset(voxel), 0) })
    }

    #[inline(always)]
    unsafe fn surroundings(&self, cell: [I32s<S>; 3]) -> Option<Surroundings<S>> {
        let [_, row, slice] = each!(self.shape.stride, |stride| stride as i32 * Self::SIZE);
        if !self.is_gathered || self.shape.last_cell.iter().any(|&last| last < 2) {
            return None;
        }
        let offset = self.offset(cell);
        // SAFETY: the cell is not at the border: there are voxels from −1 to 2 along each axis, and for
        // the words behind pairs a whole slice of rows of four or more.
        Some(unsafe {
            let four = inlined(
                #[inline(always)]
                |y: i32, z: i32| self.four_at(offset, y * row + z * slice - Self::SIZE),
            );
            let pair = inlined(
                #[inline(always)]
                |y: i32, z: i32| self.pair(offset, y * row + z * slice),
            );
            Surroundings {
                along_x: [four(0, 0), four(1, 0), four(0, 1), four(1, 1)],
                along_y: [pair(-1, 0), pair(2, 0), pair(-1, 1), pair(2, 1)],
                along_z: [pair(0, -1), pair(1, -1), pair(0, 2), pair(1, 2)],
            }
        })
    }
}
