//! B-spline coefficients: a cubic B-spline of these numbers goes through the values of the voxels.
//!
//! A cubic B-spline of the values themselves smooths: at a voxel it is the mean of the voxel and its
//! neighbors with the weights 1/6, 4/6, 1/6. The coefficients undo that, by one recursive filter along
//! each axis in either direction: M. Unser, A. Aldroubi, M. Eden, *Fast B-spline transforms for continuous
//! image representation and interpolation*, 1991, and *B-spline signal processing*, 1993; pole √3 − 2,
//! gain 6.
//!
//! At the border coefficients go on mirrored about the face of the outermost voxel (… b a | a b …).
//! Inside the hull of the voxel centers a cubic B-spline reaches one coefficient beyond, which then is
//! the outermost one: what a sampler that clamps its indices reads. So it is exact at the border too,
//! with clamped sampling. Mirroring about the center of the voxel (… c b | a b c …), as in the papers, would
//! be off by up to a third of the difference there.

use crate::rows::for_each_row;
use crate::{
    Cancelled, ContentId, Control, Error, ErrorKind, Key, Metadata, Rescale, Sample, Samples,
    Volume, Work, cores, memory, with_samples,
};

/// √3 − 2.
const POLE: f64 = -0.267_949_192_431_122_7;
/// (1 − pole)·(1 − 1/pole).
const GAIN: f64 = 6.0;
/// Powers of the pole beyond are below f32 and f64 alike: 0.268^32 is 5e-19.
const HORIZON: usize = 32;

impl Volume {
    /// The coefficients of the cubic B-spline that goes through the values, as a volume of f32 on the
    /// same grid, in values (rescale 1 and 0). On all cores (feature `threads`).
    ///
    /// A voxel without a value (NaN, infinite) has no coefficient. The coefficients around it are those of a volume in
    /// which the value before it, in the order of memory, is repeated.
    ///
    /// # Errors
    /// Values too large for f32, since each would spoil the lines through it. No memory.
    pub fn b_spline_coefficients(&self) -> Result<Volume, Error> {
        self.b_spline_coefficients_under(&Control::NONE)
    }

    /// The same under `control`.
    ///
    /// # Errors
    /// As [`b_spline_coefficients`](Volume::b_spline_coefficients); it was cancelled.
    pub fn b_spline_coefficients_under(&self, control: &Control) -> Result<Volume, Error> {
        let statistics = self.statistics_under(control)?;
        let [lo, hi] = statistics.range;
        let largest = lo.abs().max(hi.abs());
        // Coefficients are up to three times the values along each axis.
        let limit = f64::from(f32::MAX) / 27.0;
        if largest > limit {
            return Err(ErrorKind::Unsupported {
                feature: format!("a prefilter for a volume with values up to {largest:e}"),
                instead: "replace such voxels, or use the B-spline without prefilter".into(),
            }
            .into());
        }
        let count = self.samples().len();
        let mut coefficients: Vec<f32> = memory::reserved(count)?;
        if let Err(cancelled) = self.fill_with_coefficients(&mut coefficients, control) {
            cores::free(coefficients);
            return Err(cancelled.into());
        }
        let metadata = Metadata {
            name: self.metadata().name.clone(),
            format: self.metadata().format.clone(),
            value_unit: self.metadata().value_unit.clone(),
            has_length_unit: self.metadata().has_length_unit,
            ..Metadata::default()
        };
        Volume::new(
            *self.grid(),
            Samples::F32(coefficients),
            Rescale::IDENTITY,
            metadata,
        )
    }

    /// Cancelled, it leaves anything.
    fn fill_with_coefficients(
        &self,
        coefficients: &mut Vec<f32>,
        control: &Control,
    ) -> Result<(), Cancelled> {
        let rescale = self.rescale();
        with_samples!(self.samples(), samples => for samples in samples.chunks(PIECE) {
            control.check()?;
            coefficients.extend(samples.iter().map(|s| rescale.value(s.to_f64()) as f32));
        });
        let lacks_values = self.statistics().not_finite > 0;
        if lacks_values {
            repeat_where_missing(coefficients);
        }
        let [nx, ny, nz] = self.grid().dims();
        along(coefficients, nx, 1, control)?;
        along(coefficients, ny, nx, control)?;
        along(coefficients, nz, nx * ny, control)?;
        if lacks_values {
            with_samples!(self.samples(), samples => {
                for (coefficient, sample) in coefficients.iter_mut().zip(samples.iter()) {
                    if !rescale.value(sample.to_f64()).is_finite() {
                        *coefficient = f32::NAN;
                    }
                }
            });
        }
        Ok(())
    }
}

/// Replaces what is not finite by the number before it, or by the first finite number.
fn repeat_where_missing(numbers: &mut [f32]) {
    let first = numbers.iter().copied().find(|number| number.is_finite());
    let mut last = first.unwrap_or(0.0);
    for number in numbers {
        if number.is_finite() {
            last = *number;
        }
        *number = last;
    }
}

/// Key of the [`b_spline_coefficients`](Volume::b_spline_coefficients) of a volume.
#[derive(Clone, Debug, PartialEq)]
pub struct CoefficientsKey(pub ContentId);

impl Key for CoefficientsKey {
    type Value = Volume;

    const NAME: &str = "B-spline coefficients";

    fn bytes(&self, value: &Volume) -> usize {
        value.samples().as_bytes().len()
    }
}

/// Filters along the axis of `n` numbers that lie `stride` apart.
fn along(numbers: &mut [f32], n: usize, stride: usize, control: &Control) -> Result<(), Cancelled> {
    if n == 1 {
        return Ok(());
    }
    let blocks = numbers.len() / (n * stride);
    let parts = control.parts(Work::Preparing, blocks);
    for_each_row(numbers, n * stride, &parts, |_, block| {
        filter(block, n, stride, control);
    })
}

/// Numbers after which somebody looks at the control.
const PIECE: usize = 1 << 18;

/// Filters `stride` lines that lie side by side: number k of line i is at i + stride·k. Whole rows of
/// lines go at once, in the order of memory. Cancelled, it leaves anything.
fn filter(block: &mut [f32], n: usize, stride: usize, control: &Control) {
    // Short blocks are done before it matters.
    let is_long = block.len() > PIECE;
    let is_cancelled = || is_long && control.is_cancelled();
    // Causal: c⁺(k) = 6·s(k) + pole·c⁺(k − 1). What comes before the first number is the mirrored
    // rest of the line; with period 2n its sum is that of one period over 1 − pole^2n.
    let period = 1.0 - POLE.powi(2 * n as i32);
    let mut first: Vec<f64> = vec![0.0; stride];
    let mut add = |k: usize, weight: f64| {
        let row = &block[k * stride..(k + 1) * stride];
        for (sum, &number) in first.iter_mut().zip(row) {
            *sum += weight * f64::from(number);
        }
    };
    for k in 0..n.min(HORIZON) {
        if is_cancelled() {
            return;
        }
        add(k, POLE.powi(k as i32 + 1) / period);
        add(n - 1 - k, POLE.powi((n + k) as i32 + 1) / period);
    }
    add(0, 1.0);
    for (number, sum) in block[..stride].iter_mut().zip(&first) {
        *number = (GAIN * sum) as f32;
    }
    for k in 1..n {
        if is_cancelled() {
            return;
        }
        let (before, now) = block.split_at_mut(k * stride);
        let before = &before[(k - 1) * stride..];
        row_by_row(&mut now[..stride], before, |now, before| {
            (GAIN * now + POLE * before) as f32
        });
    }
    // Anticausal: c(k) = pole·(c(k + 1) − c⁺(k)), and at the mirrored end c = c⁺·pole/(pole − 1).
    for number in &mut block[(n - 1) * stride..] {
        *number = (f64::from(*number) * (POLE / (POLE - 1.0))) as f32;
    }
    for k in (0..n - 1).rev() {
        if is_cancelled() {
            return;
        }
        let (now, after) = block.split_at_mut((k + 1) * stride);
        row_by_row(&mut now[k * stride..], &after[..stride], |now, after| {
            (POLE * (after - now)) as f32
        });
    }
}

fn row_by_row(row: &mut [f32], other: &[f32], step: impl Fn(f64, f64) -> f32 + Sync) {
    let part = |row: &mut [f32], other: &[f32]| {
        for (number, &other) in row.iter_mut().zip(other) {
            *number = step(f64::from(*number), f64::from(other));
        }
    };
    // Whole slices, along z, where there is one block only.
    #[cfg(feature = "threads")]
    if row.len() >= 1 << 15 {
        use rayon::prelude::*;
        let parts = row.par_chunks_mut(1 << 13).zip(other.par_chunks(1 << 13));
        return parts.for_each(|(row, other)| part(row, other));
    }
    part(row, other);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Grid, Phantom};
    use glam::DVec3;

    /// The cubic B-spline of `volume` at a place in voxels, with clamped indices.
    fn b_spline(volume: &Volume, at: [f64; 3]) -> f64 {
        let dims = volume.grid().dims();
        let weights = |t: f64| {
            let u = 1.0 - t;
            [
                u * u * u / 6.0,
                2.0 / 3.0 - 0.5 * t * t * (2.0 - t),
                2.0 / 3.0 - 0.5 * u * u * (2.0 - u),
                t * t * t / 6.0,
            ]
        };
        let mut sum = 0.0;
        let floors = at.map(f64::floor);
        let [wx, wy, wz] = [0, 1, 2].map(|axis| weights(at[axis] - floors[axis]));
        let index = |axis: usize, tap: usize| {
            (floors[axis] + tap as f64 - 1.0).clamp(0.0, dims[axis] as f64 - 1.0) as usize
        };
        for (z, wz) in wz.into_iter().enumerate() {
            for (y, wy) in wy.into_iter().enumerate() {
                for (x, wx) in wx.into_iter().enumerate() {
                    let value = volume.value(index(0, x), index(1, y), index(2, z));
                    sum += wx * wy * wz * value;
                }
            }
        }
        sum
    }

    fn noise(dims: [usize; 3]) -> Volume {
        let mut state = 1u32;
        let samples = (0..dims.iter().product())
            .map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (state >> 16) as i16
            })
            .collect();
        let grid = Grid::centered(dims, DVec3::ONE).unwrap();
        let rescale = Rescale::new(-0.5, 100.0);
        Volume::new(grid, Samples::I16(samples), rescale, Metadata::default()).unwrap()
    }

    /// White noise is the hardest: all of it is at high frequencies. Every voxel, the border too.
    #[test]
    fn the_spline_goes_through_the_voxels() {
        for dims in [
            [1, 1, 1],
            [2, 1, 3],
            [5, 4, 3],
            [40, 7, 2],
            [3, 70, 33],
            [200, 190, 3],
        ] {
            let volume = noise(dims);
            let coefficients = volume.b_spline_coefficients().unwrap();
            assert_eq!(coefficients.rescale(), Rescale::IDENTITY);
            let [lo, hi] = volume.statistics().range;
            let tolerance = 1e-5 * lo.abs().max(hi.abs());
            for z in 0..dims[2] {
                for y in 0..dims[1] {
                    for x in 0..dims[0] {
                        let found = b_spline(&coefficients, [x, y, z].map(|c| c as f64));
                        let expected = volume.value(x, y, z);
                        assert!(
                            (found - expected).abs() <= tolerance,
                            "{dims:?} ({x}, {y}, {z}): {found}, not {expected}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn a_constant_stays() {
        let grid = Grid::centered([9, 3, 5], DVec3::ONE).unwrap();
        let samples = Samples::U8(vec![200; 135]);
        let volume = Volume::new(grid, samples, Rescale::IDENTITY, Metadata::default()).unwrap();
        let coefficients = volume.b_spline_coefficients().unwrap();
        let [lo, hi] = coefficients.statistics().range;
        assert!(
            (lo - 200.0).abs() < 1e-4 && (hi - 200.0).abs() < 1e-4,
            "{lo} {hi}"
        );
    }

    /// Between voxels too: the spline of the coefficients of a smooth field is nearer to it than the
    /// smoothing spline of its values.
    #[test]
    fn a_smooth_field_is_met_between_voxels() {
        let field = Phantom::MarschnerLobb;
        let volume = field.volume([41, 41, 41]).unwrap();
        let coefficients = volume.b_spline_coefficients().unwrap();
        let error = |volume: &Volume| {
            let mut sum = 0.0;
            for i in 0..500 {
                let part = |step: usize| 5.0 + (i * step % 311) as f64 / 311.0 * 30.0;
                let at = [part(7), part(17), part(29)];
                let world = volume.grid().world_from_voxel().transform_point3(at.into());
                sum += (b_spline(volume, at) - field.value(world)).powi(2);
            }
            sum.sqrt()
        };
        let (with, without) = (error(&coefficients), error(&volume));
        assert!(with < 0.5 * without, "{with} {without}");
    }

    /// Without a value there is no coefficient, and the spline goes through all voxels whose neighbors have a value.
    #[test]
    fn voxels_without_value_have_no_coefficient() {
        let dims = [40, 20, 12];
        let whole = noise(dims);
        let values = |bad: f32| {
            let values = (0..whole.samples().len()).map(|i| {
                let value = whole.rescale().value(whole.samples().get(i)) as f32;
                if i % dims[0] < 3 { bad } else { value }
            });
            let samples = Samples::F32(values.collect());
            Volume::new(
                *whole.grid(),
                samples,
                Rescale::IDENTITY,
                Metadata::default(),
            )
            .unwrap()
        };
        for bad in [f32::NAN, f32::INFINITY] {
            let coefficients = values(bad).b_spline_coefficients().unwrap();
            let [lo, hi] = whole.statistics().range;
            let tolerance = 1e-5 * lo.abs().max(hi.abs());
            for x in 0..dims[0] {
                let found = coefficients.value(x, 9, 5);
                assert_eq!(found.is_nan(), x < 3, "{x}");
                if x > 3 {
                    let found = b_spline(&coefficients, [x as f64, 9.0, 5.0]);
                    let expected = whole.value(x, 9, 5);
                    assert!((found - expected).abs() <= tolerance, "{x}: {found}");
                }
            }
        }
        let grid = Grid::centered([2, 1, 1], DVec3::ONE).unwrap();
        let samples = Samples::F32(vec![f32::NAN; 2]);
        let none = Volume::new(grid, samples, Rescale::IDENTITY, Metadata::default()).unwrap();
        assert_eq!(
            none.b_spline_coefficients()
                .unwrap()
                .statistics()
                .not_finite,
            2
        );
        let samples = Samples::F32(vec![1.0, f32::MAX]);
        let large = Volume::new(grid, samples, Rescale::IDENTITY, Metadata::default()).unwrap();
        let message = large.b_spline_coefficients().unwrap_err().to_string();
        assert!(message.contains("e38"), "{message}");
    }
}
