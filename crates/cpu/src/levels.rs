//! Instruction sets: which one a picture is drawn with, and what a vector library has no name for.

use crate::Error;
use fearless_simd::{Simd, SimdBase, f32x16, i32x16, u32x16};
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

    /// The rows at `indices`, one number of each in a vector.
    ///
    /// # Safety
    /// There is a row for every index.
    #[inline(always)]
    unsafe fn rows(self, rows: &[[f32; 4]], indices: i32x16<Self>) -> [f32x16<Self>; 4] {
        let number = inlined(
            #[inline(always)]
            |channel: usize| {
                f32x16::from_fn(self, |lane| {
                    debug_assert!((indices[lane] as usize) < rows.len());
                    // SAFETY: as the caller promises.
                    unsafe { rows.get_unchecked(indices[lane] as usize)[channel] }
                })
            },
        );
        [number(0), number(1), number(2), number(3)]
    }

    /// The little-endian words of four bytes at `offsets` (in bytes), which may lie at any address.
    ///
    /// # Safety
    /// `offset .. offset + 4` lies inside `bytes` for every lane.
    unsafe fn words(self, bytes: &[u8], offsets: i32x16<Self>) -> u32x16<Self>;
}

/// The words one by one: where there is no instruction for it.
#[inline(always)]
unsafe fn words_one_by_one<S: Simd>(simd: S, bytes: &[u8], offsets: i32x16<S>) -> u32x16<S> {
    u32x16::from_fn(simd, |lane| {
        let offset = offsets[lane] as usize;
        debug_assert!(offset + 4 <= bytes.len());
        // SAFETY: inside `bytes`, as the caller promises.
        let word = unsafe { bytes.as_ptr().add(offset).cast::<u32>().read_unaligned() };
        u32::from_le(word)
    })
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
mod x86 {
    use super::{Level, f32x16, i32x16, inlined, u32x16, words_one_by_one};
    use fearless_simd::x86::{Avx2, Avx512, Sse2};
    use fearless_simd::{Simd, SimdInto, f32x8, i32x8, u32x8};
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
            $simd:expr, $rows:expr, $low:ident, $high:ident, $low_pairs:ident, $high_pairs:ident,
            $pairs:ident, $singles:ident
        ) => {{
            let [a, b, c, d] = $rows;
            let (ab, cd) = ($pairs($low(a, b)), $pairs($low(c, d)));
            let (first, second) = ($low_pairs(ab, cd), $high_pairs(ab, cd));
            let (ab, cd) = ($pairs($high(a, b)), $pairs($high(c, d)));
            let (third, fourth) = ($low_pairs(ab, cd), $high_pairs(ab, cd));
            [
                $singles(first).simd_into($simd),
                $singles(second).simd_into($simd),
                $singles(third).simd_into($simd),
                $singles(fourth).simd_into($simd),
            ]
        }};
    }

    impl Level for Avx512 {
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
        unsafe fn rows(self, rows: &[[f32; 4]], indices: i32x16<Self>) -> [f32x16<Self>; 4] {
            debug_assert!(indices.iter().all(|&i| (i as usize) < rows.len()));
            let indices: [i32; 16] = indices.into();
            // SAFETY: the processor has the instructions, as `self` proves; every row exists, as the
            // caller promises.
            unsafe {
                let row =
                    |lane: usize| _mm_loadu_ps(rows.as_ptr().add(indices[lane] as usize).cast());
                // Block b of vector j: lane 4b + j.
                let blocks = inlined(
                    #[inline(always)]
                    |j: usize| {
                        let blocks = _mm512_castps128_ps512(row(j));
                        let blocks = _mm512_insertf32x4::<1>(blocks, row(4 + j));
                        let blocks = _mm512_insertf32x4::<2>(blocks, row(8 + j));
                        _mm512_insertf32x4::<3>(blocks, row(12 + j))
                    },
                );
                transposed!(
                    self,
                    [blocks(0), blocks(1), blocks(2), blocks(3)],
                    _mm512_unpacklo_ps,
                    _mm512_unpackhi_ps,
                    _mm512_unpacklo_pd,
                    _mm512_unpackhi_pd,
                    _mm512_castps_pd,
                    _mm512_castpd_ps
                )
            }
        }
    }

    impl Level for Avx2 {
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
        unsafe fn rows(self, rows: &[[f32; 4]], indices: i32x16<Self>) -> [f32x16<Self>; 4] {
            debug_assert!(indices.iter().all(|&i| (i as usize) < rows.len()));
            let indices: [i32; 16] = indices.into();
            // SAFETY: as above.
            unsafe {
                let row =
                    |lane: usize| _mm_loadu_ps(rows.as_ptr().add(indices[lane] as usize).cast());
                // Of eight lanes from `from` on. Block b of vector j: lane 4b + j.
                let eight = inlined(
                    #[inline(always)]
                    |from: usize| -> [f32x8<Avx2>; 4] {
                        let blocks = |j: usize| _mm256_set_m128(row(from + 4 + j), row(from + j));
                        transposed!(
                            self,
                            [blocks(0), blocks(1), blocks(2), blocks(3)],
                            _mm256_unpacklo_ps,
                            _mm256_unpackhi_ps,
                            _mm256_unpacklo_pd,
                            _mm256_unpackhi_pd,
                            _mm256_castps_pd,
                            _mm256_castpd_ps
                        )
                    },
                );
                let (low, high) = (eight(0), eight(8));
                [
                    self.combine_f32x8(low[0], high[0]),
                    self.combine_f32x8(low[1], high[1]),
                    self.combine_f32x8(low[2], high[2]),
                    self.combine_f32x8(low[3], high[3]),
                ]
            }
        }
    }

    impl Level for Sse2 {
        #[inline(always)]
        fn proof() -> Sse2 {
            // SAFETY: every processor that this target's code runs on has it.
            unsafe { Sse2::assume_supported() }
        }

        min_and_max!();

        #[inline(always)]
        unsafe fn words(self, bytes: &[u8], offsets: i32x16<Self>) -> u32x16<Self> {
            // SAFETY: as the caller promises.
            unsafe { words_one_by_one(self, bytes, offsets) }
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
    #[inline(always)]
    fn proof() -> Portable {
        portable_proof()
    }

    #[inline(always)]
    unsafe fn words(self, bytes: &[u8], offsets: i32x16<Self>) -> u32x16<Self> {
        // SAFETY: as the caller promises.
        unsafe { words_one_by_one(self, bytes, offsets) }
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
