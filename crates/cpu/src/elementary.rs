//! Logarithm, exponential and power over lanes.
//!
//! The standard library's functions are calls per number and may differ between systems; these are
//! plain arithmetic, so they vectorize and give the same bits everywhere. Polynomials and argument
//! reduction are those of S. Moshier's Cephes library (`logf`, `expf`), with relative errors of a
//! few 1e-7 on the arguments that occur here.

use crate::lanes::{F32s, I32s, Mask};
use crate::levels::Level;

/// The natural logarithm of positive, normal numbers.
#[inline(always)]
fn ln<S: Level>(x: F32s<S>) -> F32s<S> {
    let bits = x.to_bits();
    // x = m · 2^e, m in [1/2, 1), then in [√½, √2) for a symmetric polynomial.
    let m = bits.and(0x007f_ffff).or(0x3f00_0000).as_bits();
    let e = (bits.shifted_down(23) - I32s::splat(126)).to_f32s();
    let low = m.lt(F32s::splat(std::f32::consts::FRAC_1_SQRT_2));
    let one = F32s::splat(1.0);
    let e = low.select(e - one, e);
    let m = low.select(m + m, m) - one;
    let square = m * m;
    let mut p = F32s::splat(7.037_683_6e-2);
    for c in [
        -1.151_461e-1,
        1.167_699_9e-1,
        -1.242_014_1e-1,
        1.424_932_3e-1,
        -1.666_805_8e-1,
        2.000_071_5e-1,
        -2.499_999_4e-1,
        3.333_333e-1,
    ] {
        p = p * m + F32s::splat(c);
    }
    // ln 2 in two parts, so that e·ln 2 keeps the small digits.
    let tail = p * m * square + e * F32s::splat(-2.121_944_4e-4) - square * F32s::splat(0.5);
    m + tail + e * F32s::splat(0.693_359_4)
}

/// e^y − 1 for y ≤ 0.
#[inline(always)]
fn exp_m1<S: Level>(y: F32s<S>) -> F32s<S> {
    // Below this e^y is less than half an ulp of 1; also keeps 2^n a normal number.
    let y = y.max(F32s::splat(-80.0));
    // Truncation rounds y/ln 2 to the nearest whole number, as y ≤ 0.
    let n = (y * F32s::splat(std::f32::consts::LOG2_E) - F32s::splat(0.5)).to_i32s();
    let nf = n.to_f32s();
    let r = y - nf * F32s::splat(0.693_359_4) - nf * F32s::splat(-2.121_944_4e-4);
    let mut p = F32s::splat(1.987_569_1e-4);
    for c in [
        1.398_199_9e-3,
        8.333_452e-3,
        4.166_579_6e-2,
        1.666_666_5e-1,
        0.5,
    ] {
        p = p * r + F32s::splat(c);
    }
    let exp_m1_of_r = r + r * r * p;
    let power = (n + I32s::splat(127)).shifted_up(23).as_bits();
    // For n = 0, where the result may be small, this is exp_m1_of_r with all its digits.
    power * exp_m1_of_r + (power - F32s::splat(1.0))
}

/// 1 − (1 − a)^e for a in [0, 1] and e > 0, with full relative precision for small a.
#[inline(always)]
pub fn opacity_of_length<S: Level>(a: F32s<S>, e: f32) -> F32s<S> {
    opacity_of_lengths(a, F32s::splat(e))
}

/// The same with an exponent of ½, the step of most pictures: a/(1 + √(1 − a)).
#[inline(always)]
pub fn opacity_of_half<S: Level>(a: F32s<S>) -> F32s<S> {
    let one = F32s::splat(1.0);
    let rest = (one - a).max(F32s::zero());
    a.over(one + rest.sqrt())
}

/// The same with an exponent per lane.
#[inline(always)]
pub fn opacity_of_lengths<S: Level>(a: F32s<S>, e: F32s<S>) -> F32s<S> {
    let one = F32s::splat(1.0);
    let rest = one - a;
    // ln(1 − a) by the quotient ln(u)/(u − 1) with the rounded u: W. Kahan's log1p.
    let small = rest.eq(one);
    let lost = small.select(one, one - rest);
    let safe = rest.max(F32s::splat(1e-8));
    let logarithm = small.select(-a, ln(safe) * a.over(lost));
    let corrected = -exp_m1(logarithm * e);
    rest.le(F32s::zero()).select(one, corrected)
}

/// Up to here a whole power is found by multiplying: at most 14 products.
const MOST_BY_MULTIPLYING: f32 = 128.0;

/// x^e for x in [0, 1] and e > 0.
#[inline(always)]
pub fn power_of_cosine<S: Level>(x: F32s<S>, e: f32) -> F32s<S> {
    if e.fract() == 0.0 && e <= MOST_BY_MULTIPLYING {
        return whole_power_of_cosine(x, e as u32);
    }
    let tiny = F32s::splat(1e-30);
    let usable: Mask<S> = tiny.lt(x);
    let logarithm = ln(x.max(tiny)).min(F32s::zero());
    let power = exp_m1(logarithm * F32s::splat(e)) + F32s::splat(1.0);
    usable.select(power, F32s::zero())
}

/// x^e for x ≥ 0 and e ≥ 0, at most 1e30; 1 for e = 0.
#[inline(always)]
pub fn power<S: Level>(x: F32s<S>, e: f32) -> F32s<S> {
    let one = F32s::splat(1.0);
    if e == 0.0 {
        return one;
    }
    let is_large = one.lt(x);
    let power = power_of_cosine(is_large.select(one.over(x), x), e);
    is_large.select(one.over(power.max(F32s::splat(1e-30))), power)
}

/// x^e for x in [0, 1] and e ≥ 0; 1 for e = 0.
#[inline(always)]
pub fn powers_of_share<S: Level>(x: F32s<S>, e: F32s<S>) -> F32s<S> {
    let (zero, one, tiny) = (F32s::zero(), F32s::splat(1.0), F32s::splat(1e-30));
    let logarithm = ln(x.max(tiny)).min(zero);
    let power = exp_of_negative(logarithm * e);
    let power = tiny.lt(x).select(power, zero);
    e.le(zero).select(one, power)
}

/// e^y for y ≤ 0.
#[inline(always)]
pub fn exp_of_negative<S: Level>(y: F32s<S>) -> F32s<S> {
    exp_m1(y) + F32s::splat(1.0)
}

/// The logarithm of x in (0, 1], 0 for what is larger.
#[inline(always)]
pub fn ln_of_share<S: Level>(x: F32s<S>) -> F32s<S> {
    ln(x.max(F32s::splat(1e-37))).min(F32s::zero())
}

/// x^e for x in [0, 1] and e ≥ 1, by squaring.
#[inline(always)]
fn whole_power_of_cosine<S: Level>(x: F32s<S>, e: u32) -> F32s<S> {
    // What would be less than about 1e-36 is 0: products below the normal numbers take long.
    let least = F32s::splat(f32::exp2(-120.0 / e as f32));
    let x = least.le(x).select(x, F32s::zero());
    let mut square = x;
    let mut power = F32s::splat(1.0);
    let mut left = e;
    loop {
        if left & 1 == 1 {
            power = power * square;
        }
        left >>= 1;
        if left == 0 {
            return power;
        }
        square = square * square;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::levels::Portable;

    fn opacity(a: f32, e: f32) -> f32 {
        opacity_of_length(F32s::<Portable>::splat(a), e).lane(0)
    }

    #[test]
    fn opacity_of_length_matches_double_precision() {
        for e in [1e-3f32, 0.1, 0.5, 0.999, 2.0, 17.5] {
            for i in 0..=20_000 {
                // Dense near both ends.
                let part = i as f32 / 20_000.0;
                for a in [part, part * 1e-4, 1.0 - part * 1e-4] {
                    let got = f64::from(opacity(a, e));
                    let want = -(f64::from(e) * (-f64::from(a)).ln_1p()).exp_m1();
                    let error = (got - want).abs();
                    assert!(
                        error <= 6e-7 * want.max(1e-30),
                        "a {a}, e {e}: {got} instead of {want}"
                    );
                    if e == 0.5 {
                        let half = f64::from(opacity_of_half(F32s::<Portable>::splat(a)).lane(0));
                        assert!(
                            (half - want).abs() <= 6e-7 * want.max(1e-30),
                            "a {a}: {half}"
                        );
                    }
                }
            }
            assert_eq!(opacity(0.0, e), 0.0);
            assert_eq!(opacity(1.0, e), 1.0);
        }
    }

    #[test]
    fn power_of_cosine_matches_double_precision() {
        for e in [0.5f32, 1.0, 2.0, 7.0, 10.0, 20.5, 32.0, 127.0, 128.0, 200.0] {
            for i in 0..=10_000 {
                let x = i as f32 / 10_000.0;
                let got = f64::from(power_of_cosine(F32s::<Portable>::splat(x), e).lane(0));
                let want = f64::from(x).powf(f64::from(e));
                assert!(
                    (got - want).abs() <= 1e-5 * want + 1e-7,
                    "{x}^{e}: {got} instead of {want}"
                );
            }
        }
    }
    #[test]
    fn powers_match_double_precision() {
        for e in [0.0f32, 0.1, 0.6, 0.8, 1.0, 3.0, 20.0] {
            for i in 0..=2_000 {
                let x = i as f32 / 100.0;
                let got = f64::from(power(F32s::<Portable>::splat(x), e).lane(0));
                let want = f64::from(x).powf(f64::from(e)).min(1e30);
                assert!(
                    (got - want).abs() <= 3e-5 * want + 1e-7,
                    "{x}^{e}: {got} instead of {want}"
                );
                let share = x / 20.0;
                let all = F32s::<Portable>::splat;
                let got = f64::from(powers_of_share(all(share), all(e)).lane(0));
                let want = f64::from(share).powf(f64::from(e));
                assert!(
                    (got - want).abs() <= 1e-5 * want + 1e-7,
                    "{share}^{e}: {got} instead of {want}"
                );
            }
        }
    }
}
