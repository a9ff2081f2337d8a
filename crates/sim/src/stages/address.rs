//! Address generation: P ← P + Δ · d, and what of P goes where (document §6.3).

/// Parts of a position, for memory and interpolator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Address {
    /// The voxel S0: whole part of the position.
    pub cell: [i32; 3],
    /// The upper bits of the fraction, after the swap muxes: 1 − fraction where the lowest bit of `cell` is 1.
    pub fraction: [i32; 3],
    /// The lowest bits of `cell`: which module holds S0.
    pub lowest: [i32; 3],
}

/// What of a position goes where.
#[derive(Clone, Copy, Debug)]
pub struct AddressGenerator {
    position_fraction: u32,
    fraction: u32,
}

impl AddressGenerator {
    /// For these widths.
    pub fn new(position_fraction: u32, fraction: u32) -> AddressGenerator {
        AddressGenerator {
            position_fraction,
            fraction,
        }
    }

    /// The voxel S0 of a position.
    #[inline(always)]
    pub fn cell(&self, position: [i32; 3]) -> [i32; 3] {
        position.map(|p| p >> self.position_fraction)
    }

    /// The parts of a position.
    #[inline(always)]
    pub fn split(&self, position: [i32; 3]) -> Address {
        let cell = self.cell(position);
        let lowest = cell.map(|c| c & 1);
        let one = 1 << self.fraction;
        let mut fraction = [0; 3];
        for axis in 0..3 {
            let x = (position[axis] >> (self.position_fraction - self.fraction)) & (one - 1);
            fraction[axis] = if lowest[axis] == 1 { one - x } else { x };
        }
        Address {
            cell,
            fraction,
            lowest,
        }
    }

    /// P + Δ · d.
    #[inline(always)]
    pub fn advance(position: [i32; 3], step: [i32; 3], d: u32) -> [i32; 3] {
        let d = d as i32;
        [
            position[0].wrapping_add(step[0].wrapping_mul(d)),
            position[1].wrapping_add(step[1].wrapping_mul(d)),
            position[2].wrapping_add(step[2].wrapping_mul(d)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn parts_are_those_of_the_real_number(p in -(1i32 << 22)..1 << 22, step in -(1i32 << 14)..1 << 14, d in 0u32..100) {
            let unit = AddressGenerator::new(12, 8);
            let address = unit.split([p, 0, 0]);
            let real = f64::from(p) / 4096.0;
            prop_assert_eq!(f64::from(address.cell[0]), real.floor());
            let rest = ((real - real.floor()) * 256.0).floor();
            let expected = if address.cell[0].rem_euclid(2) == 1 { 256.0 - rest } else { rest };
            prop_assert_eq!(f64::from(address.fraction[0]), expected);
            let next = AddressGenerator::advance([p, 0, 0], [step, 0, 0], d)[0];
            prop_assert_eq!(i64::from(next), i64::from(p) + i64::from(step) * i64::from(d));
        }
    }
}
