//! Classification: tables before or behind interpolation (document §6.6).

use crate::spec::{Classification, Look};

/// Opacity over values as the user gave it: linear between points, the later of two points at one value counts from there.
pub fn opacity(points: &[[f64; 2]], value: f64) -> f64 {
    let next = points.partition_point(|p| p[0] <= value);
    match (next.checked_sub(1).map(|i| points[i]), points.get(next)) {
        (None, None) => 0.0,
        (None, Some(first)) => first[1],
        (Some(last), None) => last[1],
        (Some([v0, o0]), Some(&[v1, o1])) => o0 + (o1 - o0) * (value - v0) / (v1 - v0),
    }
}

/// The tables of a frame.
#[derive(Clone, Debug)]
pub struct Tables {
    kind: Classification,
    /// Stored voxel (16 bit) → word on the bus.
    pre: Vec<u16>,
    /// Interpolated word → opacity.
    post: Vec<u16>,
    /// (Word before, word) → opacity of the step between them; only if pre-integrated.
    integrated: Vec<u16>,
    data: u32,
}

impl Tables {
    /// `value_of` gives the value of a stored 16-bit voxel; `range` is that of the volume.
    pub fn new(look: &Look, data: u32, value_of: impl Fn(u16) -> f64, range: [f64; 2]) -> Tables {
        let top = f64::from((1u32 << data) - 1);
        let word = |opacity: f64| (opacity * top).round() as u16;
        let [lo, hi] = range;
        let width = if hi > lo { hi - lo } else { 1.0 };
        let pre = (0..=u16::MAX)
            .map(|voxel| {
                let value = value_of(voxel);
                match look.classification {
                    Classification::Pre => word(opacity(&look.opacity, value)),
                    _ => ((value - lo) / width * top).round().clamp(0.0, top) as u16,
                }
            })
            .collect();
        let post: Vec<u16> = (0..1u32 << data)
            .map(|entry| match look.classification {
                Classification::Pre => entry as u16,
                _ => word(opacity(&look.opacity, lo + f64::from(entry) / top * width)),
            })
            .collect();
        let integrated = match look.classification {
            Classification::PreIntegrated => integrated(look, data, lo, width),
            _ => Vec::new(),
        };
        Tables {
            kind: look.classification,
            pre,
            post,
            integrated,
            data,
        }
    }

    /// A pre-classification table as it was written, and nothing behind interpolation.
    pub(crate) fn of_pre(pre: Vec<u16>, data: u32) -> Tables {
        Tables {
            kind: Classification::Pre,
            pre,
            post: (0..1 << data).map(|entry: u32| entry as u16).collect(),
            integrated: Vec::new(),
            data,
        }
    }

    /// The word on the bus for a stored voxel.
    #[inline]
    pub fn bus_word(&self, voxel: u16) -> u16 {
        self.pre[voxel as usize]
    }

    /// Opacity of an interpolated word; `before` is that of the sample before on the same ray.
    #[inline(always)]
    pub fn opacity(&self, before: u32, word: u32) -> u32 {
        match self.kind {
            Classification::Pre => word,
            Classification::Post => u32::from(self.post[word as usize]),
            Classification::PreIntegrated => {
                u32::from(self.integrated[(before << self.data | word) as usize])
            }
        }
    }

    /// Whether every word of `low ..= high` has opacity 0: for each word, how many words up to it are visible.
    pub fn visible_up_to(&self) -> Vec<u32> {
        let mut count = 0;
        let mut sums = vec![0];
        for &opacity in &self.post {
            count += u32::from(opacity > 0);
            sums.push(count);
        }
        sums
    }
}

/// The mean over the step of the opacity per step, as a table over the words at both ends: 1 − exp(mean of ln(1 − o)),
/// by sums over the curve. Engel, Kraus, Ertl: "High-quality pre-integrated volume rendering", 2001; without their colour.
fn integrated(look: &Look, data: u32, lo: f64, width: f64) -> Vec<u16> {
    let n = 1usize << data;
    let top = (n - 1) as f64;
    // Optical depth at the middle of each of `FINE` parts of the way between two words.
    const FINE: usize = 4;
    let mut sums = vec![0.0f64];
    let mut sum = 0.0;
    let mut depth = Vec::new();
    let depth_at = |word: f64| {
        let o = opacity(&look.opacity, lo + word / top * width).min(0.999_999);
        -(1.0 - o).ln()
    };
    for i in 0..(n - 1) * FINE {
        sum += depth_at((i as f64 + 0.5) / FINE as f64) / FINE as f64;
        sums.push(sum);
    }
    for i in 0..n {
        depth.push(depth_at(i as f64));
    }
    let mut table = vec![0u16; n * n];
    for before in 0..n {
        for word in 0..n {
            let mean = match before.abs_diff(word) {
                0 => depth[word],
                steps => {
                    (sums[before.max(word) * FINE] - sums[before.min(word) * FINE]) / steps as f64
                }
            };
            table[before << data | word] = ((1.0 - (-mean).exp()) * top).round() as u16;
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_go_through_their_points_and_steps_are_steps() {
        let points = [[0.0, 0.0], [10.0, 0.5], [10.0, 1.0], [20.0, 0.0]];
        for (value, expected) in [
            (-5.0, 0.0),
            (5.0, 0.25),
            (10.0, 1.0),
            (15.0, 0.5),
            (99.0, 0.0),
        ] {
            assert_eq!(opacity(&points, value), expected, "at {value}");
        }
    }

    #[test]
    fn pre_integration_of_a_constant_is_the_constant() {
        let look = Look {
            classification: Classification::PreIntegrated,
            opacity: vec![[0.0, 0.25]],
            ..Look::default()
        };
        let tables = Tables::new(&look, 8, f64::from, [0.0, 255.0]);
        for (a, b) in [(0, 0), (0, 255), (255, 3), (17, 18)] {
            assert_eq!(tables.opacity(a, b), 64);
        }
    }

    #[test]
    fn pre_integration_sees_a_peak_between_the_samples() {
        let look = Look {
            classification: Classification::PreIntegrated,
            opacity: vec![[99.0, 0.0], [100.0, 1.0], [101.0, 0.0]],
            ..Look::default()
        };
        let tables = Tables::new(&look, 8, f64::from, [0.0, 255.0]);
        assert_eq!(tables.opacity(50, 50), 0);
        assert!(tables.opacity(90, 110) > 10);
        assert_eq!(tables.opacity(90, 110), tables.opacity(110, 90));
    }
}
