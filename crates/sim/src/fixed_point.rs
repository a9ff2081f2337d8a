//! Fixed-point arithmetic of the data path: integers with an understood number of fraction bits.

/// a + (b − a) · x, rounded to nearest; `x` has `fraction` fraction bits and lies in 0 ..= 1. The result lies between
/// a and b, and is exactly the same with a and b swapped and 1 − x: on that the swap of fractions rests.
#[inline(always)]
pub fn lerp(a: i32, b: i32, x: i32, fraction: u32) -> i32 {
    a + (((b - a) * x + (1 << (fraction - 1))) >> fraction)
}

/// Makes all ones mean 1: 0 ..= 2^bits − 1 → 0 ..= 2^bits, by adding the top bit.
#[inline(always)]
pub fn whole(value: u32, bits: u32) -> u32 {
    value + (value >> (bits - 1))
}

/// a · b / 2^bits, rounded to nearest.
#[inline(always)]
pub fn scaled(a: u32, b: u32, bits: u32) -> u32 {
    ((u64::from(a) * u64::from(b) + (1 << bits >> 1)) >> bits) as u32
}

/// The whole part of the square root of a number below 2^53: the root of k² − 1 is less than k by more than double
/// precision rounds.
#[inline(always)]
pub fn integer_sqrt(value: u64) -> u64 {
    debug_assert!(value < 1 << 53);
    (value as i64 as f64).sqrt() as i64 as u64
}

/// `value` with `fraction` fraction bits, rounded to nearest; none if it needs more than `integer` integer bits.
pub fn from_f64(value: f64, integer: u32, fraction: u32) -> Option<i32> {
    let scaled = (value * f64::from(1u32 << fraction)).round();
    let bound = f64::from(1u32 << (integer + fraction));
    (scaled.is_finite() && scaled >= -bound && scaled < bound).then_some(scaled as i32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_lerp_is_the_rounded_number_and_swaps_exactly(
            a in 0i32..1 << 16, b in 0i32..1 << 16, fraction in 1u32..13, x in 0.0f64..=1.0,
        ) {
            let one = 1 << fraction;
            let x = (x * f64::from(one)) as i32;
            let exact = f64::from(a) + f64::from(b - a) * f64::from(x) / f64::from(one);
            let got = lerp(a, b, x, fraction);
            prop_assert!((f64::from(got) - exact).abs() <= 0.5);
            prop_assert!(got >= a.min(b) && got <= a.max(b));
            prop_assert_eq!(got, lerp(b, a, one - x, fraction));
        }

        #[test]
        fn products_are_rounded_numbers(a in 0u32..1 << 20, b in 0u32..1 << 12, bits in 1u32..13) {
            let exact = f64::from(a) * f64::from(b) / f64::from(1 << bits);
            prop_assume!(exact < f64::from(u32::MAX));
            prop_assert!((f64::from(scaled(a, b, bits)) - exact).abs() <= 0.5);
        }
    }

    #[test]
    fn roots_are_whole_parts() {
        for k in (1..1u64 << 26)
            .step_by(99_991)
            .chain([1, 2, 3, (1 << 26) - 1])
        {
            for value in [k * k - 1, k * k, k * k + 1] {
                assert_eq!(integer_sqrt(value), value.isqrt());
            }
        }
    }

    #[test]
    fn all_ones_mean_one() {
        assert_eq!(whole(255, 8), 256);
        assert_eq!(whole(0, 8), 0);
        assert_eq!(whole(127, 8), 127);
        assert_eq!(from_f64(1023.99999, 10, 12), None);
        assert_eq!(from_f64(-1024.0, 10, 12), Some(-(1 << 22)));
        assert_eq!(from_f64(0.5, 10, 12), Some(1 << 11));
        assert_eq!(from_f64(f64::NAN, 10, 12), None);
    }
}
