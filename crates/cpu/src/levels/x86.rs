//! The levels of x86.

use super::{Level, in_memory, inlined, words_one_by_one};
use fearless_simd::x86::{Avx2, Avx512, Sse2};
use fearless_simd::{Bytes, Simd, SimdInto, f32x8, f32x16, i32x8, i32x16, u32x8, u32x16};
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
        // SAFETY: code for this level runs only below `dispatch`, as nothing else may name it.
        unsafe { Avx512::assume_supported() }
    }

    min_and_max!();

    #[inline(always)]
    unsafe fn words(self, bytes: &[u8], offsets: i32x16<Self>) -> u32x16<Self> {
        debug_assert!(offsets.iter().all(|&o| o as usize + 4 <= bytes.len()));
        let offsets: __m512i = offsets.into();
        // SAFETY: the CPU has the instruction, as `self` proves; every word lies inside
        // `bytes`, as the caller promises.
        let words = unsafe { _mm512_i32gather_epi32::<1>(offsets, bytes.as_ptr().cast()) };
        words.simd_into(self)
    }

    #[inline(always)]
    fn picked(self, packet: &[f32; 32], indices: i32x16<Self>) -> f32x16<Self> {
        let from = packet.as_ptr();
        // SAFETY: the CPU has the instructions, as `self` proves, and a packet is two vectors.
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
        // SAFETY: the CPU has the instructions, as `self` proves, and 16 rows are four vectors.
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
    unsafe fn row_pairs(self, rows: &[[f32; 4]], indices: i32x16<Self>) -> [[f32x16<Self>; 4]; 2] {
        debug_assert!(indices.iter().all(|&i| (i as usize) + 1 < rows.len()));
        let indices = in_memory(indices);
        // SAFETY: the CPU has the instructions, as `self` proves; every row and the one behind it
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
        // SAFETY: code for this level runs only below `dispatch`, as nothing else may name it.
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
                let words = unsafe { _mm256_i32gather_epi32::<1>(bytes.as_ptr().cast(), offsets) };
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
    unsafe fn row_pairs(self, rows: &[[f32; 4]], indices: i32x16<Self>) -> [[f32x16<Self>; 4]; 2] {
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
                    transposed_256!([pair(from), pair(from + 1), pair(from + 2), pair(from + 3)])
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
