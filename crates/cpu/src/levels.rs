//! Instruction sets: which one a picture is drawn with, and what a vector library has no name for.

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
#[expect(
    clippy::disallowed_types,
    reason = "what a level is, not that it is there"
)]
mod x86;

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

    /// The fastest that this CPU has.
    pub fn fastest() -> InstructionSet {
        InstructionSet::ALL
            .into_iter()
            .find(|set| set.is_there())
            .unwrap_or(InstructionSet::Portable)
    }

    /// What the environment variable `STRAHL_SIMD` says; without it, the fastest.
    ///
    /// # Errors
    /// It says something else than the name of a set that this CPU has.
    pub(crate) fn from_environment() -> Result<InstructionSet, Error> {
        let Some(value) = std::env::var_os("STRAHL_SIMD") else {
            return Ok(InstructionSet::fastest());
        };
        let set = value.to_str().and_then(InstructionSet::from_name);
        set.ok_or_else(|| Error::NoSuchInstructions {
            value: value.to_string_lossy().into_owned(),
        })
    }

    /// Whether this CPU has it.
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
/// Code for a level runs only below [`dispatch`], which has found that the CPU has it: nowhere else can a level
/// be chosen, as `clippy.toml` forbids the names of all levels that a CPU might not have.
pub trait Level: Simd + Send + Sync {
    /// Whether loops and reconstruction are compiled for each of the usual types of sample. Without gathers they take
    /// as long as those for any type, and longer to compile than all else here.
    const HAS_LOOPS_PER_TYPE: bool;

    /// The proof that the CPU has the level.
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
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
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

/// Does `task` with the instructions of `set`, which the CPU has; with the portable ones if not.
pub fn dispatch<T: Task>(set: InstructionSet, task: T) -> T::Output {
    let set = if set.is_there() {
        set
    } else {
        InstructionSet::Portable
    };
    #[allow(clippy::disallowed_types, reason = "the CPU has it")]
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
                println!("skipped: this CPU has no {set}");
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
