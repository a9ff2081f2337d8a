use super::Surface;
use crate::lanes::{F32s, LANES, Mask};
use strahl_scene::transfer::TransferTable;

/// A one-dimensional transfer function: the same arithmetic as [`TransferTable::at`], per lane.
pub struct Table<'p> {
    entries: &'p [[f32; 4]],
    lo: f32,
    entries_per_value: f32,
}

impl<'p> Table<'p> {
    /// The function of `table`.
    pub fn new(table: &'p TransferTable) -> Table<'p> {
        let [lo, hi] = table.domain();
        Table {
            entries: table.entries(),
            lo,
            entries_per_value: (table.entries().len() - 1) as f32 / (hi - lo),
        }
    }

    /// Colour and opacity of `value`; transparent black where it is NaN.
    #[inline(always)]
    pub fn at(&self, value: F32s) -> Surface {
        let last = (self.entries.len() - 1) as f32;
        let position = ((value - F32s::splat(self.lo)) * F32s::splat(self.entries_per_value))
            .max(F32s::ZERO)
            .min(F32s::splat(last));
        let index = position.to_i32s().min(self.entries.len() as i32 - 2);
        let part = position - index.to_f32s();
        let mut lower = [F32s::ZERO; 4];
        let mut upper = [F32s::ZERO; 4];
        for lane in 0..LANES {
            let at = index.0[lane] as usize;
            let [a, b] = [self.entries[at], self.entries[at + 1]];
            for channel in 0..4 {
                lower[channel].0[lane] = a[channel];
                upper[channel].0[lane] = b[channel];
            }
        }
        let is_number: Mask = value.eq(value);
        let channel = |c: usize| is_number.select(lower[c].lerp(upper[c], part), F32s::ZERO);
        Surface {
            colour: [channel(0), channel(1), channel(2)],
            opacity: channel(3),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn gives_the_same_bits_as_the_defining_form(
            entries in proptest::collection::vec(proptest::array::uniform4(0f32..1.0), 2..40),
            lo in -1e4f32..1e4,
            width in 1e-2f32..1e4,
            share in -0.5f32..1.5,
        ) {
            let table = TransferTable::new([lo, lo + width], 1.0, entries);
            for value in [lo + width * share, f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                let got = Table::new(&table).at(F32s::splat(value));
                let got = [got.colour[0], got.colour[1], got.colour[2], got.opacity].map(|c| c.0[LANES - 1]);
                prop_assert_eq!(got, table.at(value));
            }
        }
    }
}
