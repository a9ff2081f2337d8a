//! Absorption: how much light still passes, one word per ray, before shading so that a ray ends early.

use crate::fixed_point::{scaled, whole};

/// Widths and bound of the unit.
#[derive(Clone, Copy, Debug)]
pub struct Absorber {
    /// Bits of opacity.
    pub data: u32,
    /// Bits of T.
    pub transmittance: u32,
    /// A ray ends when T is below this.
    pub threshold: u32,
}

impl Absorber {
    /// T of a ray that nothing has absorbed.
    pub fn full(&self) -> u32 {
        (1 << self.transmittance) - 1
    }

    /// Opacity · T, T behind the sample, and whether the ray ends.
    #[inline(always)]
    pub fn absorb(&self, opacity: u32, passing: u32) -> (u32, u32, bool) {
        let weight = scaled(passing, whole(opacity, self.data), self.data);
        let behind = passing - weight;
        (weight, behind, behind < self.threshold)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn light_is_the_product_of_what_passes(opacities in prop::collection::vec(0u32..256, 0..40)) {
            let unit = Absorber { data: 8, transmittance: 16, threshold: 3277 };
            let mut passing = unit.full();
            let mut exact = 1.0;
            let mut added = 0;
            for (i, &opacity) in opacities.iter().enumerate() {
                let (weight, behind, ends) = unit.absorb(opacity, passing);
                added += weight;
                passing = behind;
                exact *= 1.0 - f64::from(whole(opacity, 8)) / 256.0;
                // Half a step per sample, carried on.
                let bound = 0.5 * (i + 1) as f64 + 1.0;
                prop_assert!((f64::from(passing) - exact * 65535.0).abs() <= bound);
                prop_assert_eq!(ends, passing < 3277);
                // No light is made or lost.
                prop_assert_eq!(passing + added, unit.full());
            }
        }
    }
}
