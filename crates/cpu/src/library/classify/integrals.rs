//! Pre-integration: what a transfer function shows along a line of values (K. Engel, M. Kraus, T. Ertl 2001).
//!
//! Between two values a and b that follow one another on a ray, the depth of the segment is the mean of τ = −ln(1 − a)
//! over the values between, and its color is what comes out in front of it, each part weakened by those before it.
//! A table holds both for all pairs of some values of the transfer function's domain, so that it does not depend on
//! the data.

use super::surface::Surface;
use super::transfer::Table;
use crate::elementary::opacity_of_lengths;
use crate::lanes::{F32s, I32s, Mask, each, row_pairs};
use crate::levels::{Level, inlined};
use crate::making::Making;
use std::sync::Arc;
use strahl_scene::plan::{Plan, Sampling};
use strahl_scene::transfer::TransferTable;
use strahl_volume::{Cancelled, Key, cores};

/// The table: 4 MiB at the most.
pub struct Integrals {
    /// Row a, column b: opacity of the reference length, and the color of a step times that.
    pairs: Vec<[f32; 4]>,
    /// Values along an edge.
    nodes: usize,
    /// Value of the first one.
    lo: f32,
    cells_per_value: f32,
    /// Of a cell: values that lie no further apart are classified by their middle.
    closest: f32,
    /// Whether anything is shown below the domain, or above.
    shows_outside: bool,
}

/// Values along an edge of the table.
const MOST_NODES: usize = 512;

/// The largest depth of the reference length; f32 takes its opacity for 1.
const LARGEST_DEPTH: f64 = 18.5;

/// What is known of a cell between two nodes.
#[derive(Clone, Copy)]
struct Cell {
    /// The mean of τ per reference length.
    depth: f64,
    /// The mean color, weighted by τ.
    color: [f64; 3],
}

/// What is seen of some cells in a row, front to back.
#[derive(Clone, Copy)]
struct Seen {
    /// Premultiplied.
    color: [f64; 3],
    opacity: f64,
}

impl Seen {
    fn before(self, behind: Seen) -> Seen {
        let passes = 1.0 - self.opacity;
        Seen {
            color: std::array::from_fn(|c| self.color[c] + passes * behind.color[c]),
            opacity: self.opacity + passes * behind.opacity,
        }
    }
}

fn depth(opacity: f64) -> f64 {
    (-(-opacity.clamp(0.0, 1.0)).ln_1p()).min(LARGEST_DEPTH)
}

/// The mean of [`depth`] where the opacity goes from `a` to `b` on a line.
fn mean_depth(a: f64, b: f64) -> f64 {
    if (a - b).abs() < 1e-3 {
        return (depth(a) + 4.0 * depth(0.5 * (a + b)) + depth(b)) / 6.0;
    }
    let [u, v] = [a, b].map(|opacity| (1.0 - opacity).max(0.0));
    // ∫ −ln u du = u − u·ln u.
    let integral = |u: f64| if u > 0.0 { u - u * u.ln() } else { 0.0 };
    ((integral(u) - integral(v)) / (u - v)).min(LARGEST_DEPTH)
}

/// The cells between `nodes` values that are spread over the domain of `table`.
fn cells(table: &TransferTable, nodes: usize) -> Vec<Cell> {
    let entries = table.entries();
    let entries_per_cell = (entries.len() - 1) as f64 / (nodes - 1) as f64;
    let at = |place: f64| -> [f64; 4] {
        let index = (place as usize).min(entries.len() - 2);
        let part = place - index as f64;
        std::array::from_fn(|c| {
            let [a, b] = [entries[index][c], entries[index + 1][c]].map(f64::from);
            a + (b - a) * part
        })
    };
    let cell = |i: usize| {
        let (begin, end) = (
            i as f64 * entries_per_cell,
            (i + 1) as f64 * entries_per_cell,
        );
        let (mut depths, mut colors) = (0.0, [0.0; 3]);
        // From entry to entry: on a line in between.
        let mut from = begin;
        while from < end {
            let to = (from.floor() + 1.0).min(end);
            let ends = [from, 0.5 * (from + to), to].map(at);
            let mean = (to - from) * mean_depth(ends[0][3], ends[2][3]);
            let [a, b, c] = ends.map(|look| depth(look[3]));
            let weights = [a, 4.0 * b, c];
            let sum: f64 = weights.iter().sum();
            if sum > 0.0 {
                for (channel, color) in colors.iter_mut().enumerate() {
                    for (weight, look) in weights.iter().zip(ends) {
                        *color += mean * weight / sum * look[channel];
                    }
                }
                depths += mean;
            }
            from = to;
        }
        let divisor = if depths > 0.0 { depths } else { 1.0 };
        Cell {
            depth: depths / (end - begin),
            color: colors.map(|color| color / divisor),
        }
    };
    cores::map(nodes - 1, cell)
}

/// What is seen of each `width` cells in a row of `seen`, by two runs over blocks of that width: the end of a block and
/// the beginning of the next one make up every window.
fn windows(seen: &[Seen], width: usize) -> Vec<Seen> {
    let (mut heads, mut tails) = (seen.to_vec(), seen.to_vec());
    for i in 1..seen.len() {
        if i % width != 0 {
            heads[i] = heads[i - 1].before(seen[i]);
        }
    }
    for i in (0..seen.len() - 1).rev() {
        if (i + 1) % width != 0 {
            tails[i] = seen[i].before(tails[i + 1]);
        }
    }
    let window = |first: usize| {
        let last = first + width - 1;
        if first.is_multiple_of(width) {
            heads[last]
        } else {
            tails[first].before(heads[last])
        }
    };
    (0..=seen.len() - width).map(window).collect()
}

impl Integrals {
    /// The integrals of `table` over segments of `steps_per_reference` reference lengths.
    pub fn new(table: &TransferTable, steps_per_reference: f64) -> Integrals {
        let number = table.entries().len();
        // Entries are nodes where there are few of them.
        let nodes = match (MOST_NODES - 1) / (number - 1) {
            0 => MOST_NODES,
            times => (number - 1) * times + 1,
        };
        let cells = cells(table, nodes);
        let backwards: Vec<Cell> = cells.iter().rev().copied().collect();
        let of_width = |width: usize| {
            let length = steps_per_reference / width as f64;
            let along = |cells: &[Cell]| {
                let seen = |cell: &Cell| {
                    let opacity = -(-cell.depth * length).exp_m1();
                    Seen {
                        color: cell.color.map(|c| c * opacity),
                        opacity,
                    }
                };
                let seen: Vec<Seen> = cells.iter().map(seen).collect();
                windows(&seen, width)
            };
            (along(&cells), along(&backwards))
        };
        let mut sums = vec![0.0];
        for cell in &cells {
            sums.push(sums[sums.len() - 1] + cell.depth);
        }
        let widths = cores::map(nodes - 1, |i| of_width(i + 1));
        let pair = |a: usize, b: usize| -> [f32; 4] {
            let width = a.abs_diff(b);
            let Some((along, back)) = widths.get(width.wrapping_sub(1)) else {
                let place = a as f64 * (number - 1) as f64 / (nodes - 1) as f64;
                let index = (place as usize).min(number - 2);
                let part = (place - index as f64) as f32;
                let [low, high] = [table.entries()[index], table.entries()[index + 1]];
                let [r, g, b, opacity] =
                    std::array::from_fn(|c| low[c] + (high[c] - low[c]) * part);
                return [r * opacity, g * opacity, b * opacity, opacity];
            };
            let seen = if a < b { along[a] } else { back[nodes - 1 - a] };
            let opacity = -(-(sums[a.max(b)] - sums[a.min(b)]) / width as f64).exp_m1();
            if seen.opacity <= 0.0 {
                return [0.0; 4];
            }
            let [r, g, b] = seen.color.map(|c| (c / seen.opacity * opacity) as f32);
            [r, g, b, opacity as f32]
        };
        let [lo, hi] = table.domain();
        let cells_per_value = (nodes - 1) as f32 / (hi - lo);
        let ends = [table.entries()[0], table.entries()[number - 1]];
        Integrals {
            pairs: cores::map(nodes * nodes, |i| pair(i / nodes, i % nodes)),
            nodes,
            lo,
            cells_per_value,
            closest: ((nodes - 1) as f32 / (number - 1) as f32).min(0.5),
            shows_outside: ends.iter().any(|entry| entry[3] > 0.0),
        }
    }

    /// What is shown where values go from one of the `ends` (finite) to the other on a line, as a surface with opacity
    /// of the reference length, where `asked`; anything elsewhere. `of_length` gives the opacity of the segment's
    /// length for one of the reference length.
    #[inline(always)]
    pub fn between<S: Level>(
        &self,
        table: &Table,
        ends: [F32s<S>; 2],
        of_length: impl Fn(F32s<S>) -> F32s<S>,
        asked: Mask<S>,
    ) -> Surface<S> {
        let zero = F32s::zero();
        let last = F32s::splat((self.nodes - 1) as f32);
        let place = inlined(
            #[inline(always)]
            |value: F32s<S>| {
                let place = (value - F32s::splat(self.lo)) * F32s::splat(self.cells_per_value);
                // Differences of larger ones may overflow.
                place.max(F32s::splat(-1e30)).min(F32s::splat(1e30))
            },
        );
        let [a, b] = [place(ends[0]), place(ends[1])];
        let length = (b - a).abs();
        let is_close = length.le(F32s::splat(self.closest));
        let mut surface = Surface {
            color: [zero; 3],
            opacity: zero,
        };
        if (asked & is_close).any() {
            let middle = ends[0].lerp(ends[1], F32s::splat(0.5));
            surface = table.at(middle);
        }
        if !(asked & !is_close).any() {
            return surface;
        }
        let inside = inlined(
            #[inline(always)]
            |place: F32s<S>| place.max(zero).min(last),
        );
        let [from, to] = [inside(a), inside(b)];
        let divisor = is_close.select(F32s::splat(1.0), length);
        let share = (to - from).abs().over(divisor);
        let mut apart = self.at(from, to);
        apart.opacity = of_share(apart.opacity, share);
        if self.shows_outside {
            // What lies below the domain and above it: what lies there all along.
            let below = (a.min(zero) - b.min(zero)).abs().over(divisor);
            let above = (a.max(last) - b.max(last)).abs().over(divisor);
            let rises = a.lt(b);
            let beyond = inlined(
                #[inline(always)]
                |is_above: Mask<S>| {
                    let value =
                        is_above.select(F32s::splat(f32::INFINITY), F32s::splat(f32::NEG_INFINITY));
                    let mut surface = table.at(value);
                    let share = is_above.select(above, below);
                    surface.opacity = of_share(surface.opacity, share);
                    surface
                },
            );
            apart = in_a_row([beyond(!rises), apart, beyond(rises)], of_length);
        }
        Surface {
            color: is_close.select3(surface.color, apart.color),
            opacity: is_close.select(surface.opacity, apart.opacity),
        }
    }

    /// The table between two places of it.
    #[inline(always)]
    fn at<S: Level>(&self, from: F32s<S>, to: F32s<S>) -> Surface<S> {
        let last_cell = self.nodes as i32 - 2;
        let (row, column) = (
            from.to_i32s().min(last_cell).max(0),
            to.to_i32s().min(last_cell).max(0),
        );
        let (down, across) = (from - row.to_f32s(), to - column.to_f32s());
        let edge = I32s::splat(self.nodes as i32);
        let index = row * edge + column;
        // SAFETY: both places are at least 0 and at least one node from the end, so that there is one more node
        // across, and one more row.
        let [above, below] = unsafe {
            [
                row_pairs(&self.pairs, index),
                row_pairs(&self.pairs, index + edge),
            ]
        };
        let channel = inlined(
            #[inline(always)]
            |c: usize| {
                let above = above[0][c].lerp(above[1][c], across);
                let below = below[0][c].lerp(below[1][c], across);
                above.lerp(below, down)
            },
        );
        let opacity = channel(3);
        let shows = F32s::zero().lt(opacity);
        let divisor = shows.select(opacity, F32s::splat(1.0));
        Surface {
            color: each!([0, 1, 2], |c| channel(c).over(divisor)),
            opacity: opacity.max(F32s::zero()).min(F32s::splat(1.0)),
        }
    }
}

/// The opacity of a share of the length that this opacity belongs to; none of it shows nothing.
#[inline(always)]
fn of_share<S: Level>(opacity: F32s<S>, share: F32s<S>) -> F32s<S> {
    let zero = F32s::zero();
    zero.lt(share)
        .select(opacity_of_lengths(opacity, share), zero)
}

/// Surfaces one behind the other as one; opacities are of the reference length.
#[inline(always)]
fn in_a_row<S: Level>(
    surfaces: [Surface<S>; 3],
    of_length: impl Fn(F32s<S>) -> F32s<S>,
) -> Surface<S> {
    let (zero, one) = (F32s::zero(), F32s::splat(1.0));
    let (mut color, mut seen) = ([zero; 3], zero);
    let mut opacity = zero;
    for surface in surfaces {
        let share = (one - seen) * of_length(surface.opacity);
        let shows = zero.lt(share);
        for (sum, channel) in color.iter_mut().zip(surface.color) {
            *sum += shows.select(share * channel, zero);
        }
        seen += share;
        opacity += (one - opacity) * surface.opacity;
    }
    let divisor = zero.lt(seen).select(seen, one);
    Surface {
        color: each!(color, |c| c.over(divisor)),
        opacity,
    }
}

/// All that a table depends on.
#[derive(Clone, PartialEq)]
pub struct IntegralsKey {
    table: TransferTable,
    step_mm: f64,
}

impl Key for IntegralsKey {
    type Value = Integrals;

    const NAME: &str = "integrals";

    fn bytes(&self, value: &Integrals) -> usize {
        size_of_val(self.table.entries()) + size_of_val(&value.pairs[..])
    }
}

impl Integrals {
    /// The table for object number `object` of `plan`; `None` if its sampling asks for none.
    pub fn of_plan(
        making: &Making,
        plan: &Plan,
        object: usize,
    ) -> Result<Option<Arc<Integrals>>, Cancelled> {
        if plan.sampling != Sampling::Integrated {
            return Ok(None);
        }
        let key = IntegralsKey {
            table: plan.technique_of(object).table.clone(),
            step_mm: plan.lattice.step_mm,
        };
        let reference_mm = f64::from(key.table.reference_mm());
        let make = || Ok(Integrals::new(&key.table, key.step_mm / reference_mm));
        making.find(&key, make).map(Some)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::LANES;
    use crate::levels::Portable;
    use proptest::prelude::*;

    /// What the rule gives: color and opacity of the reference length.
    fn found(table: &TransferTable, steps_per_reference: f64, ends: [f32; 2]) -> [f32; 4] {
        let integrals = Integrals::new(table, steps_per_reference);
        let all = F32s::<Portable>::zero().le(F32s::zero());
        let of_length =
            |opacity| opacity_of_lengths(opacity, F32s::splat(steps_per_reference as f32));
        let ends = ends.map(F32s::<Portable>::splat);
        let surface = integrals.between(&Table::new(table), ends, of_length, all);
        let [r, g, b] = surface.color.map(|c| c.lane(LANES - 1));
        [r, g, b, surface.opacity.lane(LANES - 1)]
    }

    /// The same by the formula, premultiplied and for the segment, in many small parts.
    fn truth(table: &TransferTable, steps_per_reference: f64, [a, b]: [f32; 2]) -> [f64; 4] {
        const PARTS: u32 = 20_000;
        let (mut sum, mut passes) = ([0.0; 4], 1.0);
        for i in 0..PARTS {
            let part = (i as f32 + 0.5) / PARTS as f32;
            let look = table.at(a + (b - a) * part).map(f64::from);
            let length = steps_per_reference / f64::from(PARTS);
            let opacity = 1.0 - (1.0 - look[3]).max(1e-8).powf(length);
            for (sum, channel) in sum.iter_mut().zip([look[0], look[1], look[2], 1.0]) {
                *sum += passes * opacity * channel;
            }
            passes *= 1.0 - opacity;
        }
        sum
    }

    fn of_segment(steps_per_reference: f64, [r, g, b, opacity]: [f32; 4]) -> [f64; 4] {
        let opacity = 1.0 - (1.0 - f64::from(opacity)).powf(steps_per_reference);
        [r, g, b, 1.0].map(|channel| f64::from(channel) * opacity)
    }

    fn entries(number: usize) -> impl Strategy<Value = Vec<[f32; 4]>> {
        let entry = (proptest::array::uniform3(0f32..1.0), 0f32..0.95);
        let entry = entry.prop_map(|([r, g, b], opacity)| [r, g, b, opacity]);
        proptest::collection::vec(entry, 2..number)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]
        #[test]
        fn is_the_integral_between_any_two_values(
            entries in entries(9),
            steps_per_reference in 0.05f64..8.0,
            ends in proptest::array::uniform2(-1f32..2.0),
        ) {
            let table = TransferTable::new([0.0, 1.0], 1.0, entries);
            let found = of_segment(steps_per_reference, found(&table, steps_per_reference, ends));
            let truth = truth(&table, steps_per_reference, ends);
            prop_assert!((found[3] - truth[3]).abs() < 4e-3, "{found:?} instead of {truth:?}");
            let is_inside = ends.iter().all(|end| (0.0..=1.0).contains(end));
            for c in 0..3 {
                if is_inside {
                    let error = (found[c] - truth[c]).abs();
                    prop_assert!(error < 6e-3, "{found:?} instead of {truth:?}");
                } else {
                    // Where only a share of the segment lies in the domain, its color is that of a whole one, which
                    // may be any mean of the colors between both ends.
                    prop_assert!((-1e-6..=found[3] + 1e-6).contains(&found[c]), "{found:?}");
                }
            }
        }

        #[test]
        fn one_value_is_the_sample(
            entries in entries(3000),
            steps_per_reference in 0.05f64..8.0,
            value in -0.5f32..1.5,
        ) {
            let table = TransferTable::new([0.0, 1.0], 1.0, entries);
            let found = found(&table, steps_per_reference, [value; 2]);
            prop_assert_eq!(found, table.at(value));
        }
    }

    #[test]
    fn order_counts() {
        // Red below, blue above, both nearly opaque: what lies in front is seen.
        let entry = |i: usize| {
            if i < 50 {
                [1.0, 0.0, 0.0, 0.9]
            } else {
                [0.0, 0.0, 1.0, 0.9]
            }
        };
        let table = TransferTable::new([0.0, 1.0], 1.0, (0..100).map(entry).collect());
        let up = found(&table, 4.0, [0.0, 1.0]);
        let down = found(&table, 4.0, [1.0, 0.0]);
        // Half of the way hides all but (1 − 0.9)² of what is behind.
        assert!(
            (up[0] - 0.99).abs() < 1e-3 && (up[2] - 0.01).abs() < 1e-3,
            "{up:?}"
        );
        assert!(
            (down[2] - 0.99).abs() < 1e-3 && (down[0] - 0.01).abs() < 1e-3,
            "{down:?}"
        );
        assert!((up[3] - 0.9).abs() < 1e-5);
    }

    #[test]
    fn what_lies_outside_the_domain_counts_for_its_share() {
        // Nothing inside but a triangle to 0.5, nothing outside.
        let entry = |opacity: f32| [1.0, 1.0, 1.0, opacity];
        let thin = TransferTable::new([0.0, 1.0], 1.0, [0.0, 0.5, 0.0].map(entry).to_vec());
        let depth = mean_depth(0.0, 0.5);
        for (ends, share) in [([0.0, 1.0], 1.0), ([-9.0, 11.0], 0.05), ([3.0, -2.0], 0.2)] {
            let opacity = f64::from(found(&thin, 1.0, ends)[3]);
            let expected = 1.0 - (-depth * share).exp();
            assert!(
                (opacity - expected).abs() < 1e-5,
                "{opacity} instead of {expected}"
            );
        }
        assert_eq!(found(&thin, 1.0, [2.0, 9.0])[3], 0.0);
        assert_eq!(found(&thin, 1.0, [-2.0, -9.0])[3], 0.0);
        // Opaque above: shown as soon as anything lies there.
        let step = TransferTable::new([0.0, 1.0], 1.0, [0.0, 0.0, 1.0].map(entry).to_vec());
        assert_eq!(found(&step, 1.0, [0.0, 3.0])[3], 1.0);
        assert_eq!(found(&step, 1.0, [-3.0, 0.4])[3], 0.0);
        assert_eq!(found(&step, 1.0, [f32::MAX, -f32::MAX])[3], 1.0);
    }
}
