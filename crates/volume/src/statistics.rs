//! Range and histogram of the values of a volume.

use crate::rows::made;
use crate::{Cancelled, Control, Error, Rescale, Sample, SampleType, Samples, with_samples};
use bytemuck::Pod;

/// Range and histogram of the values (not of the stored numbers).
#[derive(Clone, Debug, PartialEq)]
pub struct Statistics {
    /// Smallest and largest finite value; [0, 0] if no value is finite.
    pub range: [f64; 2],
    /// Number of samples per bin; the bins divide `range` evenly. Samples that are not finite are
    /// not counted. For types of at most 8 bits every stored number has a bin of its own.
    pub histogram: Vec<u64>,
    /// Number of samples that are NaN or infinite.
    pub not_finite: u64,
}

impl Statistics {
    /// Bins of the histogram of types wider than 8 bits.
    pub const BINS: usize = 1024;

    /// Scans all samples, several times for types wider than 16 bits.
    pub fn of(samples: &Samples, rescale: Rescale) -> Statistics {
        made(Statistics::under(samples, rescale, &Control::NONE).map_err(Error::from))
    }

    /// The same under `control`.
    ///
    /// # Errors
    /// It was cancelled.
    pub fn under(
        samples: &Samples,
        rescale: Rescale,
        control: &Control,
    ) -> Result<Statistics, Cancelled> {
        with_samples!(samples, s => of(s, rescale, control))
    }

    /// The value below which a share `quantile` (0 to 1) of the counted samples lies, to the
    /// accuracy of one bin.
    pub fn quantile(&self, quantile: f64) -> f64 {
        let [lo, hi] = self.range;
        match self.bin_of(quantile) {
            Some((bin, inside)) => {
                lo + (hi - lo) * (bin as f64 + inside) / self.histogram.len() as f64
            }
            None => hi,
        }
    }

    /// [`Statistics::quantile`] for samples of a whole-number type with this slope: the value of a
    /// whole stored number, and for types of at most 8 bits the exact quantile.
    pub fn whole_quantile(&self, quantile: f64, slope: f64) -> f64 {
        let [lo, hi] = self.range;
        let Some((bin, inside)) = self.bin_of(quantile) else {
            return hi;
        };
        // In stored numbers, counted from the one that `lo` is the value of.
        let last = ((hi - lo) / slope.abs()).round();
        let bin_width = last / self.histogram.len() as f64;
        let first_in_bin = (bin as f64 * bin_width - 1e-9).ceil();
        let number = ((bin as f64 + inside) * bin_width)
            .floor()
            .max(first_in_bin);
        lo + number.min(last) * slope.abs()
    }

    /// The bin that a quantile lies in, and how far into it, 0 to 1. `None` if nothing was counted.
    fn bin_of(&self, quantile: f64) -> Option<(usize, f64)> {
        let total: u64 = self.histogram.iter().sum();
        let wanted = quantile.clamp(0.0, 1.0) * total as f64;
        let mut below = 0.0;
        for (bin, &count) in self.histogram.iter().enumerate() {
            let count = count as f64;
            if count > 0.0 && below + count >= wanted {
                return Some((bin, (wanted - below) / count));
            }
            below += count;
        }
        None
    }
}

/// Samples between two looks at the control.
const PIECE: usize = 1 << 18;

fn of<T: Sample>(
    samples: &[T],
    rescale: Rescale,
    control: &Control,
) -> Result<Statistics, Cancelled> {
    let mut statistics = match T::TYPE.size() {
        1 => of_counts::<T, u8>(samples, control),
        2 => of_counts::<T, u16>(samples, control),
        _ => of_values(samples, control),
    }?;
    let has_any = statistics.histogram.iter().any(|count| *count > 0);
    if has_any {
        statistics.range = statistics.range.map(|stored| rescale.value(stored));
    }
    if rescale.slope < 0.0 {
        statistics.range.reverse();
        statistics.histogram.reverse();
    }
    Ok(statistics)
}

/// Of types with few numbers: one pass counts how often each occurs, the rest follows from that.
fn of_counts<T: Sample, P: Pod + Into<usize>>(
    samples: &[T],
    control: &Control,
) -> Result<Statistics, Cancelled> {
    let numbers = 1usize << (8 * size_of::<P>());
    // Neighbors are often equal; with a table for each of four in a row, none waits for another.
    let mut tables = vec![0u64; 4 * numbers];
    let patterns: &[P] = bytemuck::cast_slice(samples);
    let (fours, rest) = patterns.as_chunks::<4>();
    for &pattern in rest {
        tables[4 * pattern.into()] += 1;
    }
    for fours in fours.chunks(PIECE / 4) {
        control.check()?;
        for four in fours {
            for (table, &pattern) in four.iter().enumerate() {
                tables[4 * pattern.into() + table] += 1;
            }
        }
    }
    let counted = |pattern: usize| -> Option<(f64, u64)> {
        let count = tables[4 * pattern..4 * pattern + 4].iter().sum();
        // On either kind of machine: the low bytes of the pattern are those of the sample.
        let number = match T::TYPE {
            SampleType::I8 => f64::from(pattern as i8),
            SampleType::I16 => f64::from(pattern as i16),
            _ => pattern as f64,
        };
        (count > 0).then_some((number, count))
    };
    let all = || (0..numbers).filter_map(counted);
    let (lo, hi) = all().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), (n, _)| {
        (lo.min(n), hi.max(n))
    });
    let mut bins = Bins::between(lo, hi, T::TYPE);
    for (number, count) in all() {
        bins.add(number, count);
    }
    Ok(Statistics {
        range: [lo, hi],
        histogram: bins.counts,
        not_finite: 0,
    })
}

fn of_values<T: Sample>(samples: &[T], control: &Control) -> Result<Statistics, Cancelled> {
    fn finite<T: Sample>(piece: &[T]) -> impl Iterator<Item = f64> {
        let values = piece.iter().map(|sample| sample.to_f64());
        values.filter(|value| value.is_finite())
    }
    let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut not_finite = 0;
    for piece in samples.chunks(PIECE) {
        control.check()?;
        (lo, hi) = finite(piece).fold((lo, hi), |(lo, hi), v| (lo.min(v), hi.max(v)));
        let has_no_value = |sample: &&T| !sample.to_f64().is_finite();
        not_finite += piece.iter().filter(has_no_value).count() as u64;
    }
    if lo > hi {
        return Ok(Statistics {
            range: [0.0, 0.0],
            histogram: vec![0],
            not_finite,
        });
    }
    let mut bins = Bins::between(lo, hi, T::TYPE);
    for piece in samples.chunks(PIECE) {
        control.check()?;
        finite(piece).for_each(|value| bins.add(value, 1));
    }
    Ok(Statistics {
        range: [lo, hi],
        histogram: bins.counts,
        not_finite,
    })
}

/// A histogram of stored numbers while it is filled.
struct Bins {
    counts: Vec<u64>,
    lo: f64,
    per_unit: f64,
}

impl Bins {
    fn between(lo: f64, hi: f64, sample_type: SampleType) -> Bins {
        let (bins, per_unit) = match sample_type.size() {
            1 => ((hi - lo) as usize + 1, 1.0),
            _ if hi > lo => (Statistics::BINS, Statistics::BINS as f64 / (hi - lo)),
            _ => (Statistics::BINS, 0.0),
        };
        Bins {
            counts: vec![0; bins],
            lo,
            per_unit,
        }
    }

    fn add(&mut self, number: f64, count: u64) {
        let bin = ((number - self.lo) * self.per_unit) as usize;
        let last = self.counts.len() - 1;
        self.counts[bin.min(last)] += count;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quantiles of whole numbers are found by sorting.
    #[test]
    fn quantiles_of_whole_numbers_occur_in_the_data() {
        let bytes: Vec<u8> = (0..1000).map(|i| (i * i % 251) as u8).collect();
        let mut sorted = bytes.clone();
        sorted.sort_unstable();
        for (slope, intercept) in [(1.0, 0.0), (0.5, -3.0)] {
            let rescale = Rescale::new(slope, intercept);
            let statistics = Statistics::of(&Samples::U8(bytes.clone()), rescale);
            for percent in [1, 25, 50, 75, 99] {
                let expected = rescale.value(f64::from(sorted[percent * 10 - 1]));
                let found = statistics.whole_quantile(percent as f64 / 100.0, slope);
                assert_eq!(found, expected, "{percent} %");
            }
        }
        // Few numbers in many bins, and many numbers in few.
        let ids: Vec<u16> = [[0u16; 90], [3; 90], [7; 90]].concat();
        let statistics = Statistics::of(&Samples::U16(ids), Rescale::IDENTITY);
        let found = [0.1, 0.5, 0.9].map(|share| statistics.whole_quantile(share, 1.0));
        assert_eq!(found, [0.0, 3.0, 7.0]);
        let wide: Vec<i16> = (-30_000..30_000).collect();
        let statistics = Statistics::of(&Samples::I16(wide), Rescale::IDENTITY);
        let found = statistics.whole_quantile(0.25, 1.0);
        assert_eq!(found.fract(), 0.0);
        assert!((found + 15_000.0).abs() < 60.0, "{found}");
    }

    /// Counting per number must say what going over the values says.
    #[test]
    fn counted_and_gone_over_agree() {
        fn check<T: Sample, P: Pod + Into<usize>>() {
            for count in [1usize, 3, 4, 1000] {
                let samples: Vec<T> = (0..count)
                    .map(|i| T::from_f64(((i * 7919) % 65_536) as f64 - 30_000.0))
                    .collect();
                let control = &Control::NONE;
                let counted = of_counts::<T, P>(&samples, control);
                assert_eq!(counted, of_values(&samples, control));
            }
        }
        check::<u8, u8>();
        check::<i8, u8>();
        check::<u16, u16>();
        check::<i16, u16>();
    }

    #[test]
    fn a_falling_rescale_turns_range_and_histogram() {
        let samples = Samples::I16(vec![-5, -5, 10]);
        let rescale = Rescale {
            slope: -2.0,
            intercept: 1.0,
        };
        let statistics = Statistics::of(&samples, rescale);
        assert_eq!(statistics.range, [-19.0, 11.0]);
        assert_eq!(statistics.histogram[0], 1);
        assert_eq!(statistics.histogram[Statistics::BINS - 1], 2);
        let floats = Samples::F32(vec![f32::NAN, 1.0, f32::INFINITY]);
        let statistics = Statistics::of(&floats, Rescale::IDENTITY);
        assert_eq!((statistics.range, statistics.not_finite), ([1.0, 1.0], 2));
    }
}
