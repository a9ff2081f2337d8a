use crate::lanes::{F32s, I32s, Mask, words};
use crate::levels::Level;
use strahl_scene::plan::Classify;
use strahl_scene::transfer::TransferTable;

/// Whether a classification shows anything between two values: what
/// [`visibility`](strahl_scene::visibility) asks of bricks, for the ends of steps and without its margins.
/// Steps from one brick that shows nothing into the next are therefore found to show nothing either.
pub struct IntervalVisibility {
    classify: Classify,
    lo: f32,
    entries_per_value: f32,
    /// Number of visible entries before each entry.
    before: Vec<u32>,
}

impl IntervalVisibility {
    /// What `classify` shows, with `table` if it has one.
    pub fn new(classify: Classify, table: &TransferTable) -> IntervalVisibility {
        let [lo, hi] = table.domain();
        let mut before = vec![0];
        for entry in table.entries() {
            before.push(before[before.len() - 1] + u32::from(entry[3] > 0.0));
        }
        IntervalVisibility {
            classify,
            lo,
            entries_per_value: (table.entries().len() - 1) as f32 / (hi - lo),
            before,
        }
    }

    /// Where any value from `lo` to `hi` (finite) may be visible.
    #[inline(always)]
    pub fn any<S: Level>(&self, lo: F32s<S>, hi: F32s<S>) -> Mask<S> {
        match self.classify {
            Classify::Table
            | Classify::GradientTable { .. }
            | Classify::ValueGradient { .. }
            | Classify::PreClassified => self.any_entry(lo, hi),
            Classify::Identity { black, white } => grey(lo, hi, black, white),
            Classify::Threshold {
                threshold,
                black,
                white,
            } => F32s::splat(threshold).lt(hi) & grey(lo, hi, black, white),
        }
    }

    #[inline(always)]
    fn any_entry<S: Level>(&self, lo: F32s<S>, hi: F32s<S>) -> Mask<S> {
        let entries = self.before.len() - 1;
        let last = F32s::splat((entries - 1) as f32);
        let (zero, start) = (F32s::zero(), F32s::splat(self.lo));
        let scale = F32s::splat(self.entries_per_value);
        // `max` and `min` leave no other number than from 0 to the last entry, not even for NaN.
        let first = ((lo - start) * scale).max(zero).min(last).to_i32s();
        let end = ((hi - start) * scale).max(zero).min(last).to_i32s() + I32s::splat(2);
        let end = end.min(entries as i32);
        // SAFETY: both are indices of `before`, which has one number more than there are entries.
        let (before, behind) = unsafe {
            let bytes = bytemuck::cast_slice(&self.before);
            (
                words(bytes, first.shifted_up(2)),
                words(bytes, end.shifted_up(2)),
            )
        };
        before.lt(behind)
    }
}

#[inline(always)]
fn grey<S: Level>(lo: F32s<S>, hi: F32s<S>, black: f32, white: f32) -> Mask<S> {
    if black < white {
        F32s::splat(black).lt(hi)
    } else {
        lo.lt(F32s::splat(black))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::levels::Portable;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn misses_nothing_and_asks_no_more_than_bricks(
            opaque in proptest::collection::vec(any::<bool>(), 2..60),
            lo in -2f32..2.0,
            width in 0f32..1.0,
            part in 0f32..1.0,
        ) {
            let entries = opaque.iter().map(|&o| [0.0, 0.0, 0.0, f32::from(u8::from(o))]);
            let table = TransferTable::new([-1.0, 1.0], 1.0, entries.collect());
            let between = IntervalVisibility::new(Classify::Table, &table);
            let hi = lo + width;
            let at = |value: f32| F32s::<Portable>::splat(value);
            let any = between.any(at(lo), at(hi)).any();
            for value in [lo, hi, lo + (hi - lo) * part] {
                prop_assert!(any || table.at(value)[3] == 0.0, "{value}");
            }
            prop_assert!(!any || table.max_opacity(lo, hi) > 0.0);
        }
    }
}
