//! Where the transfer function hardly changes: what leaving out lattice points within an error rests on.

use super::{of_reached, rescale_of, values};
use crate::plan::{Classify, Fetch, Illustrate, Plan, Sampling, Shade};
use crate::transfer::TransferTable;
use std::collections::VecDeque;
use strahl_volume::bricks::Bricks;
use strahl_volume::{Cancelled, Control};

/// For each brick of layer number `layer`, x fastest: 0, or 1 + e if the aligned cube of 2^e bricks along each edge
/// that it lies in, and no larger one, is even: inside it one sample can stand for any other. `None` if nothing is
/// known of the values, or `plan` wants every lattice point.
///
/// Let a be the opacities of a step and c the colors that the table gives to the values of the cube. It is even if
/// (max a − min a)/min a plus the largest max c − min c of the three channels is at most `error`, or if all a are 0.
/// Then a sample with opacity a₁ in place of one with opacity a, seen through a transmittance T, changes the pixel by
/// T·(|a₁ − a|·|c − C| + a₁·|c₁ − c|) ≤ T·a₁·error per channel, C being what lies behind; and the sum of all T·a₁ of
/// a ray is its opacity, at most 1. So no channel of a pixel changes by more than `error` (beside what rounding does,
/// and rays that end early: they may leave out another remainder). Colors and background are at most 1 for that.
///
/// Voxels without a value are not in the ranges of bricks: a volume with any has no even cubes.
///
/// # Errors
/// `control` was cancelled.
pub fn even_cubes(
    plan: &Plan,
    layer: usize,
    bricks: &Bricks,
    control: &Control,
) -> Result<Option<Vec<u8>>, Cancelled> {
    let Sampling::Adaptive { error } = plan.sampling else {
        return Ok(None);
    };
    let (field, technique) = (plan.field_of(layer), plan.technique_of(layer));
    let known = field.fetch == Fetch::Stored
        && technique.classify == Classify::Table
        && technique.shade == Shade::Unlit
        && technique.illustrate == Illustrate::Plain
        && plan.modules.is_empty();
    if !known {
        return Ok(None);
    }
    let even = Evenness::new(&technique.table, plan.lattice.step_mm, f64::from(error));
    let mut dims = bricks.dims();
    let values = |range| values(range, rescale_of(field));
    let mut ranges = of_reached(bricks, field.reconstruct, values, control)?;
    let mut cubes = vec![0; ranges.len()];
    for e in 0..8 {
        control.check()?;
        let mut any = false;
        let is_even: Vec<bool> = ranges.iter().map(|&(lo, hi)| even.holds(lo, hi)).collect();
        let [nx, ny, _] = bricks.dims();
        for (row, cubes) in cubes.chunks_exact_mut(nx).enumerate() {
            let (y, z) = (row % ny, row / ny);
            let start = dims[0] * ((y >> e) + dims[1] * (z >> e));
            for (x, cube) in cubes.iter_mut().enumerate() {
                if is_even[start + (x >> e)] {
                    (*cube, any) = (1 + e, true);
                }
            }
        }
        if !any || dims == [1; 3] {
            break;
        }
        (dims, ranges) = coarser(dims, &ranges);
    }
    Ok(Some(cubes))
}

/// The ranges of cubes of 2³.
fn coarser(dims: [usize; 3], ranges: &[(f32, f32)]) -> ([usize; 3], Vec<(f32, f32)>) {
    let half = dims.map(|n| n.div_ceil(2));
    let mut joined = vec![(f32::INFINITY, f32::NEG_INFINITY); half.iter().product()];
    for (row, ranges) in ranges.chunks_exact(dims[0]).enumerate() {
        let (y, z) = (row % dims[1] / 2, row / dims[1] / 2);
        let start = half[0] * (y + half[1] * z);
        for (joined, ranges) in joined[start..].iter_mut().zip(ranges.chunks(2)) {
            for range in ranges {
                *joined = (joined.0.min(range.0), joined.1.max(range.1));
            }
        }
    }
    (half, joined)
}

/// Whether a table hardly changes over an interval of values.
struct Evenness {
    lo: f32,
    entries_per_value: f32,
    /// For each entry the first one from which on the table hardly changes up to it.
    from: Vec<u32>,
}

impl Evenness {
    fn new(table: &TransferTable, step_mm: f64, error: f64) -> Evenness {
        let [lo, hi] = table.domain();
        let steps = step_mm / f64::from(table.reference_mm());
        let mut spread = [const { Spread::new() }; 4];
        let mut first = 0;
        let mut from = Vec::with_capacity(table.entries().len());
        for (i, entry) in table.entries().iter().enumerate() {
            let [r, g, b, a] = entry.map(f64::from);
            let of_step = -(steps * (-a).ln_1p()).exp_m1();
            for (spread, number) in spread.iter_mut().zip([r, g, b, of_step]) {
                spread.add(i, number);
            }
            while !is_even(&spread, error) {
                first += 1;
                spread
                    .iter_mut()
                    .for_each(|spread| spread.forget_before(first));
            }
            from.push(first as u32);
        }
        Evenness {
            lo,
            entries_per_value: (table.entries().len() - 1) as f32 / (hi - lo),
            from,
        }
    }

    /// Whether it does between `lo` and `hi`.
    fn holds(&self, lo: f32, hi: f32) -> bool {
        let last = self.from.len() - 1;
        // The arithmetic that renderers classify with, which is monotonic.
        let position =
            |value: f32| ((value - self.lo) * self.entries_per_value).clamp(0.0, last as f32);
        let (first, end) = (position(lo) as usize, position(hi) as usize + 1);
        lo <= hi && self.from[end.min(last)] as usize <= first
    }
}

fn is_even(spread: &[Spread; 4], error: f64) -> bool {
    let [r, g, b, a] = spread.each_ref().map(Spread::ends);
    let color = [r, g, b]
        .map(|(lo, hi)| hi - lo)
        .into_iter()
        .fold(0.0, f64::max);
    a.1 <= 0.0 || (a.1 - a.0) + color * a.0 <= error * a.0
}

/// The smallest and the largest of the last numbers of a sequence.
struct Spread {
    /// Numbers that nothing smaller follows, with their places.
    smallest: VecDeque<(usize, f64)>,
    /// Numbers that nothing larger follows.
    largest: VecDeque<(usize, f64)>,
}

impl Spread {
    const fn new() -> Spread {
        Spread {
            smallest: VecDeque::new(),
            largest: VecDeque::new(),
        }
    }

    fn add(&mut self, place: usize, number: f64) {
        while self.smallest.back().is_some_and(|last| last.1 >= number) {
            self.smallest.pop_back();
        }
        while self.largest.back().is_some_and(|last| last.1 <= number) {
            self.largest.pop_back();
        }
        self.smallest.push_back((place, number));
        self.largest.push_back((place, number));
    }

    fn forget_before(&mut self, place: usize) {
        for queue in [&mut self.smallest, &mut self.largest] {
            while queue.front().is_some_and(|first| first.0 < place) {
                queue.pop_front();
            }
        }
    }

    fn ends(&self) -> (f64, f64) {
        let end = |queue: &VecDeque<(usize, f64)>| queue.front().map_or(0.0, |first| first.1);
        (end(&self.smallest), end(&self.largest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn even_intervals_hold_what_they_say(
            // Few numbers, so that equal ones are side by side.
            entries in proptest::collection::vec(proptest::array::uniform4(0u8..4), 2..40),
            error in 0.001f64..0.5,
            steps in 0.1f64..4.0,
            lo in -1.5f32..1.5,
            width in 0f32..0.4,
        ) {
            let entries: Vec<[f32; 4]> = entries
                .iter()
                .map(|entry| entry.map(|n| [0.0, 0.5, 0.51, 0.9][usize::from(n)]))
                .collect();
            let table = TransferTable::new([-1.0, 1.0], 1.0, entries);
            let even = Evenness::new(&table, steps, error);
            let values: Vec<f32> = (0..=50).map(|i| lo + width * i as f32 / 50.0).collect();
            let looks: Vec<[f64; 4]> = values
                .iter()
                .map(|&value| {
                    let [r, g, b, a] = table.at(value).map(f64::from);
                    [r, g, b, 1.0 - (1.0 - a).powf(steps)]
                })
                .collect();
            let ends = |c: usize| {
                let channel = looks.iter().map(|look| look[c]);
                (channel.clone().fold(f64::MAX, f64::min), channel.fold(f64::MIN, f64::max))
            };
            let (a_min, a_max) = ends(3);
            let color = (0..3).map(|c| ends(c).1 - ends(c).0).fold(0.0, f64::max);
            let changes = if a_max > 0.0 { (a_max - a_min) / a_min + color } else { 0.0 };
            if even.holds(lo, values[50]) {
                prop_assert!(changes <= error + 1e-5, "{changes}");
            }
            // Wherever the whole table is even, every interval of it is.
            let (all_a, all_c) = (ends(3), color);
            if all_a.0 == all_a.1 && all_c == 0.0 && table.entries().iter().all(|e| *e == table.entries()[0]) {
                prop_assert!(even.holds(lo, values[50]));
            }
        }
    }
}
