//! Numbers that a field can be evaluated on: plain, with a gradient, or as an interval.
//!
//! A field is written once, generic over [`Number`]. On `f64` it gives the value, on [`Dual`] the
//! value (the same bits) and the exact gradient by forward-mode differentiation, and on
//! [`Interval`] bounds over a box, by which sampling leaves out what cannot matter there.

use glam::DVec3;
use std::ops::{Add, Mul, Neg, Sub};

/// What fields compute with. Every operation of [`Dual`] does on its value what `f64` does.
pub trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// The same everywhere.
    fn constant(value: f64) -> Self;
    /// self · self.
    fn squared(self) -> Self;
    /// Square root; the gradient at 0 is taken as 0.
    fn sqrt(self) -> Self;
    /// |self|.
    fn abs(self) -> Self;
    /// e^self.
    fn exp(self) -> Self;
    /// Sine of radians.
    fn sin(self) -> Self;
    /// Cosine of radians.
    fn cos(self) -> Self;
    /// self / divisor, known to lie in `range` for every input: intervals are cut to it, and 0/0 is its start.
    fn ratio_within(self, divisor: Self, range: [f64; 2]) -> Self;
    /// The larger.
    fn max(self, other: Self) -> Self;
    /// The smaller.
    fn min(self, other: Self) -> Self {
        -(-self).max(-other)
    }
    /// `other` laid over self: other where `cover` is 1, self where it is 0, both to the bit.
    fn covered_by(self, other: f64, cover: Self) -> Self;
    /// Cut to lo..=hi.
    fn clamp(self, lo: f64, hi: f64) -> Self;
    /// The smaller, rounded where the two differ by less than `blend`: the quadratic polynomial
    /// smooth minimum. Exactly the smaller one elsewhere, which is what makes leaving out far parts exact.
    fn smooth_min(self, other: Self, blend: f64) -> Self;
    /// The larger, rounded in the same way.
    fn smooth_max(self, other: Self, blend: f64) -> Self {
        -(-self).smooth_min(-other, blend)
    }
    /// How much of a soft-edged solid covers a point at this signed distance: 1 inside, 0 outside,
    /// a smoothstep between −`edge` and +`edge`.
    fn cover(self, edge: f64) -> Self;
}

fn smooth_min(a: f64, b: f64, blend: f64) -> f64 {
    if blend <= 0.0 {
        return a.min(b);
    }
    let h = (blend - (a - b).abs()).max(0.0);
    a.min(b) - h * h * (0.25 / blend)
}

fn cover(distance: f64, edge: f64) -> f64 {
    let t = (0.5 - distance * (0.5 / edge)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

impl Number for f64 {
    #[inline(always)]
    fn constant(value: f64) -> f64 {
        value
    }
    #[inline(always)]
    fn squared(self) -> f64 {
        self * self
    }
    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }
    #[inline(always)]
    fn exp(self) -> f64 {
        f64::exp(self)
    }
    #[inline(always)]
    fn sin(self) -> f64 {
        f64::sin(self)
    }
    #[inline(always)]
    fn cos(self) -> f64 {
        f64::cos(self)
    }
    #[inline(always)]
    fn ratio_within(self, divisor: f64, range: [f64; 2]) -> f64 {
        // f64::max drops the NaN of 0/0.
        (self / divisor).max(range[0])
    }
    #[inline(always)]
    fn max(self, other: f64) -> f64 {
        f64::max(self, other)
    }
    #[inline(always)]
    fn min(self, other: f64) -> f64 {
        f64::min(self, other)
    }
    #[inline(always)]
    fn covered_by(self, other: f64, cover: f64) -> f64 {
        if cover >= 1.0 {
            other
        } else {
            self + (other - self) * cover
        }
    }
    #[inline(always)]
    fn clamp(self, lo: f64, hi: f64) -> f64 {
        f64::clamp(self, lo, hi)
    }
    #[inline(always)]
    fn smooth_min(self, other: f64, blend: f64) -> f64 {
        smooth_min(self, other, blend)
    }
    #[inline(always)]
    fn cover(self, edge: f64) -> f64 {
        cover(self, edge)
    }
}

/// A number with one value: all but intervals.
pub trait Single: Number {
    /// The value.
    fn value(self) -> f64;
}

impl Single for f64 {
    #[inline(always)]
    fn value(self) -> f64 {
        self
    }
}

impl Single for Dual {
    fn value(self) -> f64 {
        self.value
    }
}

/// A value with its gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual {
    /// The value.
    pub value: f64,
    /// Its derivatives by x, y, z.
    pub gradient: DVec3,
}

impl Dual {
    /// The three coordinates of a point as functions of the point.
    pub fn coordinates(p: DVec3) -> [Dual; 3] {
        [(p.x, DVec3::X), (p.y, DVec3::Y), (p.z, DVec3::Z)]
            .map(|(value, gradient)| Dual { value, gradient })
    }

    fn chain(self, value: f64, derivative: f64) -> Dual {
        Dual {
            value,
            gradient: self.gradient * derivative,
        }
    }
}

impl Add for Dual {
    type Output = Dual;
    fn add(self, other: Dual) -> Dual {
        Dual {
            value: self.value + other.value,
            gradient: self.gradient + other.gradient,
        }
    }
}

impl Sub for Dual {
    type Output = Dual;
    fn sub(self, other: Dual) -> Dual {
        Dual {
            value: self.value - other.value,
            gradient: self.gradient - other.gradient,
        }
    }
}

impl Mul for Dual {
    type Output = Dual;
    fn mul(self, other: Dual) -> Dual {
        Dual {
            value: self.value * other.value,
            gradient: self.gradient * other.value + other.gradient * self.value,
        }
    }
}

impl Neg for Dual {
    type Output = Dual;
    fn neg(self) -> Dual {
        self.chain(-self.value, -1.0)
    }
}

impl Add<f64> for Dual {
    type Output = Dual;
    fn add(self, other: f64) -> Dual {
        self.chain(self.value + other, 1.0)
    }
}

impl Sub<f64> for Dual {
    type Output = Dual;
    fn sub(self, other: f64) -> Dual {
        self.chain(self.value - other, 1.0)
    }
}

impl Mul<f64> for Dual {
    type Output = Dual;
    fn mul(self, other: f64) -> Dual {
        self.chain(self.value * other, other)
    }
}

impl Number for Dual {
    fn constant(value: f64) -> Dual {
        Dual {
            value,
            gradient: DVec3::ZERO,
        }
    }
    fn squared(self) -> Dual {
        self.chain(self.value * self.value, 2.0 * self.value)
    }
    fn sqrt(self) -> Dual {
        let root = self.value.sqrt();
        self.chain(root, if root > 0.0 { 0.5 / root } else { 0.0 })
    }
    fn abs(self) -> Dual {
        self.chain(self.value.abs(), self.value.signum())
    }
    fn exp(self) -> Dual {
        let e = self.value.exp();
        self.chain(e, e)
    }
    fn sin(self) -> Dual {
        self.chain(self.value.sin(), self.value.cos())
    }
    fn cos(self) -> Dual {
        self.chain(self.value.cos(), -self.value.sin())
    }
    fn ratio_within(self, divisor: Dual, range: [f64; 2]) -> Dual {
        let value = self.value / divisor.value;
        if value >= range[0] {
            Dual {
                value,
                gradient: (self.gradient - divisor.gradient * value) / divisor.value,
            }
        } else {
            Dual::constant(range[0])
        }
    }
    fn max(self, other: Dual) -> Dual {
        if self.value >= other.value {
            self
        } else {
            other
        }
    }
    fn covered_by(self, other: f64, cover: Dual) -> Dual {
        if cover.value >= 1.0 {
            Dual::constant(other)
        } else {
            self + (-self + other) * cover
        }
    }
    fn clamp(self, lo: f64, hi: f64) -> Dual {
        if self.value < lo {
            Dual::constant(lo)
        } else if self.value > hi {
            Dual::constant(hi)
        } else {
            self
        }
    }
    fn smooth_min(self, other: Dual, blend: f64) -> Dual {
        let (near, far) = if self.value <= other.value {
            (self, other)
        } else {
            (other, self)
        };
        // d/d far of min − h²/(4·blend), with h = blend − (far − near).
        let share = if blend > 0.0 {
            (blend - (far.value - near.value)).max(0.0) * (0.5 / blend)
        } else {
            0.0
        };
        Dual {
            value: smooth_min(self.value, other.value, blend),
            gradient: near.gradient * (1.0 - share) + far.gradient * share,
        }
    }
    fn cover(self, edge: f64) -> Dual {
        let scale = 0.5 / edge;
        let t = (0.5 - self.value * scale).clamp(0.0, 1.0);
        self.chain(cover(self.value, edge), -6.0 * t * (1.0 - t) * scale)
    }
}

/// All that a field can be over a box. Bounds are rounded to nearest, not outwards: users leave a
/// margin far above the rounding error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Not above the smallest value.
    pub lo: f64,
    /// Not below the largest value.
    pub hi: f64,
}

impl Interval {
    /// From `lo` to `hi`.
    pub fn new(lo: f64, hi: f64) -> Interval {
        Interval { lo, hi }
    }
}

impl Add for Interval {
    type Output = Interval;
    fn add(self, other: Interval) -> Interval {
        Interval::new(self.lo + other.lo, self.hi + other.hi)
    }
}

impl Sub for Interval {
    type Output = Interval;
    fn sub(self, other: Interval) -> Interval {
        Interval::new(self.lo - other.hi, self.hi - other.lo)
    }
}

impl Mul for Interval {
    type Output = Interval;
    fn mul(self, other: Interval) -> Interval {
        let corners = [
            self.lo * other.lo,
            self.lo * other.hi,
            self.hi * other.lo,
            self.hi * other.hi,
        ];
        Interval::new(
            corners.iter().copied().fold(f64::INFINITY, f64::min),
            corners.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        )
    }
}

impl Neg for Interval {
    type Output = Interval;
    fn neg(self) -> Interval {
        Interval::new(-self.hi, -self.lo)
    }
}

impl Add<f64> for Interval {
    type Output = Interval;
    fn add(self, other: f64) -> Interval {
        Interval::new(self.lo + other, self.hi + other)
    }
}

impl Sub<f64> for Interval {
    type Output = Interval;
    fn sub(self, other: f64) -> Interval {
        Interval::new(self.lo - other, self.hi - other)
    }
}

impl Mul<f64> for Interval {
    type Output = Interval;
    fn mul(self, other: f64) -> Interval {
        let (a, b) = (self.lo * other, self.hi * other);
        Interval::new(a.min(b), a.max(b))
    }
}

impl Number for Interval {
    fn constant(value: f64) -> Interval {
        Interval::new(value, value)
    }
    fn squared(self) -> Interval {
        let size = self.abs();
        Interval::new(size.lo * size.lo, size.hi * size.hi)
    }
    fn sqrt(self) -> Interval {
        Interval::new(self.lo.max(0.0).sqrt(), self.hi.max(0.0).sqrt())
    }
    fn abs(self) -> Interval {
        if self.lo >= 0.0 {
            self
        } else if self.hi <= 0.0 {
            -self
        } else {
            Interval::new(0.0, self.hi.max(-self.lo))
        }
    }
    fn exp(self) -> Interval {
        Interval::new(self.lo.exp(), self.hi.exp())
    }
    // The full swing: where waves matter nothing is left out by them.
    fn sin(self) -> Interval {
        Interval::new(-1.0, 1.0)
    }
    fn cos(self) -> Interval {
        Interval::new(-1.0, 1.0)
    }
    fn ratio_within(self, divisor: Interval, [lo, hi]: [f64; 2]) -> Interval {
        if divisor.lo <= 0.0 {
            return Interval::new(lo, hi);
        }
        let ratio = self * Interval::new(1.0 / divisor.hi, 1.0 / divisor.lo);
        Interval::new(ratio.lo.clamp(lo, hi), ratio.hi.clamp(lo, hi))
    }
    fn max(self, other: Interval) -> Interval {
        Interval::new(self.lo.max(other.lo), self.hi.max(other.hi))
    }
    fn covered_by(self, other: f64, cover: Interval) -> Interval {
        self + (-self + other) * cover
    }
    fn clamp(self, lo: f64, hi: f64) -> Interval {
        Interval::new(self.lo.clamp(lo, hi), self.hi.clamp(lo, hi))
    }
    // Both rise with (or fall with) each argument, so the ends are reached at the ends.
    fn smooth_min(self, other: Interval, blend: f64) -> Interval {
        Interval::new(
            smooth_min(self.lo, other.lo, blend),
            smooth_min(self.hi, other.hi, blend),
        )
    }
    fn cover(self, edge: f64) -> Interval {
        Interval::new(cover(self.hi, edge), cover(self.lo, edge))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn everything<N: Number>([x, y, z]: [N; 3]) -> N {
        let length = (x.squared() + y.squared() + z.squared()).sqrt();
        let ratio = length.ratio_within(
            (x.squared() * 4.0 + y.squared() + z.squared()).sqrt(),
            [0.5, 1.0],
        );
        let wave = (x * 0.7).sin() * (y * 0.4).cos() + (z * 0.1).exp();
        let blended = length.smooth_min(wave + 3.0, 2.0).smooth_max(x - 4.0, 1.5);
        (ratio + blended.clamp(-5.0, 5.0)) * 0.5
            + (y - 1.0).abs().max(z)
            + (length - 3.0).cover(1.0)
    }

    #[test]
    fn dual_has_the_bits_of_f64_and_intervals_hold_both() {
        let mut seed = 1u64;
        let mut next = || {
            seed = seed
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1u64 << 53) as f64 * 12.0 - 6.0
        };
        let mut kinks = 0;
        for _ in 0..2000 {
            let p = DVec3::new(next(), next(), next());
            let value = everything([p.x, p.y, p.z]);
            let dual = everything(Dual::coordinates(p));
            assert_eq!(value.to_bits(), dual.value.to_bits());
            let half = next().abs() * 0.2;
            let box_around = [p.x, p.y, p.z].map(|c| Interval::new(c - half, c + half * 0.5));
            let bounds = everything(box_around);
            assert!(
                bounds.lo - 1e-12 <= value && value <= bounds.hi + 1e-12,
                "{value} outside {bounds:?}"
            );
            let h = 1e-5;
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                let at = |p: DVec3| everything([p.x, p.y, p.z]);
                let (before, after) = (value - at(p - axis * h), at(p + axis * h) - value);
                // Beside a kink (abs, max, clamp) there is no derivative to compare with.
                if (after - before).abs() > 1e-3 * h {
                    kinks += 1;
                    continue;
                }
                // Third derivatives are below 100: h² · 100 / 6, and rounding 1e-15 / h.
                let error = ((before + after) / (2.0 * h) - dual.gradient.dot(axis)).abs();
                assert!(error < 1e-8, "{error} at {p}");
            }
        }
        assert!(kinks < 60, "{kinks} of 6000 differences cross a kink");
    }
}
