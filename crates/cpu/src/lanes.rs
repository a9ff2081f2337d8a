//! Numbers for a packet of rays: one lane per ray.
//!
//! Generic over the instruction set ([`Level`]). Every operation is IEEE single precision, lane by lane,
//! and none is fused with another, so that a lane's result does not depend on the set.

use crate::levels::{Level, inlined};
use fearless_simd::{
    Bytes, SimdBase, SimdFloat, SimdFrom, SimdMask, f32x16, f64x8, i32x16, mask32x16,
};
use std::ops::{Add, AddAssign, BitAnd, BitOr, Mul, Neg, Not, Sub};

/// Rays per packet, a block of [`PACKET`] pixels. Two of the widest vectors: while one waits for what it
/// has gathered, the other one is worked on.
pub const LANES: usize = 32;

/// Columns and rows of pixels that a packet covers: blocks stay together in the volume better than
/// rows do.
pub const PACKET: [usize; 2] = [8, 4];

/// Lanes of a vector.
const HALF: usize = 16;

/// A number per ray.
#[derive(Clone, Copy)]
pub struct F32s<S: Level>([f32x16<S>; 2]);

/// A whole number per ray.
#[derive(Clone, Copy)]
pub struct I32s<S: Level>([i32x16<S>; 2]);

/// Yes or no per ray.
#[derive(Clone, Copy)]
pub struct Mask<S: Level>([mask32x16<S>; 2]);

/// A point, a direction or a color per ray.
pub type Vec3s<S> = [F32s<S>; 3];

/// Calls `f` for every lane.
#[inline(always)]
pub fn lanes<T: Copy + Default>(f: impl Fn(usize) -> T) -> [T; LANES] {
    let mut out = [T::default(); LANES];
    for (lane, out) in out.iter_mut().enumerate() {
        *out = f(lane);
    }
    out
}

/// The same expression for each component. (Closures that are called thrice, as the standard library's
/// `map` of arrays does, are not sure to be inlined, and so would not be compiled for the level.)
macro_rules! each {
    ($v:expr, |$x:ident| $f:expr $(,)?) => {{
        let [first, second, third] = $v;
        [
            {
                let $x = first;
                $f
            },
            {
                let $x = second;
                $f
            },
            {
                let $x = third;
                $f
            },
        ]
    }};
}
pub(crate) use each;

/// The same expression for each vector.
macro_rules! both {
    ($a:expr, |$x:ident| $f:expr) => {{
        let [first, second] = $a;
        [
            {
                let $x = first;
                $f
            },
            {
                let $x = second;
                $f
            },
        ]
    }};
}

/// The same expression for each pair of vectors.
macro_rules! pairs {
    ($a:expr, $b:expr, |$x:ident, $y:ident| $f:expr) => {{
        let ([first, second], [third, fourth]) = ($a, $b);
        [
            {
                let ($x, $y) = (first, third);
                $f
            },
            {
                let ($x, $y) = (second, fourth);
                $f
            },
        ]
    }};
}

/// The first or the second half of the lanes.
#[inline(always)]
fn half<T: Copy + Default>(values: &[T; LANES], vector: usize) -> [T; HALF] {
    let mut half = [T::default(); HALF];
    half.copy_from_slice(&values[vector * HALF..(vector + 1) * HALF]);
    half
}

impl<S: Level> F32s<S> {
    /// 0 in every lane.
    #[inline(always)]
    pub fn zero() -> F32s<S> {
        F32s::splat(0.0)
    }

    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(value: f32) -> F32s<S> {
        F32s([f32x16::splat(S::proof(), value); 2])
    }

    /// A number for each lane.
    #[inline(always)]
    pub fn from_array(values: [f32; LANES]) -> F32s<S> {
        F32s(both!([0, 1], |vector| {
            f32x16::simd_from(S::proof(), half(&values, vector))
        }))
    }

    /// The first numbers of `values`.
    #[inline(always)]
    pub fn from_start(values: &[f32]) -> F32s<S> {
        F32s([
            f32x16::from_slice(S::proof(), &values[..HALF]),
            f32x16::from_slice(S::proof(), &values[HALF..LANES]),
        ])
    }

    /// Of the numbers of a packet that of each of the rays `rays`.
    #[inline(always)]
    pub fn picked(packet: &[f32; LANES], rays: I32s<S>) -> F32s<S> {
        F32s(both!(rays.0, |rays| S::proof().picked(packet, rays)))
    }

    /// From doubles, eight lanes each, rounded to the nearest single.
    #[inline(always)]
    pub fn from_doubles(eights: [f64x8<S>; 4]) -> F32s<S> {
        let [a, b, c, d] = eights;
        F32s([S::proof().narrow_f64x8(a, b), S::proof().narrow_f64x8(c, d)])
    }

    /// As doubles, exactly, eight lanes each.
    #[inline(always)]
    pub fn to_doubles(self) -> [f64x8<S>; 4] {
        let (a, b) = S::proof().widen_f32x16(self.0[0]);
        let (c, d) = S::proof().widen_f32x16(self.0[1]);
        [a, b, c, d]
    }

    /// The number of each lane.
    #[inline(always)]
    pub fn to_array(self) -> [f32; LANES] {
        let mut numbers = [0.0; LANES];
        self.0[0].store_slice(&mut numbers[..HALF]);
        self.0[1].store_slice(&mut numbers[HALF..]);
        numbers
    }

    /// The number of one lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> f32 {
        self.0[lane / HALF][lane % HALF]
    }

    /// The smaller number; `other` where either is NaN.
    #[inline(always)]
    pub fn min(self, other: F32s<S>) -> F32s<S> {
        F32s(pairs!(self.0, other.0, |a, b| S::proof().lesser(a, b)))
    }

    /// The larger number; `other` where either is NaN.
    #[inline(always)]
    pub fn max(self, other: F32s<S>) -> F32s<S> {
        F32s(pairs!(self.0, other.0, |a, b| S::proof().greater(a, b)))
    }

    /// Without the sign.
    #[inline(always)]
    pub fn abs(self) -> F32s<S> {
        F32s(both!(self.0, |a| a.abs()))
    }

    /// The square root, correctly rounded.
    #[inline(always)]
    pub fn sqrt(self) -> F32s<S> {
        F32s(both!(self.0, |a| a.sqrt()))
    }

    /// The largest whole number that is not larger.
    #[inline(always)]
    pub fn floor(self) -> F32s<S> {
        F32s(both!(self.0, |a| a.floor()))
    }

    /// Towards zero; numbers beyond i32 and NaN give any number.
    #[inline(always)]
    pub fn to_i32s(self) -> I32s<S> {
        I32s(both!(self.0, |a| S::proof().cvt_i32_f32x16(a)))
    }

    /// The bits of the numbers.
    #[inline(always)]
    pub fn to_bits(self) -> I32s<S> {
        I32s(both!(self.0, |a| a.bitcast()))
    }

    /// Where this is less.
    #[inline(always)]
    pub fn lt(self, other: F32s<S>) -> Mask<S> {
        Mask(pairs!(self.0, other.0, |a, b| a.simd_lt(b)))
    }

    /// Where this is less or equal.
    #[inline(always)]
    pub fn le(self, other: F32s<S>) -> Mask<S> {
        Mask(pairs!(self.0, other.0, |a, b| a.simd_le(b)))
    }

    /// Where both are equal.
    #[inline(always)]
    pub fn eq(self, other: F32s<S>) -> Mask<S> {
        Mask(pairs!(self.0, other.0, |a, b| a.simd_eq(b)))
    }

    /// Where this is neither infinite nor NaN.
    #[inline(always)]
    pub fn is_finite(self) -> Mask<S> {
        self.abs().lt(F32s::splat(f32::INFINITY))
    }

    /// From `self` (part 0) to `to` (part 1).
    #[inline(always)]
    pub fn lerp(self, to: F32s<S>, part: F32s<S>) -> F32s<S> {
        self + (to - self) * part
    }

    /// Quotient, correctly rounded.
    #[inline(always)]
    pub fn over(self, divisor: F32s<S>) -> F32s<S> {
        F32s(pairs!(self.0, divisor.0, |a, b| a / b))
    }
}

/// The numbers of `rows` at `indices`, and of those that follow them.
///
/// # Safety
/// There is a row for every index, and one behind it.
#[inline(always)]
pub unsafe fn row_pairs<S: Level>(rows: &[[f32; 4]], indices: I32s<S>) -> [[F32s<S>; 4]; 2] {
    // SAFETY: as the caller promises.
    let [a, b] = both!(indices.0, |indices| unsafe {
        S::proof().row_pairs(rows, indices)
    });
    let numbers = inlined(
        #[inline(always)]
        |row: usize, channel: usize| F32s([a[row][channel], b[row][channel]]),
    );
    let row = inlined(
        #[inline(always)]
        |row: usize| {
            [
                numbers(row, 0),
                numbers(row, 1),
                numbers(row, 2),
                numbers(row, 3),
            ]
        },
    );
    [row(0), row(1)]
}

/// A row of the four numbers of each lane.
#[inline(always)]
pub fn to_rows<S: Level>(columns: [F32s<S>; 4]) -> [[f32; 4]; LANES] {
    let [a, b, c, d] = columns;
    let halves = both!([0, 1], |vector| {
        S::proof().to_rows([a.0[vector], b.0[vector], c.0[vector], d.0[vector]])
    });
    let mut rows = [[0.0; 4]; LANES];
    rows[..HALF].copy_from_slice(&halves[0]);
    rows[HALF..].copy_from_slice(&halves[1]);
    rows
}

/// The little-endian words of four bytes at `offsets`, in bytes.
///
/// # Safety
/// `offset .. offset + 4` lies inside `bytes` for every lane.
#[inline(always)]
pub unsafe fn words<S: Level>(bytes: &[u8], offsets: I32s<S>) -> I32s<S> {
    I32s(both!(offsets.0, |offsets| {
        // SAFETY: as the caller promises.
        unsafe { S::proof().words(bytes, offsets) }.bitcast()
    }))
}

/// The same at the nearest offsets at which words lie inside `bytes`: of whatever grid a caller's cells are.
///
/// # Panics
/// If there are fewer than four bytes.
#[inline(always)]
pub fn words_inside<S: Level>(bytes: &[u8], offsets: I32s<S>) -> I32s<S> {
    let last = bytes.len().checked_sub(4).expect("a word at least");
    let last = i32::try_from(last).unwrap_or(i32::MAX);
    // SAFETY: 0 to the last offset at which four bytes follow.
    unsafe { words(bytes, offsets.max(0).min(last)) }
}

impl<S: Level> I32s<S> {
    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(value: i32) -> I32s<S> {
        I32s([i32x16::splat(S::proof(), value); 2])
    }

    /// The number of one lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> i32 {
        self.0[lane / HALF][lane % HALF]
    }

    /// The number of each lane.
    #[inline(always)]
    pub fn to_array(self) -> [i32; LANES] {
        let mut numbers = [0; LANES];
        numbers[..HALF].copy_from_slice(&<[i32; HALF]>::from(self.0[0]));
        numbers[HALF..].copy_from_slice(&<[i32; HALF]>::from(self.0[1]));
        numbers
    }

    /// The nearest number.
    #[inline(always)]
    pub fn to_f32s(self) -> F32s<S> {
        F32s(both!(self.0, |a| S::proof().cvt_f32_i32x16(a)))
    }

    /// The numbers with these bits.
    #[inline(always)]
    pub fn as_bits(self) -> F32s<S> {
        F32s(both!(self.0, |a| a.bitcast()))
    }

    /// The smaller number.
    #[inline(always)]
    pub fn min(self, other: i32) -> I32s<S> {
        let other = I32s::<S>::splat(other).0;
        I32s(pairs!(self.0, other, |a, b| S::proof().min_i32x16(a, b)))
    }

    /// The larger number.
    #[inline(always)]
    pub fn max(self, other: i32) -> I32s<S> {
        let other = I32s::<S>::splat(other).0;
        I32s(pairs!(self.0, other, |a, b| S::proof().max_i32x16(a, b)))
    }

    /// Where this is less.
    #[inline(always)]
    pub fn lt(self, other: I32s<S>) -> Mask<S> {
        Mask(pairs!(self.0, other.0, |a, b| a.simd_lt(b)))
    }

    /// The bits that both have.
    #[inline(always)]
    pub fn both(self, other: I32s<S>) -> I32s<S> {
        I32s(pairs!(self.0, other.0, |a, b| a & b))
    }

    /// The bits that both have.
    #[inline(always)]
    pub fn and(self, other: i32) -> I32s<S> {
        let other = I32s::<S>::splat(other).0;
        I32s(pairs!(self.0, other, |a, b| a & b))
    }

    /// The bits that either has.
    #[inline(always)]
    pub fn or(self, other: i32) -> I32s<S> {
        let other = I32s::<S>::splat(other).0;
        I32s(pairs!(self.0, other, |a, b| a | b))
    }

    /// Divided by 2^`bits`, rounded down.
    #[inline(always)]
    pub fn shifted_down(self, bits: u32) -> I32s<S> {
        I32s(both!(self.0, |a| a >> bits))
    }

    /// Times 2^`bits`.
    #[inline(always)]
    pub fn shifted_up(self, bits: u32) -> I32s<S> {
        I32s(both!(self.0, |a| a << bits))
    }
}

impl<S: Level> Mask<S> {
    /// No ray.
    #[inline(always)]
    pub fn none() -> Mask<S> {
        Mask([mask32x16::splat(S::proof(), false); 2])
    }

    /// `yes` where set, `no` elsewhere.
    #[inline(always)]
    pub fn select(self, yes: F32s<S>, no: F32s<S>) -> F32s<S> {
        F32s([
            S::proof().select_f32x16(self.0[0], yes.0[0], no.0[0]),
            S::proof().select_f32x16(self.0[1], yes.0[1], no.0[1]),
        ])
    }

    /// `yes` where set, `no` elsewhere.
    #[inline(always)]
    pub fn select_i32s(self, yes: I32s<S>, no: I32s<S>) -> I32s<S> {
        I32s([
            S::proof().select_i32x16(self.0[0], yes.0[0], no.0[0]),
            S::proof().select_i32x16(self.0[1], yes.0[1], no.0[1]),
        ])
    }

    /// `yes` where set, `no` elsewhere.
    #[inline(always)]
    pub fn select3(self, yes: Vec3s<S>, no: Vec3s<S>) -> Vec3s<S> {
        [
            self.select(yes[0], no[0]),
            self.select(yes[1], no[1]),
            self.select(yes[2], no[2]),
        ]
    }

    /// Whether any ray is set.
    #[inline(always)]
    pub fn any(self) -> bool {
        (self.0[0] | self.0[1]).any_true()
    }

    /// Writes the numbers of the rays set, and nothing of meaning behind them, to `to` from `at` on, where
    /// there is room for a packet.
    #[inline(always)]
    pub fn append(self, numbers: F32s<S>, to: &mut [f32], at: usize) {
        let to = &mut to[at..at + LANES];
        let first = S::proof().compress_f32x16(numbers.0[0], self.0[0]);
        let second = S::proof().compress_f32x16(numbers.0[1], self.0[1]);
        first.store_slice(&mut to[..HALF]);
        let count = self.0[0].to_bitmask().count_ones() as usize;
        second.store_slice(&mut to[count..count + HALF]);
    }

    /// Number of rays set.
    #[inline(always)]
    pub fn count(self) -> u64 {
        let [a, b] = both!(self.0, |mask| u64::from(mask.to_bitmask().count_ones()));
        a + b
    }
}

macro_rules! lanewise {
    ($($trait:ident $method:ident $type:ident;)*) => {$(
        impl<S: Level> $trait for $type<S> {
            type Output = $type<S>;
            #[inline(always)]
            fn $method(self, other: $type<S>) -> $type<S> {
                $type(pairs!(self.0, other.0, |a, b| $trait::$method(a, b)))
            }
        }
    )*};
}

lanewise! {
    Add add F32s;
    Sub sub F32s;
    Mul mul F32s;
    Add add I32s;
    Sub sub I32s;
    Mul mul I32s;
    BitAnd bitand Mask;
    BitOr bitor Mask;
}

impl<S: Level> Not for Mask<S> {
    type Output = Mask<S>;
    #[inline(always)]
    fn not(self) -> Mask<S> {
        Mask(both!(self.0, |a| !a))
    }
}

impl<S: Level> Neg for F32s<S> {
    type Output = F32s<S>;
    #[inline(always)]
    fn neg(self) -> F32s<S> {
        F32s(both!(self.0, |a| -a))
    }
}

impl<S: Level> AddAssign for F32s<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: F32s<S>) {
        *self = *self + other;
    }
}

/// a + b·s.
#[inline(always)]
pub fn along<S: Level>(a: Vec3s<S>, b: Vec3s<S>, s: F32s<S>) -> Vec3s<S> {
    [a[0] + b[0] * s, a[1] + b[1] * s, a[2] + b[2] * s]
}

/// a · b.
#[inline(always)]
pub fn dot<S: Level>(a: Vec3s<S>, b: Vec3s<S>) -> F32s<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a·s.
#[inline(always)]
pub fn scale<S: Level>(a: Vec3s<S>, s: F32s<S>) -> Vec3s<S> {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// Powers of two p, 1/p with 1 ≤ largest·p < 2 (or less where `largest` is subnormal).
#[inline(always)]
fn power_of_two<S: Level>(largest: F32s<S>) -> [F32s<S>; 2] {
    // Exponents from that of the smallest normal number to one whose inverse is normal.
    let exponent = largest.to_bits().shifted_down(23).max(1).min(253);
    let inverse = I32s::splat(254) - exponent;
    [
        inverse.shifted_up(23).as_bits(),
        exponent.shifted_up(23).as_bits(),
    ]
}

/// `v` scaled to unit length, and where it has a direction. Scaled by a power of two first: the square
/// of a small gradient would underflow.
#[inline(always)]
pub fn unit<S: Level>(v: Vec3s<S>) -> (Vec3s<S>, Mask<S>) {
    let (v, length, _, usable) = scaled(v);
    let inverse = F32s::splat(1.0).over(usable.select(length, F32s::splat(1.0)));
    (each!(v, |c| c * inverse), usable)
}

/// The length of `v`, 0 where it is not finite.
#[inline(always)]
pub fn length<S: Level>(v: Vec3s<S>) -> F32s<S> {
    let (_, length, scale, usable) = scaled(v);
    usable.select(length * scale, F32s::zero())
}

/// `v` by a power of two, its length, what brings that back, and where `v` has a length.
#[inline(always)]
fn scaled<S: Level>(v: Vec3s<S>) -> (Vec3s<S>, F32s<S>, F32s<S>, Mask<S>) {
    let largest = v[0].abs().max(v[1].abs()).max(v[2].abs());
    // NaN anywhere makes the sum NaN, which compares with nothing.
    let sum = v[0].abs() + v[1].abs() + v[2].abs();
    let usable = F32s::zero().lt(largest) & sum.lt(F32s::splat(f32::INFINITY));
    let [down, up] = power_of_two(largest);
    let v = each!(v, |c| usable.select(c * down, F32s::zero()));
    (v, dot(v, v).sqrt(), up, usable)
}

/// The same vector in every lane.
#[inline(always)]
pub fn splat3<S: Level>(v: [f32; 3]) -> Vec3s<S> {
    each!(v, |c| F32s::splat(c))
}

/// An affine map with single precision: rows of the matrix, last column the translation.
#[derive(Clone, Copy, Debug)]
pub struct Affine(pub [[f32; 4]; 3]);

impl Affine {
    /// The map rounded to single precision.
    pub fn new(affine: glam::DAffine3) -> Affine {
        let (m, t) = (affine.matrix3, affine.translation);
        Affine([0, 1, 2].map(|r| [m.x_axis[r], m.y_axis[r], m.z_axis[r], t[r]].map(|v| v as f32)))
    }

    /// The image of a point.
    #[inline(always)]
    pub fn point<S: Level>(&self, p: Vec3s<S>) -> Vec3s<S> {
        each!(self.0, |row| {
            p[0] * F32s::splat(row[0])
                + p[1] * F32s::splat(row[1])
                + p[2] * F32s::splat(row[2])
                + F32s::splat(row[3])
        })
    }
}
