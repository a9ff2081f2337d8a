//! How opaque a volume is, place by place: what longer steps where it is not rest on.

use super::{of_reached, values};
use crate::plan::{Classify, Composite, Fetch, Plan, Sampling};
use crate::transfer::TransferTable;
use strahl_volume::bricks::Bricks;

/// For each brick of object number `object`, x fastest: 0 if no sample inside shows anything, exactly where
/// [`Contribution::Visible`](super::Contribution::Visible) says so; otherwise a number m from 1
/// to 255 such that no sample inside it or the 26 bricks around it has an opacity of a step above m/255. `None` if
/// nothing is known of the values, or `plan` wants every lattice point.
pub fn most_opacity(plan: &Plan, object: usize, bricks: &Bricks) -> Option<Vec<u8>> {
    let known = plan.fetch == Fetch::Stored
        && plan.classify == Classify::Table
        && matches!(plan.composite, Composite::EmissionAbsorption { .. })
        && plan.modules.is_empty();
    if !known || !matches!(plan.sampling, Sampling::ByOpacity { .. }) {
        return None;
    }
    let placed = &plan.objects[object];
    let most = MostOpacity::new(&placed.table, plan.lattice.step_mm);
    let of_bricks = of_reached(bricks, plan.reconstruct, |range| {
        if range.is_empty() {
            return 0;
        }
        let (lo, hi) = values(range, plan, placed);
        most.between(lo, hi)
    });
    let mut around = largest_around(bricks.dims(), of_bricks.clone());
    for (around, own) in around.iter_mut().zip(of_bricks) {
        if own == 0 {
            *around = 0;
        }
    }
    Some(around)
}

/// The largest number of each brick and the 26 around it.
fn largest_around(dims: [usize; 3], mut numbers: Vec<u8>) -> Vec<u8> {
    let mut stride = 1;
    for edge in dims {
        let before = numbers.clone();
        let lines = numbers.chunks_exact_mut(stride * edge);
        for (line, before) in lines.zip(before.chunks_exact(stride * edge)) {
            let with = |to: &mut [u8], other: &[u8]| {
                for (to, other) in to.iter_mut().zip(other) {
                    *to = (*to).max(*other);
                }
            };
            // The next one along the axis, and the one before.
            with(line, &before[stride..]);
            with(&mut line[stride..], before);
        }
        stride *= edge;
    }
    numbers
}

/// The largest opacity of a step between two values, in constant time.
struct MostOpacity {
    lo: f32,
    entries_per_value: f32,
    /// Of 1, 2, 4 … entries from each entry on: the largest opacity in 255ths, rounded up.
    of_runs: Vec<Vec<u8>>,
}

impl MostOpacity {
    fn new(table: &TransferTable, step_mm: f64) -> MostOpacity {
        let [lo, hi] = table.domain();
        let steps = step_mm / f64::from(table.reference_mm());
        // A little more: renderers work it out in single precision.
        let of_step = |entry: &[f32; 4]| {
            let opacity = -(steps * (-f64::from(entry[3])).ln_1p()).exp_m1();
            (opacity * 255.0 * (1.0 + 1e-5)).ceil() as u8
        };
        let mut of_runs = vec![table.entries().iter().map(of_step).collect::<Vec<u8>>()];
        let mut length = 1;
        while 2 * length <= table.entries().len() {
            let last = &of_runs[of_runs.len() - 1];
            let both = last.iter().zip(&last[length..]);
            of_runs.push(both.map(|(a, b)| *a.max(b)).collect());
            length *= 2;
        }
        MostOpacity {
            lo,
            entries_per_value: (table.entries().len() - 1) as f32 / (hi - lo),
            of_runs,
        }
    }

    /// The largest of any value from `lo` to `hi`, in 255ths, rounded up.
    fn between(&self, lo: f32, hi: f32) -> u8 {
        let entries = self.of_runs[0].len();
        let position = |value: f32| {
            ((value - self.lo) * self.entries_per_value).clamp(0.0, (entries - 1) as f32)
        };
        // One entry more on either side makes up for rounding in `position`.
        let first = (position(lo) as usize).saturating_sub(1);
        let end = (position(hi) as usize + 3).min(entries);
        let runs = (end - first).ilog2() as usize;
        let of_runs = &self.of_runs[runs];
        of_runs[first].max(of_runs[end - (1 << runs)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visibility::Opaque;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn most_opacity_is_that_of_the_table(
            opacities in proptest::collection::vec(0f32..=1.0, 2..60),
            steps in 0.1f64..4.0,
            lo in -2f32..2.0,
            width in 0f32..1.0,
        ) {
            let entries = opacities.iter().map(|&o| [0.0, 0.0, 0.0, o]).collect();
            let table = TransferTable::new([-1.0, 1.0], 1.0, entries);
            let most = MostOpacity::new(&table, steps).between(lo, lo + width);
            let largest = f64::from(table.max_opacity(lo, lo + width));
            let of_step = 255.0 * (1.0 - (1.0 - largest).powf(steps));
            prop_assert!(f64::from(most) >= of_step && f64::from(most) < of_step + 1.01);
        }

        #[test]
        fn nothing_is_shown_where_skipping_says_so(
            opacities in proptest::collection::vec(
                prop_oneof![Just(0f32), Just(f32::from_bits(1)), Just(1e-9), 0f32..=1.0],
                2..60,
            ),
            steps in 0.1f64..4.0,
            lo in -2f32..2.0,
            width in 0f32..1.0,
        ) {
            let entries = opacities.iter().map(|&o| [0.0, 0.0, 0.0, o]).collect();
            let table = TransferTable::new([-1.0, 1.0], 1.0, entries);
            let most = MostOpacity::new(&table, steps).between(lo, lo + width);
            prop_assert_eq!(most > 0, Opaque::new(&table).any(lo, lo + width));
        }

        #[test]
        fn around_are_the_bricks_that_touch(
            dims in proptest::array::uniform3(1usize..6),
            seed in any::<u64>(),
        ) {
            let number = dims.iter().product::<usize>();
            let numbers: Vec<u8> = (0..number as u64)
                .map(|i| ((i + 1).wrapping_mul(seed | 1) >> 32) as u8)
                .collect();
            let largest = largest_around(dims, numbers.clone());
            let place = |i: usize| [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])];
            for (i, got) in largest.iter().enumerate() {
                let touches = |j: &usize| (0..3).all(|axis| place(i)[axis].abs_diff(place(*j)[axis]) <= 1);
                let want = (0..number).filter(touches).map(|j| numbers[j]).max();
                prop_assert_eq!(Some(*got), want);
            }
        }
    }
}
