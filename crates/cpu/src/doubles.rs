//! Double-precision numbers for a packet of rays: laying the lattice needs them, sampling does not.

use crate::lanes::{F32s, LANES};
use crate::levels::{Level, inlined};
use fearless_simd::{SimdBase, SimdFloat, SimdFrom, SimdMask, f64x8, mask64x8};
use glam::{DAffine3, DVec3};
use std::ops::{Add, BitAnd, BitOr, Mul, Neg, Sub};

/// A number per ray, in vectors of eight.
#[derive(Clone, Copy)]
pub struct F64s<S: Level>([f64x8<S>; 4]);

/// Yes or no per ray.
#[derive(Clone, Copy)]
pub struct Mask64<S: Level>([mask64x8<S>; 4]);

/// A point or a direction per ray.
pub type Points<S> = [F64s<S>; 3];

/// Lanes of a vector.
const EIGHT: usize = 8;

/// The same expression for each vector. (Closures that are called often are not sure to be inlined.)
macro_rules! all {
    ($a:expr, |$x:ident| $f:expr) => {{
        let [a, b, c, d] = $a;
        [
            {
                let $x = a;
                $f
            },
            {
                let $x = b;
                $f
            },
            {
                let $x = c;
                $f
            },
            {
                let $x = d;
                $f
            },
        ]
    }};
}

/// The same expression for each pair of vectors.
macro_rules! pairs {
    ($a:expr, $b:expr, |$x:ident, $y:ident| $f:expr) => {{
        let (first, second) = ($a, $b);
        all!([0, 1, 2, 3], |vector| {
            let ($x, $y) = (first[vector], second[vector]);
            $f
        })
    }};
}

impl<S: Level> F64s<S> {
    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(value: f64) -> F64s<S> {
        F64s([f64x8::splat(S::proof(), value); 4])
    }

    /// A number for each lane.
    #[inline(always)]
    pub fn from_array(values: [f64; LANES]) -> F64s<S> {
        F64s(all!([0, 1, 2, 3], |vector| {
            let mut eight = [0.0; EIGHT];
            eight.copy_from_slice(&values[vector * EIGHT..(vector + 1) * EIGHT]);
            f64x8::simd_from(S::proof(), eight)
        }))
    }

    /// The number of one lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> f64 {
        self.0[lane / EIGHT][lane % EIGHT]
    }

    /// The same numbers, exactly.
    #[inline(always)]
    pub fn from_single(numbers: F32s<S>) -> F64s<S> {
        F64s(numbers.to_doubles())
    }

    /// Rounded to the nearest single.
    #[inline(always)]
    pub fn to_single(self) -> F32s<S> {
        F32s::from_doubles(self.0)
    }

    /// Quotient, correctly rounded.
    #[inline(always)]
    pub fn over(self, divisor: F64s<S>) -> F64s<S> {
        F64s(pairs!(self.0, divisor.0, |a, b| a / b))
    }

    /// The square root, correctly rounded.
    #[inline(always)]
    pub fn sqrt(self) -> F64s<S> {
        F64s(all!(self.0, |a| a.sqrt()))
    }

    /// The smallest whole number that is not smaller.
    #[inline(always)]
    pub fn ceil(self) -> F64s<S> {
        F64s(all!(self.0, |a| a.ceil()))
    }

    /// Without the sign.
    #[inline(always)]
    pub fn abs(self) -> F64s<S> {
        F64s(all!(self.0, |a| a.abs()))
    }

    /// Where this is less.
    #[inline(always)]
    pub fn lt(self, other: F64s<S>) -> Mask64<S> {
        Mask64(pairs!(self.0, other.0, |a, b| a.simd_lt(b)))
    }

    /// The smaller number; `other` where either is NaN.
    #[inline(always)]
    pub fn min(self, other: F64s<S>) -> F64s<S> {
        self.lt(other).select(self, other)
    }

    /// The larger number; `other` where either is NaN.
    #[inline(always)]
    pub fn max(self, other: F64s<S>) -> F64s<S> {
        other.lt(self).select(self, other)
    }
}

impl<S: Level> Mask64<S> {
    /// `yes` where set, `no` elsewhere.
    #[inline(always)]
    pub fn select(self, yes: F64s<S>, no: F64s<S>) -> F64s<S> {
        F64s(all!([0, 1, 2, 3], |vector| {
            S::proof().select_f64x8(self.0[vector], yes.0[vector], no.0[vector])
        }))
    }

    /// Yes or no for each lane.
    #[inline(always)]
    pub fn from_array(set: [bool; LANES]) -> Mask64<S> {
        let mut bits = 0u64;
        for (lane, set) in set.into_iter().enumerate() {
            bits |= u64::from(set) << lane;
        }
        Mask64(all!([0, 1, 2, 3], |vector| {
            mask64x8::from_bitmask(S::proof(), bits >> (vector * EIGHT) & 0xFF)
        }))
    }

    /// Whether any lane is set.
    #[inline(always)]
    pub fn any(self) -> bool {
        let [a, b, c, d] = self.0;
        ((a | b) | (c | d)).any_true()
    }
}

macro_rules! vectors {
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

vectors! {
    Add add F64s;
    Sub sub F64s;
    Mul mul F64s;
    BitAnd bitand Mask64;
    BitOr bitor Mask64;
}

impl<S: Level> Neg for F64s<S> {
    type Output = F64s<S>;
    #[inline(always)]
    fn neg(self) -> F64s<S> {
        F64s(all!(self.0, |a| -a))
    }
}

/// The same vector in every lane.
#[inline(always)]
pub fn splat<S: Level>(v: DVec3) -> Points<S> {
    [F64s::splat(v.x), F64s::splat(v.y), F64s::splat(v.z)]
}

/// a · b.
#[inline(always)]
pub fn dot<S: Level>(a: Points<S>, b: Points<S>) -> F64s<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a + b·s.
#[inline(always)]
pub fn along<S: Level>(a: Points<S>, b: Points<S>, s: F64s<S>) -> Points<S> {
    [a[0] + b[0] * s, a[1] + b[1] * s, a[2] + b[2] * s]
}

/// The image of a direction.
#[inline(always)]
pub fn turned<S: Level>(affine: &DAffine3, v: Points<S>) -> Points<S> {
    let m = &affine.matrix3;
    let row = inlined(
        #[inline(always)]
        |r: usize| {
            let [x, y, z] = [m.x_axis[r], m.y_axis[r], m.z_axis[r]];
            F64s::splat(x) * v[0] + F64s::splat(y) * v[1] + F64s::splat(z) * v[2]
        },
    );
    [row(0), row(1), row(2)]
}

/// The image of a point.
#[inline(always)]
pub fn moved<S: Level>(affine: &DAffine3, p: Points<S>) -> Points<S> {
    let turned = turned(affine, p);
    let by = splat(affine.translation);
    [turned[0] + by[0], turned[1] + by[1], turned[2] + by[2]]
}
