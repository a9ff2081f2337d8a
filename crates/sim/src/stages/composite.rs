//! Compositing: C += I · O · T, one accumulator per ray, and the background behind everything.

use crate::fixed_point::scaled;

/// Widths of the unit.
#[derive(Clone, Copy, Debug)]
pub struct Compositor {
    /// Bits of intensity.
    pub intensity: u32,
    /// Fraction bits of the accumulator.
    pub fraction: u32,
    /// Bits of a weight.
    pub transmittance: u32,
}

impl Compositor {
    /// The accumulator with a sample added.
    #[inline(always)]
    pub fn add(&self, accumulator: u32, weight: u32, intensity: u32) -> u32 {
        accumulator + scaled(weight, intensity, self.transmittance - self.fraction)
    }

    /// The result of a ray with what is behind it: background · T.
    pub fn finish(&self, accumulator: u32, passing: u32, background: u32) -> u32 {
        self.add(accumulator, passing, background)
    }

    /// A result as a number of 0 to 1.
    pub fn to_f32(&self, accumulator: u32) -> f32 {
        let full = f64::from((1u32 << self.intensity) - 1) * f64::from(1u32 << self.fraction);
        ((f64::from(accumulator) / full) as f32).min(1.0)
    }

    /// The word that the host reads: `intensity` bits, rounded, saturated.
    pub fn to_word(&self, accumulator: u32) -> u32 {
        let half = (1 << self.fraction) >> 1;
        ((accumulator + half) >> self.fraction).min((1 << self.intensity) - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_added_is_the_rounded_product(weight in 0u32..1 << 16, intensity in 0u32..256, before in 0u32..1 << 16) {
            let unit = Compositor { intensity: 8, fraction: 8, transmittance: 16 };
            let exact = f64::from(weight) * f64::from(intensity) / 256.0;
            let got = unit.add(before, weight, intensity) - before;
            prop_assert!((f64::from(got) - exact).abs() <= 0.5);
        }
    }

    #[test]
    fn white_before_nothing_is_white() {
        let unit = Compositor {
            intensity: 8,
            fraction: 8,
            transmittance: 16,
        };
        let c = unit.finish(0, (1 << 16) - 1, 255);
        assert_eq!(unit.to_word(c), 255);
        assert_eq!(unit.to_word(unit.add(c, 65535, 255)), 255);
        assert!((unit.to_f32(c) - 1.0).abs() < 1e-4);
    }
}
