use super::surface::Surface;
use crate::lanes::{F32s, I32s, LANES, Mask, row_pairs, words};
use crate::levels::{Level, inlined, vectorized};
use strahl_scene::transfer::TransferTable;

/// A one-dimensional transfer function: the same arithmetic as [`TransferTable::at`], per lane.
pub struct Table<'p> {
    entries: &'p [[f32; 4]],
    /// Of a function of value and gradient magnitude.
    rows: &'p [[f32; 4]],
    /// Of the entries: what is asked for alone takes a quarter of the memory.
    opacities: Vec<f32>,
    lo: f32,
    entries_per_value: f32,
    /// The number of the last entry.
    last: f32,
}

impl<'p> Table<'p> {
    /// The function of `table`.
    pub fn new(table: &'p TransferTable) -> Table<'p> {
        let [lo, hi] = table.domain();
        let last = (table.entries().len() - 1) as f32;
        Table {
            entries: table.entries(),
            rows: table.rows(),
            opacities: table.entries().iter().map(|entry| entry[3]).collect(),
            lo,
            entries_per_value: last / (hi - lo),
            last,
        }
    }

    /// Where the first entry lies, entries per unit of value, and the number of the last entry.
    pub fn domain(&self) -> (f32, f32, f32) {
        (self.lo, self.entries_per_value, self.last)
    }

    /// The last entry at or below `value`, and the part of the way to the next one.
    #[inline(always)]
    fn place<S: Level>(&self, value: F32s<S>) -> (I32s<S>, F32s<S>) {
        let lo = F32s::splat(self.lo);
        let position = ((value - lo) * F32s::splat(self.entries_per_value))
            .max(F32s::zero())
            .min(F32s::splat(self.last));
        let index = position.to_i32s().min(self.entries.len() as i32 - 2);
        (index, position - index.to_f32s())
    }

    /// Color and opacity of `value`; transparent black where it is NaN.
    #[inline(always)]
    pub fn at<S: Level>(&self, value: F32s<S>) -> Surface<S> {
        let (index, part) = self.place(value);
        // SAFETY: a table has two entries at least, and the index is that of the last but one at most:
        // `max` and `min` leave no other value, not even for NaN.
        let [below, above] = unsafe { row_pairs(self.entries, index) };
        let is_number: Mask<S> = value.eq(value);
        let channel = inlined(
            #[inline(always)]
            |c: usize| {
                let value = below[c].lerp(above[c], part);
                is_number.select(value, F32s::zero())
            },
        );
        Surface {
            color: [channel(0), channel(1), channel(2)],
            opacity: channel(3),
        }
    }

    /// The same, compiled once: for where it is asked for often.
    #[inline(never)]
    pub fn at_apart<S: Level>(&self, value: F32s<S>) -> Surface<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || self.at(value),
        )
    }

    /// Color and opacity of a value and the gradient magnitude that has the `share` of the last row's, where `asked`; nothing
    /// elsewhere. Entries count by their opacity.
    #[inline(never)]
    pub fn at_2d<S: Level>(&self, value: F32s<S>, share: F32s<S>, asked: Mask<S>) -> Surface<S> {
        let columns = self.entries.len();
        let last_row = self.rows.len() / columns - 1;
        let last = F32s::splat(last_row as f32);
        let row = (share * last).max(F32s::zero()).min(last).to_array();
        let (column, part) = self.place(value);
        let (column, part) = (column.to_array(), part.to_array());
        let asked = asked.select(F32s::splat(1.0), F32s::zero()).to_array();
        let mut found = [[0.0f32; LANES]; 4];
        for i in (0..LANES).filter(|i| asked[*i] > 0.0) {
            let (x, y) = (column[i] as usize, (row[i] as usize).min(last_row - 1));
            let (right, down) = (part[i], row[i] - y as f32);
            let mut sum = [0.0f32; 4];
            for corner in 0..4 {
                let side = [1.0 - right, right][corner & 1] * [1.0 - down, down][corner >> 1];
                let [r, g, b, a] = self.rows[(y + (corner >> 1)) * columns + x + (corner & 1)];
                let weight = side * a;
                for (sum, own) in sum.iter_mut().zip([r, g, b, 1.0]) {
                    *sum += weight * own;
                }
            }
            let [r, g, b, a] = sum;
            if a > 0.0 {
                for (found, own) in found.iter_mut().zip([r / a, g / a, b / a, a]) {
                    found[i] = own;
                }
            }
        }
        let [r, g, b, a] = found.map(F32s::from_array);
        Surface {
            color: [r, g, b],
            opacity: a,
        }
    }

    /// The opacity of `value` alone.
    #[inline(always)]
    pub fn opacity_at<S: Level>(&self, value: F32s<S>) -> F32s<S> {
        let (index, part) = self.place(value);
        let bytes: &[u8] = bytemuck::cast_slice(&self.opacities);
        let offset = index.shifted_up(2);
        // SAFETY: as in `at`.
        let (below, above) = unsafe {
            let below = words(bytes, offset).as_bits();
            (below, words(bytes, offset + I32s::splat(4)).as_bits())
        };
        value
            .eq(value)
            .select(below.lerp(above, part), F32s::zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::levels::Portable;
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
                let got = Table::new(&table).at(F32s::<Portable>::splat(value));
                let got = [got.color[0], got.color[1], got.color[2], got.opacity].map(|c| c.lane(LANES - 1));
                prop_assert_eq!(got, table.at(value));
                let opacity = Table::new(&table).opacity_at(F32s::<Portable>::splat(value));
                prop_assert_eq!(opacity.lane(LANES - 1), got[3]);
            }
        }
    }
}
