//! Instruction sets: which one a picture is drawn with, and what a vector library has no name for.

use crate::error::Error;
use fearless_simd::{Simd, SimdBase, SimdInto, f32x16, i32x16, u32x16};
use std::fmt;

/// The vector instructions that a picture is drawn with. The picture has the same bytes with any of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum InstructionSet {
    /// 512 bits and gathers: x86-64 from Ice Lake and Zen 4 on.
    Avx512,
    /// 256 bits and gathers: x86-64 from Haswell and Zen 1 on.
    Avx2,
    /// What every processor of the build's target has: SSE2, NEON, SIMD128.
    Portable,
}

impl InstructionSet {
    /// All, the fastest first.
    pub const ALL: [InstructionSet; 3] = [
        InstructionSet::Avx512,
        InstructionSet::Avx2,
        InstructionSet::Portable,
    ];

    /// The fastest that this processor has.
    pub fn fastest() -> InstructionSet {
        InstructionSet::ALL
            .into_iter()
            .find(|set| set.is_there())
            .unwrap_or(InstructionSet::Portable)
    }

    /// What the environment variable `STRAHL_SIMD` says; without it, the fastest.
    ///
    /// # Errors
    /// It says something else than the name of a set that this processor has.
    pub(crate) fn from_environment() -> Result<InstructionSet, Error> {
        let Some(value) = std::env::var_os("STRAHL_SIMD") else {
            return Ok(InstructionSet::fastest());
        };
        let set = value.to_str().and_then(InstructionSet::from_name);
        set.ok_or_else(|| Error::NoSuchInstructions {
            value: value.to_string_lossy().into_owned(),
        })
    }

    /// Whether this processor has it.
    pub fn is_there(self) -> bool {
        match self {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            InstructionSet::Avx512 => fearless_simd::Level::new().as_avx512().is_some(),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            InstructionSet::Avx2 => fearless_simd::Level::new().as_avx2().is_some(),
            InstructionSet::Portable => true,
            #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
            InstructionSet::Avx512 | InstructionSet::Avx2 => false,
        }
    }

    /// The name that [`from_name`](Self::from_name) takes.
    pub fn name(self) -> &'static str {
        match self {
            InstructionSet::Avx512 => "avx512",
            InstructionSet::Avx2 => "avx2",
            InstructionSet::Portable => "portable",
        }
    }

    /// `avx512`, `avx2` or `portable`.
    pub fn from_name(name: &str) -> Option<InstructionSet> {
        InstructionSet::ALL
            .into_iter()
            .find(|set| set.name() == name)
    }
}

impl fmt::Display for InstructionSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// An instruction set as a type, which the ray loop is compiled for.
///
/// Lanes of a level are made only below [`dispatch`], which has found that the processor has it.
pub trait Level: Simd + Send + Sync {
    /// Whether loops that are compiled for each type of sample pay. Without gathers they take as long as the
    /// loop for any functions, and longer to compile than all else here.
    const HAS_LOOPS_PER_TYPE: bool;

    /// The proof that the processor has the level.
    fn proof() -> Self;

    /// `a` where it is less than `b`, else `b`: also where either is NaN.
    #[inline(always)]
    fn lesser(self, a: f32x16<Self>, b: f32x16<Self>) -> f32x16<Self> {
        self.select_f32x16(self.simd_lt_f32x16(a, b), a, b)
    }

    /// `a` where it is greater than `b`, else `b`: also where either is NaN.
    #[inline(always)]
    fn greater(self, a: f32x16<Self>, b: f32x16<Self>) -> f32x16<Self> {
        self.select_f32x16(self.simd_lt_f32x16(b, a), a, b)
    }

    /// The rows at `indices`, and those that follow them: one number of each in a vector.
    ///
    /// # Safety
    /// There is a row for every index, and one behind it.
    #[inline(always)]
    unsafe fn row_pairs(self, rows: &[[f32; 4]], indices: i32x16<Self>) -> [[f32x16<Self>; 4]; 2] {
        let numbers_at = inlined(
            #[inline(always)]
            |indices: i32x16<Self>| {
                // SAFETY: as the caller promises.
                let [a, b, c, d] = unsafe { rows_one_by_one(rows, &indices.into()) };
                [
                    a.simd_into(self),
                    b.simd_into(self),
                    c.simd_into(self),
                    d.simd_into(self),
                ]
            },
        );
        let following = indices + i32x16::splat(self, 1);
        [numbers_at(indices), numbers_at(following)]
    }

    /// A row of four numbers per lane.
    #[inline(always)]
    fn to_rows(self, columns: [f32x16<Self>; 4]) -> [[f32; 4]; 16] {
        let mut rows = [[0.0; 4]; 16];
        for (lane, row) in rows.iter_mut().enumerate() {
            *row = [
                columns[0][lane],
                columns[1][lane],
                columns[2][lane],
                columns[3][lane],
            ];
        }
        rows
    }

    /// The numbers of `packet` at `indices`, of which the lowest five bits count.
    #[inline(always)]
    fn picked(self, packet: &[f32; 32], indices: i32x16<Self>) -> f32x16<Self> {
        let indices: [i32; 16] = indices.into();
        indices
            .map(|index| packet[index as usize & 31])
            .simd_into(self)
    }

    /// The little-endian words of four bytes at `offsets` (in bytes), which may lie at any address.
    ///
    /// # Safety
    /// `offset .. offset + 4` lies inside `bytes` for every lane.
    unsafe fn words(self, bytes: &[u8], offsets: i32x16<Self>) -> u32x16<Self>;
}

/// Lanes to be read one by one. From memory that is a load each, which costs less than moving each out of a
/// vector register, what would be made of it otherwise.
#[inline(always)]
fn in_memory<S: Simd>(lanes: i32x16<S>) -> [i32; 16] {
    std::hint::black_box(lanes.into())
}

/// The words one by one: where there is no instruction for it. Not inlined: sixteen loads wherever voxels are
/// read would be most of the program.
///
/// # Safety
/// `offset .. offset + 4` lies inside `bytes` for every lane.
#[inline(never)]
unsafe fn words_one_by_one(bytes: &[u8], offsets: &[i32; 16]) -> [u32; 16] {
    let mut words = [0; 16];
    for (word, &offset) in words.iter_mut().zip(offsets) {
        let offset = offset as usize;
        debug_assert!(offset + 4 <= bytes.len());
        // SAFETY: inside `bytes`, as the caller promises.
        let bytes = unsafe { bytes.as_ptr().add(offset).cast::<u32>().read_unaligned() };
        *word = u32::from_le(bytes);
    }
    words
}

/// The numbers of rows one by one, likewise.
///
/// # Safety
/// There is a row for every index.
#[inline(never)]
unsafe fn rows_one_by_one(rows: &[[f32; 4]], indices: &[i32; 16]) -> [[f32; 16]; 4] {
    let mut numbers = [[0.0; 16]; 4];
    for (lane, &index) in indices.iter().enumerate() {
        debug_assert!((index as usize) < rows.len());
        // SAFETY: as the caller promises.
        let row = unsafe { rows.get_unchecked(index as usize) };
        for (numbers, &number) in numbers.iter_mut().zip(row) {
            numbers[lane] = number;
        }
    }
    numbers
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
mod x86 {
    use super::{Level, f32x16, i32x16, in_memory, inlined, u32x16, words_one_by_one};
    use fearless_simd::x86::{Avx2, Avx512, Sse2};
    use fearless_simd::{Bytes, Simd, SimdInto, f32x8, i32x8, u32x8};
    #[cfg(target_arch = "x86")]
    use std::arch::x86::*;
    #[cfg(target_arch = "x86_64")]
    use std::arch::x86_64::*;

    /// MINPS and MAXPS give their second operand unless the comparison holds.
    macro_rules! min_and_max {
        () => {
            #[inline(always)]
            fn lesser(self, a: f32x16<Self>, b: f32x16<Self>) -> f32x16<Self> {
                self.min_f32x16(a, b)
            }

            #[inline(always)]
            fn greater(self, a: f32x16<Self>, b: f32x16<Self>) -> f32x16<Self> {
                self.max_f32x16(a, b)
            }
        };
    }

    /// Four vectors with a row of four numbers in each block of 128 bits → four with the first, second,
    /// third, fourth numbers of the rows.
    macro_rules! transposed {
        (
            $rows:expr, $low:ident, $high:ident, $low_pairs:ident, $high_pairs:ident,
            $pairs:ident, $singles:ident
        ) => {{
            let [a, b, c, d] = $rows;
            let (ab, cd) = ($pairs($low(a, b)), $pairs($low(c, d)));
            let (first, second) = ($low_pairs(ab, cd), $high_pairs(ab, cd));
            let (ab, cd) = ($pairs($high(a, b)), $pairs($high(c, d)));
            let (third, fourth) = ($low_pairs(ab, cd), $high_pairs(ab, cd));
            [
                $singles(first),
                $singles(second),
                $singles(third),
                $singles(fourth),
            ]
        }};
    }

    macro_rules! transposed_512 {
        ($rows:expr) => {
            transposed!(
                $rows,
                _mm512_unpacklo_ps,
                _mm512_unpackhi_ps,
                _mm512_unpacklo_pd,
                _mm512_unpackhi_pd,
                _mm512_castps_pd,
                _mm512_castpd_ps
            )
        };
    }

    macro_rules! transposed_256 {
        ($rows:expr) => {
            transposed!(
                $rows,
                _mm256_unpacklo_ps,
                _mm256_unpackhi_ps,
                _mm256_unpacklo_pd,
                _mm256_unpackhi_pd,
                _mm256_castps_pd,
                _mm256_castpd_ps
            )
        };
    }

    impl Level for Avx512 {
        const HAS_LOOPS_PER_TYPE: bool = true;

        #[inline(always)]
        fn proof() -> Avx512 {
            // SAFETY: only code below `dispatch` is compiled for this level.
            unsafe { Avx512::assume_supported() }
        }

        min_and_max!();

        #[inline(always)]
        unsafe fn words(self, bytes: &[u8], offsets: i32x16<Self>) -> u32x16<Self> {
            debug_assert!(offsets.iter().all(|&o| o as usize + 4 <= bytes.len()));
            let offsets: __m512i = offsets.into();
            // SAFETY: the processor has the instruction, as `self` proves; every word lies inside
            // `bytes`, as the caller promises.
            let words = unsafe { _mm512_i32gather_epi32::<1>(offsets, bytes.as_ptr().cast()) };
            words.simd_into(self)
        }

        #[inline(always)]
        fn picked(self, packet: &[f32; 32], indices: i32x16<Self>) -> f32x16<Self> {
            let from = packet.as_ptr();
            // SAFETY: the processor has the instructions, as `self` proves, and a packet is two vectors.
            let numbers = unsafe {
                let [a, b] = [_mm512_loadu_ps(from), _mm512_loadu_ps(from.add(16))];
                _mm512_permutex2var_ps(a, indices.into(), b)
            };
            numbers.simd_into(self)
        }

        #[inline(always)]
        fn to_rows(self, columns: [f32x16<Self>; 4]) -> [[f32; 4]; 16] {
            let [a, b, c, d] = columns;
            let mut rows = [[0.0; 4]; 16];
            // SAFETY: the processor has the instructions, as `self` proves, and 16 rows are four vectors.
            unsafe {
                let [a, b, c, d] = transposed_512!([a.into(), b.into(), c.into(), d.into()]);
                // Block q of vector j is the row of lane 4q + j.
                let even = (
                    _mm512_shuffle_f32x4::<0x88>(a, b),
                    _mm512_shuffle_f32x4::<0x88>(c, d),
                );
                let odd = (
                    _mm512_shuffle_f32x4::<0xDD>(a, b),
                    _mm512_shuffle_f32x4::<0xDD>(c, d),
                );
                let to: *mut f32 = rows.as_mut_ptr().cast();
                _mm512_storeu_ps(to, _mm512_shuffle_f32x4::<0x88>(even.0, even.1));
                _mm512_storeu_ps(to.add(16), _mm512_shuffle_f32x4::<0x88>(odd.0, odd.1));
                _mm512_storeu_ps(to.add(32), _mm512_shuffle_f32x4::<0xDD>(even.0, even.1));
                _mm512_storeu_ps(to.add(48), _mm512_shuffle_f32x4::<0xDD>(odd.0, odd.1));
            }
            rows
        }

        #[inline(always)]
        unsafe fn row_pairs(
            self,
            rows: &[[f32; 4]],
            indices: i32x16<Self>,
        ) -> [[f32x16<Self>; 4]; 2] {
            debug_assert!(indices.iter().all(|&i| (i as usize) + 1 < rows.len()));
            let indices = in_memory(indices);
            // SAFETY: the processor has the instructions, as `self` proves; every row and the one behind it
            // exist, as the caller promises.
            unsafe {
                let pair =
                    |lane: usize| _mm256_loadu_ps(rows.as_ptr().add(indices[lane] as usize).cast());
                // Blocks of vector j: both rows of lane `from` + j, both of lane `from` + 4 + j.
                let pairs = inlined(
                    #[inline(always)]
                    |j: usize, from: usize| {
                        let pairs = _mm512_castps256_ps512(pair(from + j));
                        let second = _mm256_castps_pd(pair(from + 4 + j));
                        let pairs = _mm512_insertf64x4::<1>(_mm512_castps_pd(pairs), second);
                        _mm512_castpd_ps(pairs)
                    },
                );
                // Of eight lanes: numbers of first rows in the blocks 0 and 2, of second ones in 1 and 3.
                let eight = inlined(
                    #[inline(always)]
                    |from: usize| -> [__m512; 4] {
                        transposed_512!([
                            pairs(0, from),
                            pairs(1, from),
                            pairs(2, from),
                            pairs(3, from)
                        ])
                    },
                );
                let (low, high) = (eight(0), eight(8));
                let first = inlined(
                    #[inline(always)]
                    |c: usize| _mm512_shuffle_f32x4::<0x88>(low[c], high[c]).simd_into(self),
                );
                let second = inlined(
                    #[inline(always)]
                    |c: usize| _mm512_shuffle_f32x4::<0xDD>(low[c], high[c]).simd_into(self),
                );
                [
                    [first(0), first(1), first(2), first(3)],
                    [second(0), second(1), second(2), second(3)],
                ]
            }
        }
    }

    impl Level for Avx2 {
        const HAS_LOOPS_PER_TYPE: bool = true;

        #[inline(always)]
        fn proof() -> Avx2 {
            // SAFETY: only code below `dispatch` is compiled for this level.
            unsafe { Avx2::assume_supported() }
        }

        min_and_max!();

        #[inline(always)]
        unsafe fn words(self, bytes: &[u8], offsets: i32x16<Self>) -> u32x16<Self> {
            debug_assert!(offsets.iter().all(|&o| o as usize + 4 <= bytes.len()));
            let (low, high) = self.split_i32x16(offsets);
            let half = inlined(
                #[inline(always)]
                |offsets: i32x8<Avx2>| -> u32x8<Avx2> {
                    let offsets: __m256i = offsets.into();
                    // SAFETY: as above.
                    let words =
                        unsafe { _mm256_i32gather_epi32::<1>(bytes.as_ptr().cast(), offsets) };
                    words.simd_into(self)
                },
            );
            self.combine_u32x8(half(low), half(high))
        }

        #[inline(always)]
        fn picked(self, packet: &[f32; 32], indices: i32x16<Self>) -> f32x16<Self> {
            // SAFETY: the offset of the last of 32 numbers is 4 · 31.
            let words = unsafe { self.words(bytemuck::bytes_of(packet), (indices & 31) << 2) };
            words.bitcast()
        }

        #[inline(always)]
        unsafe fn row_pairs(
            self,
            rows: &[[f32; 4]],
            indices: i32x16<Self>,
        ) -> [[f32x16<Self>; 4]; 2] {
            debug_assert!(indices.iter().all(|&i| (i as usize) + 1 < rows.len()));
            let indices = in_memory(indices);
            // SAFETY: as above.
            unsafe {
                let pair =
                    |lane: usize| _mm256_loadu_ps(rows.as_ptr().add(indices[lane] as usize).cast());
                // Of four lanes: numbers of first rows in the first block, of second ones in the other.
                let four = inlined(
                    #[inline(always)]
                    |from: usize| -> [__m256; 4] {
                        transposed_256!([
                            pair(from),
                            pair(from + 1),
                            pair(from + 2),
                            pair(from + 3)
                        ])
                    },
                );
                let (a, b, c, d) = (four(0), four(4), four(8), four(12));
                let first = inlined(
                    #[inline(always)]
                    |i: usize| -> f32x16<Avx2> {
                        let low: f32x8<Avx2> =
                            _mm256_permute2f128_ps::<0x20>(a[i], b[i]).simd_into(self);
                        let high = _mm256_permute2f128_ps::<0x20>(c[i], d[i]).simd_into(self);
                        self.combine_f32x8(low, high)
                    },
                );
                let second = inlined(
                    #[inline(always)]
                    |i: usize| -> f32x16<Avx2> {
                        let low: f32x8<Avx2> =
                            _mm256_permute2f128_ps::<0x31>(a[i], b[i]).simd_into(self);
                        let high = _mm256_permute2f128_ps::<0x31>(c[i], d[i]).simd_into(self);
                        self.combine_f32x8(low, high)
                    },
                );
                [
                    [first(0), first(1), first(2), first(3)],
                    [second(0), second(1), second(2), second(3)],
                ]
            }
        }
    }

    impl Level for Sse2 {
        const HAS_LOOPS_PER_TYPE: bool = false;

        #[inline(always)]
        fn proof() -> Sse2 {
            // SAFETY: every processor that this target's code runs on has it.
            unsafe { Sse2::assume_supported() }
        }

        min_and_max!();

        #[inline(always)]
        unsafe fn words(self, bytes: &[u8], offsets: i32x16<Self>) -> u32x16<Self> {
            // SAFETY: as the caller promises.
            unsafe { words_one_by_one(bytes, &offsets.into()) }.simd_into(self)
        }
    }
}

/// The level of [`InstructionSet::Portable`].
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
pub type Portable = fearless_simd::x86::Sse2;
/// The level of [`InstructionSet::Portable`].
#[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
pub type Portable = fearless_simd::aarch64::Neon;
/// The level of [`InstructionSet::Portable`].
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
pub type Portable = fearless_simd::wasm32::WasmSimd128;
/// The level of [`InstructionSet::Portable`].
#[cfg(not(any(
    target_arch = "x86",
    target_arch = "x86_64",
    all(target_arch = "aarch64", target_feature = "neon"),
    all(target_arch = "wasm32", target_feature = "simd128")
)))]
pub type Portable = fearless_simd::Fallback;

#[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
impl Level for Portable {
    const HAS_LOOPS_PER_TYPE: bool = false;

    #[inline(always)]
    fn proof() -> Portable {
        portable_proof()
    }

    #[inline(always)]
    unsafe fn words(self, bytes: &[u8], offsets: i32x16<Self>) -> u32x16<Self> {
        // SAFETY: as the caller promises.
        unsafe { words_one_by_one(bytes, &offsets.into()) }.simd_into(self)
    }
}

#[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
fn portable_proof() -> Portable {
    // SAFETY: every processor that this target's code runs on has it.
    unsafe { Portable::assume_supported() }
}

#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
fn portable_proof() -> Portable {
    // SAFETY: every engine that this target's code runs on has it.
    unsafe { Portable::assume_supported() }
}

#[cfg(not(any(
    target_arch = "x86",
    target_arch = "x86_64",
    all(target_arch = "aarch64", target_feature = "neon"),
    all(target_arch = "wasm32", target_feature = "simd128")
)))]
fn portable_proof() -> Portable {
    Portable::new()
}

/// Something to do for any level.
pub trait Task {
    /// What comes of it.
    type Output;
    /// Does it for the level `S`.
    fn run<S: Level>(self) -> Self::Output;
}

/// Does `task` with the instructions of `set`, which the processor has; with the portable ones if not.
pub fn dispatch<T: Task>(set: InstructionSet, task: T) -> T::Output {
    let set = if set.is_there() {
        set
    } else {
        InstructionSet::Portable
    };
    match set {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        InstructionSet::Avx512 => task.run::<fearless_simd::x86::Avx512>(),
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        InstructionSet::Avx2 => task.run::<fearless_simd::x86::Avx2>(),
        _ => task.run::<Portable>(),
    }
}

/// `f` compiled for the level `S`; it and what it calls has to be `#[inline(always)]`.
#[inline(always)]
pub fn vectorized<S: Level, R>(f: impl FnOnce() -> R) -> R {
    S::proof().vectorize(f)
}

/// A closure that is inlined wherever it is called, however often: an attribute may stand before the
/// argument of a function only.
#[inline(always)]
pub fn inlined<F>(closure: F) -> F {
    closure
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Picking([i32; 16]);

    impl Task for Picking {
        type Output = [f32; 16];

        fn run<S: Level>(self) -> [f32; 16] {
            let packet = std::array::from_fn(|i| 1.5 * i as f32 - 7.0);
            vectorized::<S, _>(
                #[inline(always)]
                || {
                    let indices = self.0.simd_into(S::proof());
                    S::proof().picked(&packet, indices).into()
                },
            )
        }
    }

    #[test]
    fn numbers_of_a_packet_are_picked_by_five_bits() {
        for set in InstructionSet::ALL {
            if !set.is_there() {
                println!("skipped: this processor has no {set}");
                continue;
            }
            for shift in [0, 3, 31, 32, 1 << 20, -5] {
                let indices: [i32; 16] = std::array::from_fn(|i| 7 * i as i32 + shift);
                let expected = indices.map(|index| 1.5 * index.rem_euclid(32) as f32 - 7.0);
                assert_eq!(dispatch(set, Picking(indices)), expected, "{set}, {shift}");
            }
        }
    }
}
