//! Trilinear interpolation and Knittel's gradient from the same partial results: 15 interpolations and three
//! subtractions (document §6.5; the printed E5 mixes x and 1 − y, here it is lerp(S6, S7, x)).

use crate::fixed_point::lerp;

/// Widths of the unit.
#[derive(Clone, Copy, Debug)]
pub struct Interpolator {
    /// Fraction bits of x, y, z.
    pub fraction: u32,
    /// Fraction bits kept below those of the data.
    pub guard: u32,
}

impl Interpolator {
    /// Value (without guard bits) and gradient (with them) of the cell whose modules deliver `modules`. `fraction` comes
    /// from the swap muxes, so that module A stands for S0; where `lowest` is 1 the sign of the gradient turns.
    #[inline(always)]
    pub fn interpolate(
        self,
        modules: [i32; 8],
        [x, y, z]: [i32; 3],
        lowest: [i32; 3],
    ) -> (u32, [i32; 3]) {
        let n = self.fraction;
        let s = modules.map(|word| word << self.guard);
        let e0 = lerp(s[0], s[1], x, n);
        let e1 = lerp(s[2], s[3], x, n);
        let e4 = lerp(s[4], s[5], x, n);
        let e5 = lerp(s[6], s[7], x, n);
        let e2 = lerp(s[0], s[2], y, n);
        let e3 = lerp(s[1], s[3], y, n);
        let e6 = lerp(s[4], s[6], y, n);
        let e7 = lerp(s[5], s[7], y, n);
        let f0 = lerp(e2, e6, z, n);
        let f1 = lerp(e3, e7, z, n);
        let f2 = lerp(e0, e4, z, n);
        let f3 = lerp(e1, e5, z, n);
        let f4 = lerp(e2, e3, x, n);
        let f5 = lerp(e6, e7, x, n);
        let value = lerp(f4, f5, z, n);
        let half = (1 << self.guard) >> 1;
        let sign = |difference: i32, lowest: i32| (difference ^ -lowest) + lowest;
        let gradient = [
            sign(f1 - f0, lowest[0]),
            sign(f3 - f2, lowest[1]),
            sign(f5 - f4, lowest[2]),
        ];
        (((value + half) >> self.guard) as u32, gradient)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stages::address::AddressGenerator;
    use crate::stages::fetch::Voxels;
    use proptest::prelude::*;

    proptest! {
        /// The unit against trilinear interpolation of real numbers, at any position, with the bound that the words allow:
        /// every value passes three roundings, every gradient component two per operand.
        #[test]
        fn value_and_gradient_are_those_of_real_numbers(
            words in prop::collection::vec(0u16..256, 64), p in prop::array::uniform3(0i32..3 * 4096 - 1), guard in 0u32..8,
        ) {
            let voxels = Voxels::new([4, 4, 4], words);
            let generator = AddressGenerator::new(12, 8);
            let address = generator.split(p);
            let modules = voxels.modules(address.cell, address.lowest);
            let unit = Interpolator { fraction: 8, guard };
            let (value, gradient) = unit.interpolate(modules, address.fraction, address.lowest);

            let t = p.map(|p| f64::from((p & 4095) >> 4) / 256.0);
            let corner = |i: usize| f64::from(voxels.word([
                address.cell[0] + (i & 1) as i32,
                address.cell[1] + (i >> 1 & 1) as i32,
                address.cell[2] + (i >> 2) as i32,
            ]));
            let weight = |i: usize, axis: usize| if i >> axis & 1 == 1 { t[axis] } else { 1.0 - t[axis] };
            let exact: f64 = (0..8).map(|i| corner(i) * weight(i, 0) * weight(i, 1) * weight(i, 2)).sum();
            let step = 0.5f64.powi(guard as i32);
            prop_assert!((f64::from(value) - exact).abs() <= 1.5 * step + 0.5);
            for (axis, component) in gradient.into_iter().enumerate() {
                let others = [(axis + 1) % 3, (axis + 2) % 3];
                let exact: f64 = (0..8).map(|i| {
                    let sign = if i >> axis & 1 == 1 { 1.0 } else { -1.0 };
                    sign * corner(i) * weight(i, others[0]) * weight(i, others[1])
                }).sum();
                let got = f64::from(component) * step;
                prop_assert!((got - exact).abs() <= 2.0 * step, "axis {}: {} for {}", axis, got, exact);
            }
        }

        /// Swapping fractions is the same as sorting the data: bit for bit.
        #[test]
        fn the_swap_of_fractions_replaces_muxes_on_the_data(
            corners in prop::array::uniform8(0i32..256), x in prop::array::uniform3(0i32..=256), lowest in prop::array::uniform3(0i32..2),
        ) {
            let unit = Interpolator { fraction: 8, guard: 0 };
            let plain = unit.interpolate(corners, x, [0; 3]);
            let which = (lowest[0] | lowest[1] << 1 | lowest[2] << 2) as usize;
            let modules = std::array::from_fn(|m| corners[m ^ which]);
            let swapped = std::array::from_fn(|axis| if lowest[axis] == 1 { 256 - x[axis] } else { x[axis] });
            prop_assert_eq!(unit.interpolate(modules, swapped, lowest), plain);
        }
    }
}
