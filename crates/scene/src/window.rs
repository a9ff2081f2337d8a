//! The window that a volume is looked at through when nobody says one.

use crate::Method;
use strahl_volume::{Statistics, VolumeHeader};

/// An interval of values, lo < hi.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Window {
    pub lo: f64,
    pub hi: f64,
}

impl Window {
    pub fn width(self) -> f64 {
        self.hi - self.lo
    }

    pub fn middle(self) -> f64 {
        0.5 * (self.lo + self.hi)
    }

    /// The values of what is not background: from half the way to Otsu's threshold, which leaves the
    /// noise of air below, to the value that only 0.2 % of the voxels above the threshold exceed,
    /// which leaves single bright spots above.
    pub fn of_foreground(header: &VolumeHeader) -> Window {
        let statistics = &header.statistics;
        let [lo, hi] = statistics.range;
        let threshold = otsu_threshold(statistics);
        Window::tidy(
            lo + 0.5 * (threshold - lo),
            quantile_above(statistics, threshold, 0.998),
            [lo, hi],
        )
    }

    /// The window that suits `method`.
    pub fn automatic(method: Method, header: &VolumeHeader) -> Window {
        let statistics = &header.statistics;
        let range = statistics.range;
        let threshold = otsu_threshold(statistics);
        match method {
            // A ray's mean holds air too: what lies above the threshold on average is about the
            // most that it reaches.
            Method::Average => Window::tidy(range[0], mean_above(statistics, threshold), range),
            Method::Minip => Window::tidy(range[0], threshold, range),
            _ => Window::of_foreground(header),
        }
    }

    /// Ends rounded, because people read them; widened if nothing is left.
    fn tidy(lo: f64, hi: f64, range: [f64; 2]) -> Window {
        let (lo, hi) = if hi > lo {
            (lo, hi)
        } else {
            (range[0], range[1])
        };
        // The third is a volume that no f32 can hold, which `resolve` refuses.
        if hi > lo && (hi - lo).is_finite() && lo.abs().max(hi.abs()) < 1e300 {
            let (round_lo, round_hi) = (round_to_width(lo, hi - lo), round_to_width(hi, hi - lo));
            return if round_hi > round_lo {
                Window {
                    lo: round_lo,
                    hi: round_hi,
                }
            } else {
                Window { lo, hi }
            };
        }
        // A constant volume.
        let lo = lo.clamp(-1e30, 1e30);
        Window {
            lo,
            hi: lo + (lo.abs() * 1e-3).max(1.0),
        }
    }
}

/// The threshold that splits the histogram into two classes with the largest variance between them
/// (N. Otsu, A Threshold Selection Method from Gray-Level Histograms, 1979).
pub(crate) fn otsu_threshold(statistics: &Statistics) -> f64 {
    let [lo, hi] = statistics.range;
    let bins = &statistics.histogram;
    let total: f64 = bins.iter().map(|&count| count as f64).sum();
    let sum: f64 = weighted(bins);
    let (mut below, mut below_sum) = (0.0, 0.0);
    let (mut best, mut best_bin) = (-1.0, 0);
    for (bin, &count) in bins.iter().enumerate() {
        below += count as f64;
        below_sum += bin as f64 * count as f64;
        let above = total - below;
        if below == 0.0 || above <= 0.0 {
            continue;
        }
        let apart = below_sum / below - (sum - below_sum) / above;
        let variance = below * above * apart * apart;
        if variance > best {
            (best, best_bin) = (variance, bin);
        }
    }
    lo + (hi - lo) * (best_bin as f64 + 1.0) / bins.len().max(1) as f64
}

/// The surface that divides a volume best.
pub(crate) fn automatic_threshold(header: &VolumeHeader) -> f64 {
    let [lo, hi] = header.statistics.range;
    // Of a volume that no f32 can hold, `resolve` refuses the values and not this.
    round_to_width(otsu_threshold(&header.statistics), hi - lo).clamp(-1e30, 1e30)
}

/// A steep gradient: all values, or as much opacity as `most_opaque`, within two voxels.
pub(crate) fn steep_per_mm(header: &VolumeHeader, most_opaque: Option<f64>) -> f64 {
    let [lo, hi] = header.statistics.range;
    let height = most_opaque.unwrap_or(hi - lo);
    let steep = 0.5 * height / header.grid.mean_spacing_mm();
    round_to_width(steep, steep).clamp(1e-30, 1e30)
}

/// All values, from black to white: what is shown when nothing is classified.
pub(crate) fn value_range(header: &VolumeHeader) -> [f32; 2] {
    let [lo, hi] = header.statistics.range.map(|v| v as f32);
    if lo < hi { [lo, hi] } else { [lo, lo + 1.0] }
}

/// Mean of the values above `threshold`.
fn mean_above(statistics: &Statistics, threshold: f64) -> f64 {
    let [lo, hi] = statistics.range;
    let bins = &statistics.histogram;
    let first = first_bin_above(statistics, threshold);
    let count: f64 = bins[first..].iter().map(|&count| count as f64).sum();
    let sum: f64 = bins[first..]
        .iter()
        .enumerate()
        .map(|(i, &count)| (first + i) as f64 * count as f64)
        .sum();
    if count == 0.0 {
        return hi;
    }
    lo + (hi - lo) * (sum / count + 0.5) / bins.len() as f64
}

fn first_bin_above(statistics: &Statistics, value: f64) -> usize {
    let [lo, hi] = statistics.range;
    let bins = statistics.histogram.len();
    let first = ((value - lo) / (hi - lo) * bins as f64).round();
    // NaN, for a constant volume, becomes 0.
    (first as usize).min(bins)
}

fn weighted(bins: &[u64]) -> f64 {
    bins.iter()
        .enumerate()
        .map(|(bin, &count)| bin as f64 * count as f64)
        .sum()
}

/// The value below which a share `quantile` of the samples above `threshold` lies.
pub(crate) fn quantile_above(statistics: &Statistics, threshold: f64, quantile: f64) -> f64 {
    let [lo, hi] = statistics.range;
    let bins = &statistics.histogram;
    let first = first_bin_above(statistics, threshold);
    let total: f64 = bins[first..].iter().map(|&count| count as f64).sum();
    let mut seen = 0.0;
    for (bin, &count) in bins.iter().enumerate().skip(first) {
        seen += count as f64;
        if count > 0 && seen >= quantile * total {
            return lo + (hi - lo) * (bin as f64 + 1.0) / bins.len() as f64;
        }
    }
    hi
}

/// Share of the samples with a value above `value`.
pub(crate) fn share_above(statistics: &Statistics, value: f64) -> f64 {
    let bins = &statistics.histogram;
    let first = first_bin_above(statistics, value);
    let total: u64 = bins.iter().sum();
    bins[first..].iter().sum::<u64>() as f64 / total.max(1) as f64
}

/// `value` rounded to a ten-thousandth of `width`, because people read it.
pub(crate) fn round_to_width(value: f64, width: f64) -> f64 {
    let digits = 4.0 - width.log10().floor();
    if !(0.0..=12.0).contains(&digits) {
        return if digits < 0.0 && value.is_finite() {
            value.round()
        } else {
            value
        };
    }
    let scale = 10f64.powf(digits);
    let rounded = (value * scale).round() / scale;
    if rounded.is_finite() { rounded } else { value }
}
