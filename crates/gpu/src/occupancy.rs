//! Which bricks of a volume can show anything under a Plan.

use strahl_scene::plan::{Composite, Plan};
use strahl_scene::transfer::TransferTable;
use strahl_volume::bricks::{BrickRange, Bricks};

/// One byte per brick, x fastest: 0 where nothing can be seen. Never says so of a brick in which a
/// sample counts; rounding is on the side of looking.
pub fn occupancy(bricks: &Bricks, plan: &Plan) -> Vec<u8> {
    let visible: Box<dyn Fn(f32, f32) -> bool> = match plan.composite {
        Composite::EmissionAbsorption { .. } => {
            let opaque = Opaque::new(&plan.classify);
            Box::new(move |lo, hi| opaque.any(lo, hi))
        }
        Composite::FirstHit { threshold } => Box::new(move |_, hi| hi >= threshold as f32),
        // Every sample counts, or may.
        Composite::Mip | Composite::MinIp | Composite::Average => Box::new(|_, _| true),
    };
    let byte = |range: &BrickRange| {
        let (lo, hi) = values(range, plan);
        u8::from(!range.is_empty() && visible(lo, hi))
    };
    bricks.ranges().iter().map(byte).collect()
}

/// The values of a brick, widened by what interpolation in single precision may add.
fn values(range: &BrickRange, plan: &Plan) -> (f32, f32) {
    let rescale = plan.volume.rescale;
    let a = rescale.value(f64::from(range.lo)) as f32;
    let b = rescale.value(f64::from(range.hi)) as f32;
    // The texture unit of some devices has weights of 8 bits, which never leave the range either.
    let slack = 1e-5 * (a.abs().max(b.abs()) + (a - b).abs());
    (a.min(b) - slack, a.max(b) + slack)
}

/// How many entries of a transfer table up to each are not transparent.
struct Opaque {
    domain: [f32; 2],
    count: Vec<u32>,
}

impl Opaque {
    fn new(table: &TransferTable) -> Opaque {
        let mut count = vec![0];
        let mut sum = 0;
        for entry in table.entries() {
            sum += u32::from(entry[3] > 0.0);
            count.push(sum);
        }
        Opaque {
            domain: table.domain(),
            count,
        }
    }

    /// Whether any value from `lo` to `hi` may be visible.
    fn any(&self, lo: f32, hi: f32) -> bool {
        let entries = self.count.len() - 1;
        let [d0, d1] = self.domain;
        let last = (entries - 1) as f32;
        let position = |value: f32| ((value - d0) * (last / (d1 - d0))).clamp(0.0, last);
        // One entry more on either side makes up for rounding.
        let first = (position(lo) as usize).saturating_sub(1);
        let end = (position(hi) as usize + 3).min(entries);
        self.count[end] > self.count[first]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_peak_one_entry_wide_is_found_wherever_it_touches() {
        for peak in [0usize, 7, 63] {
            let mut entries = vec![[0.0; 4]; 64];
            entries[peak][3] = 0.5;
            let table = TransferTable::new([0.0, 63.0], 1.0, entries);
            let opaque = Opaque::new(&table);
            for lo in -2..66 {
                for hi in lo..66 {
                    let (lo, hi) = (lo as f32 + 0.25, hi as f32 + 0.25);
                    if table.max_opacity(lo, hi) > 0.0 {
                        assert!(opaque.any(lo, hi), "{lo} to {hi}, peak at {peak}");
                    }
                }
            }
            assert!(!opaque.any(20.0, 40.0));
        }
    }
}
