//! Numbers for a packet of rays: one lane per ray.
//!
//! Plain arrays with plain loops, which the compiler turns into SIMD code of whatever width it may
//! use. Every operation is IEEE single precision, lane by lane, and none is contracted (Rust never
//! fuses a multiply with an add by itself), so a lane's result does not depend on that width.

use std::ops::{Add, AddAssign, BitAnd, BitOr, Mul, Neg, Not, Sub};

/// Rays per packet, a block of [`PACKET`] pixels.
pub const LANES: usize = 8;

/// Columns and rows of pixels that a packet covers: blocks stay together in the volume better than
/// rows do.
pub const PACKET: [usize; 2] = [4, 2];

/// A number per ray.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct F32s(pub [f32; LANES]);

/// A whole number per ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C, align(32))]
pub struct I32s(pub [i32; LANES]);

/// Yes or no per ray: all bits set or none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C, align(32))]
pub struct Mask(pub [u32; LANES]);

/// A point, a direction or a colour per ray.
pub type Vec3s = [F32s; 3];

/// Calls `f` for every lane.
#[inline(always)]
pub fn lanes<T: Copy + Default>(f: impl Fn(usize) -> T) -> [T; LANES] {
    let mut out = [T::default(); LANES];
    for (lane, out) in out.iter_mut().enumerate() {
        *out = f(lane);
    }
    out
}

impl F32s {
    /// 0 in every lane.
    pub const ZERO: F32s = F32s([0.0; LANES]);

    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(value: f32) -> F32s {
        F32s([value; LANES])
    }

    /// The smaller number; `other` where this one is NaN.
    #[inline(always)]
    pub fn min(self, other: F32s) -> F32s {
        F32s(lanes(|i| {
            if self.0[i] < other.0[i] {
                self.0[i]
            } else {
                other.0[i]
            }
        }))
    }

    /// The larger number; `other` where this one is NaN.
    #[inline(always)]
    pub fn max(self, other: F32s) -> F32s {
        F32s(lanes(|i| {
            if self.0[i] > other.0[i] {
                self.0[i]
            } else {
                other.0[i]
            }
        }))
    }

    /// Without the sign.
    #[inline(always)]
    pub fn abs(self) -> F32s {
        F32s(lanes(|i| self.0[i].abs()))
    }

    /// The square root, correctly rounded.
    #[inline(always)]
    pub fn sqrt(self) -> F32s {
        F32s(lanes(|i| self.0[i].sqrt()))
    }

    /// The largest whole number that is not larger.
    #[inline(always)]
    pub fn floor(self) -> F32s {
        F32s(lanes(|i| self.0[i].floor()))
    }

    /// Towards zero, saturating; NaN gives 0.
    #[inline(always)]
    pub fn to_i32s(self) -> I32s {
        I32s(lanes(|i| self.0[i] as i32))
    }

    /// Where this is less.
    #[inline(always)]
    pub fn lt(self, other: F32s) -> Mask {
        Mask(lanes(|i| mask(self.0[i] < other.0[i])))
    }

    /// Where this is less or equal.
    #[inline(always)]
    pub fn le(self, other: F32s) -> Mask {
        Mask(lanes(|i| mask(self.0[i] <= other.0[i])))
    }

    /// Where both are equal.
    #[inline(always)]
    pub fn eq(self, other: F32s) -> Mask {
        Mask(lanes(|i| mask(self.0[i] == other.0[i])))
    }

    /// Where this is neither infinite nor NaN.
    #[inline(always)]
    pub fn is_finite(self) -> Mask {
        self.abs().lt(F32s::splat(f32::INFINITY))
    }

    /// From `self` (part 0) to `to` (part 1).
    #[inline(always)]
    pub fn lerp(self, to: F32s, part: F32s) -> F32s {
        self + (to - self) * part
    }

    /// Quotient, correctly rounded.
    #[inline(always)]
    pub fn over(self, divisor: F32s) -> F32s {
        F32s(lanes(|i| self.0[i] / divisor.0[i]))
    }
}

impl I32s {
    /// The nearest number.
    #[inline(always)]
    pub fn to_f32s(self) -> F32s {
        F32s(lanes(|i| self.0[i] as f32))
    }

    /// The smaller number.
    #[inline(always)]
    pub fn min(self, other: i32) -> I32s {
        I32s(lanes(|i| self.0[i].min(other)))
    }

    /// The larger number.
    #[inline(always)]
    pub fn max(self, other: i32) -> I32s {
        I32s(lanes(|i| self.0[i].max(other)))
    }
}

#[inline(always)]
fn mask(yes: bool) -> u32 {
    if yes { u32::MAX } else { 0 }
}

impl Mask {
    /// No ray.
    pub const NONE: Mask = Mask([0; LANES]);

    /// `yes` where set, `no` elsewhere.
    #[inline(always)]
    pub fn select(self, yes: F32s, no: F32s) -> F32s {
        F32s(lanes(|i| {
            f32::from_bits((yes.0[i].to_bits() & self.0[i]) | (no.0[i].to_bits() & !self.0[i]))
        }))
    }

    /// `yes` where set, `no` elsewhere.
    #[inline(always)]
    pub fn select3(self, yes: Vec3s, no: Vec3s) -> Vec3s {
        [
            self.select(yes[0], no[0]),
            self.select(yes[1], no[1]),
            self.select(yes[2], no[2]),
        ]
    }

    /// Whether any ray is set.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.0.iter().fold(0, |bits, &lane| bits | lane) != 0
    }

    /// Number of rays set.
    #[inline(always)]
    pub fn count(self) -> u64 {
        self.0.iter().fold(0, |n, &lane| n + (lane & 1)) as u64
    }
}

macro_rules! lanewise {
    ($($trait:ident $method:ident $type:ident $op:tt;)*) => {$(
        impl $trait for $type {
            type Output = $type;
            #[inline(always)]
            fn $method(self, other: $type) -> $type {
                $type(lanes(|i| self.0[i] $op other.0[i]))
            }
        }
    )*};
}

lanewise! {
    Add add F32s +;
    Sub sub F32s -;
    Mul mul F32s *;
    Add add I32s +;
    Sub sub I32s -;
    Mul mul I32s *;
    BitAnd bitand Mask &;
    BitOr bitor Mask |;
}

impl Not for Mask {
    type Output = Mask;
    #[inline(always)]
    fn not(self) -> Mask {
        Mask(lanes(|i| !self.0[i]))
    }
}

impl Neg for F32s {
    type Output = F32s;
    #[inline(always)]
    fn neg(self) -> F32s {
        F32s(lanes(|i| -self.0[i]))
    }
}

impl AddAssign for F32s {
    #[inline(always)]
    fn add_assign(&mut self, other: F32s) {
        *self = *self + other;
    }
}

/// a + b·s.
#[inline(always)]
pub fn along(a: Vec3s, b: Vec3s, s: F32s) -> Vec3s {
    [a[0] + b[0] * s, a[1] + b[1] * s, a[2] + b[2] * s]
}

/// a · b.
#[inline(always)]
pub fn dot(a: Vec3s, b: Vec3s) -> F32s {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a·s.
#[inline(always)]
pub fn scale(a: Vec3s, s: F32s) -> Vec3s {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// `v` scaled to unit length, and where it has a direction. Divided by its largest component first:
/// the square of a small gradient would underflow.
#[inline(always)]
pub fn unit(v: Vec3s) -> (Vec3s, Mask) {
    let largest = v[0].abs().max(v[1].abs()).max(v[2].abs());
    // NaN anywhere makes the sum NaN, which compares with nothing.
    let sum = v[0].abs() + v[1].abs() + v[2].abs();
    let usable = F32s::ZERO.lt(largest) & sum.lt(F32s::splat(f32::INFINITY));
    let divisor = usable.select(largest, F32s::splat(1.0));
    let v = v.map(|c| usable.select(c, F32s::ZERO).over(divisor));
    let length = usable.select(dot(v, v).sqrt(), F32s::splat(1.0));
    (v.map(|c| c.over(length)), usable)
}

/// The length of `v`, 0 where it is not finite.
#[inline(always)]
pub fn length(v: Vec3s) -> F32s {
    let largest = v[0].abs().max(v[1].abs()).max(v[2].abs());
    let (direction, usable) = unit(v);
    // v = length · direction: the component that is largest divides safely.
    let steepest = direction[0]
        .abs()
        .max(direction[1].abs())
        .max(direction[2].abs());
    let length = largest.over(usable.select(steepest, F32s::splat(1.0)));
    usable.select(length, F32s::ZERO)
}

/// The same vector in every lane.
#[inline(always)]
pub fn splat3(v: [f32; 3]) -> Vec3s {
    v.map(F32s::splat)
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
    pub fn point(&self, p: Vec3s) -> Vec3s {
        self.0.map(|row| {
            p[0] * F32s::splat(row[0])
                + p[1] * F32s::splat(row[1])
                + p[2] * F32s::splat(row[2])
                + F32s::splat(row[3])
        })
    }
}
