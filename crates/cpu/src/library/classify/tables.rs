use super::surface::Surface;
use super::transfer::Table;
use crate::lanes::{F32s, I32s, LANES, Mask, row_pairs, words_inside};
use crate::levels::{Level, inlined};
use strahl_scene::transfer::TransferTable;

/// One-dimensional transfer functions side by side, so that the samples of a packet need not have the same one: the
/// arithmetic of [`Table`], per lane. Number 0 shows nothing.
pub struct Tables {
    entries: Vec<[f32; 4]>,
    opacities: Vec<f32>,
    /// As [`Table`] has them, of the only one; where `are_alike`, of all.
    lo: [f32; LANES],
    entries_per_value: [f32; LANES],
    last: [f32; LANES],
    /// The number of each one's first entry.
    first: [f32; LANES],
    are_alike: bool,
    /// All show nothing of values that do not lie between these.
    shown: [f32; 2],
}

impl Tables {
    /// The most functions.
    pub const MOST: usize = LANES - 1;

    /// Those of `tables`, from number 1 on; `None` if there are too many.
    pub fn new(tables: &[&TransferTable]) -> Option<Tables> {
        let (Some(one), true) = (tables.first(), tables.len() <= Tables::MOST) else {
            return None;
        };
        let shape = |table: &TransferTable| (table.domain(), table.entries().len());
        let are_alike = tables.iter().all(|table| shape(table) == shape(one));
        let mut all = Tables {
            entries: vec![[0.0; 4]; one.entries().len()],
            opacities: Vec::new(),
            lo: [0.0; LANES],
            entries_per_value: [0.0; LANES],
            last: [1.0; LANES],
            first: [0.0; LANES],
            are_alike,
            shown: [f32::INFINITY, f32::NEG_INFINITY],
        };
        for (i, table) in [one].into_iter().chain(tables).enumerate() {
            let own = Table::new(table);
            (all.lo[i], all.entries_per_value[i], all.last[i]) = own.domain();
            if i > 0 {
                all.first[i] = all.entries.len() as f32;
                all.entries.extend(table.entries());
                let [low, high] = shown(table);
                all.shown = [all.shown[0].min(low), all.shown[1].max(high)];
            }
        }
        all.opacities = all.entries.iter().map(|entry| entry[3]).collect();
        Some(all)
    }

    /// The last entry at or below each `value` of the functions with the numbers `of`, and the part of the way to the next.
    #[inline(always)]
    fn place<S: Level>(&self, value: F32s<S>, of: F32s<S>) -> (I32s<S>, F32s<S>) {
        let of: I32s<S> = of.to_i32s();
        let number = inlined(
            #[inline(always)]
            |numbers: &[f32; LANES]| match self.are_alike {
                true => F32s::splat(numbers[0]),
                false => F32s::picked(numbers, of),
            },
        );
        let (lo, last) = (number(&self.lo), number(&self.last));
        let position = ((value - lo) * number(&self.entries_per_value))
            .max(F32s::zero())
            .min(last);
        let index = position.floor().min(last - F32s::splat(1.0));
        let first = F32s::picked(&self.first, of);
        ((first + index).to_i32s(), position - index)
    }

    /// Color and opacity of each `value` by the function with its number `of`; transparent black where it is NaN.
    #[inline(always)]
    pub fn at<S: Level>(&self, value: F32s<S>, of: F32s<S>) -> Surface<S> {
        let (index, part) = self.place(value, of);
        // SAFETY: numbers are picked by their lowest bits from those of functions and zeros: wherever `of` points, `place`
        // gives an entry that another one of its function follows, or the first of all.
        let [below, above] = unsafe { row_pairs(&self.entries, index) };
        let is_number = value.eq(value);
        let channel = inlined(
            #[inline(always)]
            |c: usize| is_number.select(below[c].lerp(above[c], part), F32s::zero()),
        );
        Surface {
            color: [channel(0), channel(1), channel(2)],
            opacity: channel(3),
        }
    }

    /// The opacity alone.
    #[inline(always)]
    pub fn opacity_at<S: Level>(&self, value: F32s<S>, of: F32s<S>) -> F32s<S> {
        let (index, part) = self.place(value, of);
        opacity_between(&self.opacities, index, value, part)
    }

    /// Where some of the functions may show a finite `value`.
    #[inline(always)]
    pub fn may_show<S: Level>(&self, value: F32s<S>) -> Mask<S> {
        let [low, high] = self.shown.map(F32s::splat);
        low.lt(value) & value.lt(high)
    }
}

/// Of values that do not lie between these `table` shows nothing.
fn shown(table: &TransferTable) -> [f32; 2] {
    let entries = table.entries();
    let is_seen = |entry: &[f32; 4]| entry[3] > 0.0;
    let (Some(first), Some(last)) = (
        entries.iter().position(is_seen),
        entries.iter().rposition(is_seen),
    ) else {
        return [f32::INFINITY, f32::NEG_INFINITY];
    };
    let [lo, hi] = table.domain().map(f64::from);
    // A little more than the way to the entry beside them, as places are rounded, and the bounds themselves are.
    let place = |entry: f64| lo + (hi - lo) * entry / (entries.len() - 1) as f64;
    let low = first.checked_sub(1).map(|before| {
        let low = place(before as f64 - 0.01) as f32;
        low.next_down().next_down()
    });
    let high = (last + 1 < entries.len()).then(|| {
        let high = place(last as f64 + 1.01) as f32;
        high.next_up().next_up()
    });
    [
        low.unwrap_or(f32::NEG_INFINITY),
        high.unwrap_or(f32::INFINITY),
    ]
}

#[inline(always)]
fn opacity_between<S: Level>(
    opacities: &[f32],
    index: I32s<S>,
    value: F32s<S>,
    part: F32s<S>,
) -> F32s<S> {
    let bytes: &[u8] = bytemuck::cast_slice(opacities);
    let offset = index.shifted_up(2);
    let below = words_inside(bytes, offset).as_bits();
    let above = words_inside(bytes, offset + I32s::splat(4)).as_bits();
    value
        .eq(value)
        .select(below.lerp(above, part), F32s::zero())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::levels::Portable;
    use proptest::prelude::*;

    /// Functions with random entries: of one domain and length, or each of its own.
    fn tables(are_alike: bool) -> impl Strategy<Value = Vec<TransferTable>> {
        let entries = |length: std::ops::Range<usize>| {
            proptest::collection::vec(proptest::array::uniform4(0f32..1.0), length)
        };
        let alike = proptest::collection::vec(entries(7..8), 1..5);
        let unlike = proptest::collection::vec(entries(2..40), 1..5);
        let lists = if are_alike {
            alike.boxed()
        } else {
            unlike.boxed()
        };
        lists.prop_map(move |lists| {
            let of = |(i, entries): (usize, Vec<[f32; 4]>)| {
                let lo = if are_alike {
                    -3.5
                } else {
                    -3.5 - 10.0 * i as f32
                };
                TransferTable::new([lo, 20.25], 1.0, entries)
            };
            lists.into_iter().enumerate().map(of).collect()
        })
    }

    proptest! {
        #[test]
        fn each_gives_what_it_gives_alone(
            alike in tables(true),
            unlike in tables(false),
            value in -50f32..30.0,
            hidden in 0usize..6,
        ) {
            for mut tables in [alike, unlike] {
                // Some show nothing at their ends.
                for table in &mut tables {
                    let mut entries = table.entries().to_vec();
                    let number = entries.len();
                    let ends = (0..hidden).chain(number.saturating_sub(hidden)..number);
                    ends.filter(|i| *i < number).for_each(|i| entries[i][3] = 0.0);
                    *table = TransferTable::new(table.domain(), 1.0, entries);
                }
                let all = Tables::new(&tables.iter().collect::<Vec<_>>()).unwrap();
                for value in [value, f32::NAN, f32::INFINITY, -f32::INFINITY] {
                    let value = F32s::<Portable>::splat(value);
                    for (i, table) in tables.iter().enumerate() {
                        let alone = Table::new(table).at(value);
                        let of = F32s::splat(1.0 + i as f32);
                        let found = all.at(value, of);
                        for c in 0..3 {
                            prop_assert_eq!(found.color[c].lane(5), alone.color[c].lane(5));
                        }
                        prop_assert_eq!(found.opacity.lane(5), alone.opacity.lane(5));
                        prop_assert_eq!(all.opacity_at(value, of).lane(5), alone.opacity.lane(5));
                        let is_seen = value.lane(5).is_finite() && alone.opacity.lane(5) > 0.0;
                        prop_assert!(all.may_show(value).any() || !is_seen);
                    }
                    prop_assert_eq!(all.opacity_at(value, F32s::zero()).lane(5), 0.0);
                }
            }
        }
    }

    #[test]
    fn large_values_that_lie_close_are_not_missed() {
        // Between the entries lies a tenth; numbers of this size are 1/128 apart.
        let mut entries = vec![[0.0; 4]; 4099];
        for start in 1..1500 {
            entries
                .iter_mut()
                .take(start)
                .for_each(|entry| entry[3] = 0.0);
            entries
                .iter_mut()
                .skip(start)
                .for_each(|entry| entry[3] = 1.0);
            let table = TransferTable::new([99_999.85, 100_409.65], 1.0, entries.clone());
            let all = Tables::new(&[&table]).unwrap();
            let middle = 99_999.85 + 0.1 * start as f32;
            let mut value = middle - 0.3;
            while value < middle + 0.1 {
                let value_here = F32s::<Portable>::splat(value);
                let opacity = all.opacity_at(value_here, F32s::splat(1.0)).lane(0);
                assert!(
                    opacity == 0.0 || all.may_show(value_here).any(),
                    "{start} {value}"
                );
                value = value.next_up();
            }
        }
    }

    #[test]
    fn there_may_be_too_many() {
        let table = TransferTable::new([0.0, 1.0], 1.0, vec![[0.0; 4]; 2]);
        assert!(Tables::new(&[&table; Tables::MOST]).is_some());
        assert!(Tables::new(&[&table; Tables::MOST + 1]).is_none());
        assert!(Tables::new(&[]).is_none());
    }
}
