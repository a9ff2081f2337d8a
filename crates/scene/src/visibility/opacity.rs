//! How opaque a volume is, place by place: what longer steps where it is not rest on.

use super::{joined_with_neighbors, of_reached, rescale_of, values};
use crate::plan::{Classify, Composite, Fetch, Plan, Sampling};
use crate::transfer::{Places, TransferTable};
use std::ops::Range;
use strahl_volume::bricks::{BrickRange, Bricks};
use strahl_volume::{Cancelled, Control};

/// For each brick of layer number `layer`, x fastest: 0 if no sample inside shows anything, exactly where
/// [`Contribution::Visible`](super::Contribution::Visible) says so; otherwise a number m from 1
/// to 255 such that no sample inside it or the 26 bricks around it has an opacity of a step above m/255. `None` if
/// nothing is known of the values, or `plan` wants every lattice point.
///
/// # Errors
/// `control` was cancelled.
pub fn most_opacity(
    plan: &Plan,
    layer: usize,
    bricks: &Bricks,
    control: &Control,
) -> Result<Option<Vec<u8>>, Cancelled> {
    let (field, technique) = (plan.field_of(layer), plan.technique_of(layer));
    let known = field.fetch == Fetch::Stored
        && technique.classify == Classify::Table
        && matches!(technique.composite, Composite::EmissionAbsorption { .. })
        && plan.modules.is_empty();
    if !known || !matches!(plan.sampling, Sampling::ByOpacity { .. }) {
        return Ok(None);
    }
    let most = MostOpacity::new(&technique.table, plan.lattice.step_mm);
    let of_brick = |range: BrickRange| {
        if range.is_empty() {
            return 0;
        }
        let (lo, hi) = values(range, rescale_of(field));
        most.between(lo, hi)
    };
    let of_bricks = of_reached(bricks, field.reconstruct, of_brick, control)?;
    let join = |most: &mut u8, other: &u8| *most = (*most).max(*other);
    let mut around = joined_with_neighbors(bricks.dims(), of_bricks.clone(), join, control)?;
    for (around, own) in around.iter_mut().zip(of_bricks) {
        if own == 0 {
            *around = 0;
        }
    }
    Ok(Some(around))
}

/// The largest opacity of a step between two values, in constant time.
struct MostOpacity {
    places: Places,
    /// Of 1, 2, 4 … entries from each entry on: the largest opacity in 255ths, rounded up.
    of_runs: Vec<Vec<u8>>,
}

impl MostOpacity {
    fn new(table: &TransferTable, step_mm: f64) -> MostOpacity {
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
            places: table.places(),
            of_runs,
        }
    }

    /// The largest of any value from `lo` to `hi`, in 255ths, rounded up.
    fn between(&self, lo: f32, hi: f32) -> u8 {
        let Range { start, end } = self.places.beside(lo, hi);
        let runs = (end - start).ilog2() as usize;
        let of_runs = &self.of_runs[runs];
        of_runs[start].max(of_runs[end - (1 << runs)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visibility::Opaque;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn most_opacity_is_that_of_the_table_and_none_where_skipping_says_so(
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
            let largest = f64::from(table.max_opacity(lo, lo + width));
            let of_step = 255.0 * (1.0 - (1.0 - largest).powf(steps));
            prop_assert!(f64::from(most) >= of_step && f64::from(most) < of_step + 1.01);
            prop_assert_eq!(most > 0, Opaque::new(&table).any(lo, lo + width));
        }
    }
}
