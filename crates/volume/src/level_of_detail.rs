//! Coarser versions of a volume: mip levels, and steps between them (L. Williams 1983).

use crate::rows::for_each_row;
use crate::{Control, Error, Grid, Sample, Samples, Volume, Work, memory, with_samples};
use glam::{DAffine3, DVec3};

impl Volume {
    /// Number of whole levels of detail, level 0 (the volume itself) included: every level has half
    /// the voxels along each axis, rounded down, until one is left.
    pub fn mip_levels(&self) -> usize {
        let longest = self.grid().dims().into_iter().max().unwrap_or(1);
        longest.ilog2() as usize + 1
    }

    /// The volume at a level of detail from 0, the volume itself, to `mip_levels() - 1`.
    ///
    /// A voxel of a whole level is the mean of the 2 × 2 × 2 voxels of the level before. Where the
    /// number n of voxels along an axis is odd, three voxels are weighted so that every voxel has the
    /// same share in the (n − 1)/2 new ones (S. Guthe, P. Heckbert 2005, *Non-power-of-two
    /// mipmapping*). The new grid places every voxel at the center of what it is the mean of. So
    /// means stay, linear ramps stay where they are in the world, and the extent shrinks by
    /// 1/n of a voxel at an odd n, else not at all. An axis of one voxel stays as it is.
    ///
    /// A level between two whole ones lies on the grid of the finer: its voxels are mixed, by the
    /// fraction, with the coarser level at the same place, interpolated there trilinearly.
    ///
    /// Samples keep their type, rounded to even, and their rescale. Voxels that are not finite have no
    /// part in a mean; where all are, the new voxel is NaN. Not for object ids, whose mean is no object.
    ///
    /// # Errors
    /// A level outside 0 to `mip_levels() - 1`.
    pub fn at_level(&self, level: f64) -> Result<Volume, Error> {
        self.at_level_under(level, &Control::NONE)
    }

    /// The same under `control`, with its values counted.
    ///
    /// # Errors
    /// As [`at_level`](Volume::at_level); it was cancelled.
    pub fn at_level_under(&self, level: f64, control: &Control) -> Result<Volume, Error> {
        let last = self.mip_levels() - 1;
        // NaN is in no range.
        if !(0.0..=last as f64).contains(&level) {
            return Err(Error::field(
                "level of detail",
                level,
                format!("0 to {last} for {:?} voxels", self.grid().dims()),
            ));
        }
        if level == 0.0 {
            return Ok(self.clone());
        }
        let (mut grid, mut samples) = (*self.grid(), None);
        for _ in 0..level as usize {
            let finer = samples.as_ref().unwrap_or(self.samples());
            (grid, samples) =
                halved(&grid, finer, control).map(|(grid, halves)| (grid, Some(halves)))?;
        }
        let fraction = level.fract();
        if fraction > 0.0 {
            let finer = samples.as_ref().unwrap_or(self.samples());
            let (_, coarser) = halved(&grid, finer, control)?;
            let dims = grid.dims();
            let finer =
                with_samples!(finer, finer => mixed(dims, finer, &coarser, fraction, control)?);
            samples = Some(finer);
        }
        let mut metadata = self.metadata().clone();
        metadata
            .entries
            .push(("level of detail".into(), level.to_string()));
        let samples = samples.unwrap_or_else(|| self.samples().clone());
        let volume = Volume::new(grid, samples, self.rescale(), metadata)?;
        volume.statistics_under(control)?;
        Ok(volume)
    }
}

/// The shares that up to three voxels of a finer axis have in one of the next level.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Shares {
    /// The first of the finer voxels.
    first: usize,
    /// Sum 1; the third is 0 where two have a part, the last two where one has.
    weights: [f64; 3],
    count: usize,
}

/// The next level of an axis of `n` voxels: the shares, and where voxel 0 lies and how far apart voxels
/// are, both in finer voxels.
fn halved_axis(n: usize) -> (Vec<Shares>, f64, f64) {
    let length = n as f64;
    match (n, n % 2) {
        (1, _) => {
            let all = Shares {
                first: 0,
                weights: [1.0, 0.0, 0.0],
                count: 1,
            };
            (vec![all], 0.0, 1.0)
        }
        (_, 0) => {
            let pair = |i| Shares {
                first: 2 * i,
                weights: [0.5, 0.5, 0.0],
                count: 2,
            };
            ((0..n / 2).map(pair).collect(), 0.5, 2.0)
        }
        _ => {
            let m = n / 2;
            let three = |i| Shares {
                first: 2 * i,
                weights: [(m - i) as f64, m as f64, (1 + i) as f64].map(|w| w / length),
                count: 3,
            };
            // The center of gravity of voxel i is (m + 2)/n + i·(2 + 2/n).
            let start = (m + 2) as f64 / length;
            ((0..m).map(three).collect(), start, 2.0 + 2.0 / length)
        }
    }
}

fn halved(grid: &Grid, samples: &Samples, control: &Control) -> Result<(Grid, Samples), Error> {
    let axes = grid.dims().map(halved_axis);
    let [start, step] = [
        DVec3::from_array(axes.each_ref().map(|(_, start, _)| *start)),
        DVec3::from_array(axes.each_ref().map(|(_, _, step)| *step)),
    ];
    let finer_from_coarser =
        DAffine3::from_scale_rotation_translation(step, glam::DQuat::IDENTITY, start);
    let dims = axes.each_ref().map(|(shares, ..)| shares.len());
    let coarser = Grid::new(dims, grid.world_from_voxel() * finer_from_coarser)?;
    let shares = axes.map(|(shares, ..)| shares);
    let samples = with_samples!(samples, samples => means(grid.dims(), samples, &shares, control)?);
    Ok((coarser, samples))
}

fn means<T: Sample>(
    dims: [usize; 3],
    finer: &[T],
    shares: &[Vec<Shares>; 3],
    control: &Control,
) -> Result<Samples, Error> {
    let [nx, ny, _] = dims;
    let [xs, ys, zs] = shares;
    let row = |row: usize, out: &mut [T]| {
        let (y, z) = (ys[row % ys.len()], zs[row / ys.len()]);
        for (out, x) in out.iter_mut().zip(xs) {
            let (mut sum, mut weight) = (0.0, 0.0);
            for (dz, wz) in z.weights[..z.count].iter().enumerate() {
                for (dy, wy) in y.weights[..y.count].iter().enumerate() {
                    let at = x.first + nx * (y.first + dy + ny * (z.first + dz));
                    for (value, wx) in finer[at..at + x.count].iter().zip(x.weights) {
                        let (value, w) = (value.to_f64(), wx * wy * wz);
                        if value.is_finite() {
                            sum += w * value;
                            weight += w;
                        }
                    }
                }
            }
            *out = rounded(if weight > 0.0 { sum / weight } else { f64::NAN });
        }
    };
    rows(xs.len(), ys.len() * zs.len(), control, row)
}

/// Each voxel of the finer level and the coarser level at its place, mixed by `fraction`.
fn mixed<T: Sample>(
    dims: [usize; 3],
    finer: &[T],
    coarser: &Samples,
    fraction: f64,
    control: &Control,
) -> Result<Samples, Error> {
    let Some(coarser) = T::of(coarser) else {
        unreachable!("levels of a volume have its sample type");
    };
    // Per axis: the two coarser voxels around each finer one, and the share of the second.
    let around = dims.map(|n| {
        let (shares, start, step) = halved_axis(n);
        let last = shares.len() - 1;
        let place = |i: usize| {
            let at = ((i as f64 - start) / step).clamp(0.0, last as f64);
            let low = (at as usize).min(last);
            (low, (low + 1).min(last), at - low as f64)
        };
        (0..n).map(place).collect::<Vec<_>>()
    });
    let [cx, cy, _] = dims.map(|n| (n / 2).max(1));
    let [nx, ny, nz] = dims;
    let row = |row: usize, out: &mut [T]| {
        let (y, z) = (around[1][row % ny], around[2][row / ny]);
        for (x, out) in out.iter_mut().enumerate() {
            let place = around[0][x];
            let (mut sum, mut weight) = (0.0, 0.0);
            for corner in 0..8 {
                let pick = |bit: usize, (low, high, share): (usize, usize, f64)| {
                    if corner >> bit & 1 == 0 {
                        (low, 1.0 - share)
                    } else {
                        (high, share)
                    }
                };
                let ((x, wx), (y, wy), (z, wz)) = (pick(0, place), pick(1, y), pick(2, z));
                let value = coarser[x + cx * (y + cy * z)].to_f64();
                let w = wx * wy * wz;
                if value.is_finite() && w > 0.0 {
                    sum += w * value;
                    weight += w;
                }
            }
            let own = finer[x + nx * row].to_f64();
            let coarse = sum / weight;
            *out = rounded(match (own.is_finite(), coarse.is_finite()) {
                (true, true) => own + (coarse - own) * fraction,
                (true, false) => own,
                (false, true) => coarse,
                (false, false) => f64::NAN,
            });
        }
    };
    rows(nx, ny * nz, control, row)
}

/// To even, so that means of many levels do not creep upwards.
fn rounded<T: Sample>(value: f64) -> T {
    T::from_f64(if T::TYPE.is_integer() {
        value.round_ties_even()
    } else {
        value
    })
}

/// `count` rows of `length` samples, each made by `row`.
fn rows<T: Sample>(
    length: usize,
    count: usize,
    control: &Control,
    row: impl Fn(usize, &mut [T]) + Sync,
) -> Result<Samples, Error> {
    let mut samples = memory::zeroed::<T>(length * count)?;
    for_each_row(
        &mut samples,
        length,
        &control.parts(Work::Reading, count),
        row,
    )?;
    Ok(T::wrap(samples))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Metadata, Rescale, SampleType};
    use glam::DMat3;

    /// An oblique, sheared grid, so that no two axes can be confused.
    fn grid(dims: [usize; 3]) -> Grid {
        let matrix = DMat3::from_rotation_z(0.4)
            * DMat3::from_cols(
                DVec3::new(0.7, 0.1, 0.0),
                DVec3::new(0.0, -1.3, 0.2),
                DVec3::new(0.0, 0.0, 2.1),
            );
        let map = DAffine3::from_mat3_translation(matrix, DVec3::new(-40.0, 7.0, 300.0));
        Grid::new(dims, map).unwrap()
    }

    fn volume(dims: [usize; 3], value: impl Fn(DVec3) -> f64, sample_type: SampleType) -> Volume {
        let grid = grid(dims);
        let count = grid.voxel_count();
        let [nx, ny, _] = dims;
        let values: Vec<f64> = (0..count)
            .map(|i| {
                let voxel = [i % nx, i / nx % ny, i / nx / ny].map(|c| c as f64);
                value(grid.world_from_voxel().transform_point3(voxel.into()))
            })
            .collect();
        let samples = match sample_type {
            SampleType::F64 => Samples::F64(values),
            SampleType::U8 => Samples::U8(values.into_iter().map(u8::from_f64).collect()),
            _ => Samples::I16(values.into_iter().map(i16::from_f64).collect()),
        };
        let rescale = Rescale::new(2.0, -5.0);
        Volume::new(grid, samples, rescale, Metadata::default()).unwrap()
    }

    fn mean(volume: &Volume) -> f64 {
        let samples = volume.samples();
        (0..samples.len()).map(|i| samples.get(i)).sum::<f64>() / samples.len() as f64
    }

    fn noise(p: DVec3) -> f64 {
        127.0 + 100.0 * (p.x * 3.1).sin() * (p.y * 1.7).cos() * (p.z * 0.9).sin()
    }

    const DIMS: [[usize; 3]; 5] = [[8, 16, 4], [7, 5, 3], [13, 8, 1], [1, 1, 1], [33, 2, 6]];

    #[test]
    fn level_0_is_the_volume_itself() {
        let volume = volume([7, 5, 3], noise, SampleType::U8);
        let same = volume.at_level(0.0).unwrap();
        assert_eq!(same.samples(), volume.samples());
        assert_eq!(same.grid(), volume.grid());
        assert_eq!(same.metadata(), volume.metadata());
    }

    #[test]
    fn levels_halve_down_to_one_voxel() {
        for (dims, levels) in DIMS.into_iter().zip([5, 3, 4, 1, 6]) {
            let volume = volume(dims, noise, SampleType::I16);
            assert_eq!(volume.mip_levels(), levels, "{dims:?}");
            let mut expected = dims;
            for level in 0..levels {
                let level = volume.at_level(level as f64).unwrap();
                assert_eq!(level.grid().dims(), expected);
                assert_eq!(level.sample_type(), SampleType::I16);
                assert_eq!(level.rescale(), volume.rescale());
                expected = expected.map(|n| (n / 2).max(1));
            }
            for wrong in [-0.1, levels as f64, levels as f64 - 0.9, f64::NAN] {
                let error = volume.at_level(wrong).unwrap_err().to_string();
                assert!(error.contains("level of detail"), "{error}");
            }
        }
    }

    #[test]
    fn whole_levels_keep_the_mean() {
        for dims in DIMS {
            let volume = volume(dims, noise, SampleType::F64);
            for level in 0..volume.mip_levels() {
                let found = mean(&volume.at_level(level as f64).unwrap());
                assert!(
                    (found - mean(&volume)).abs() < 1e-9,
                    "{dims:?} {level}: {found}"
                );
            }
        }
        // Rounding does not creep: half a number at most, at any level.
        let bytes = volume([64, 64, 64], noise, SampleType::U8);
        let found = mean(&bytes.at_level(5.0).unwrap());
        assert!(
            (found - mean(&bytes)).abs() < 0.2,
            "{found} {}",
            mean(&bytes)
        );
    }

    #[test]
    fn ramps_stay_where_they_are_in_the_world() {
        let ramp = |p: DVec3| 3.0 * p.x - 2.0 * p.y + 0.5 * p.z;
        for dims in DIMS {
            let volume = volume(dims, ramp, SampleType::F64);
            for level in 1..volume.mip_levels() {
                let level = volume.at_level(level as f64).unwrap();
                let [nx, ny, nz] = level.grid().dims();
                for (x, y, z) in [(0, 0, 0), (nx - 1, 0, nz / 2), (nx / 2, ny - 1, nz - 1)] {
                    let voxel = DVec3::new(x as f64, y as f64, z as f64);
                    let world = level.grid().world_from_voxel().transform_point3(voxel);
                    let found = level.samples().get(level.grid().index(x, y, z));
                    assert!(
                        (found - ramp(world)).abs() < 1e-9,
                        "{dims:?} {voxel}: {found}"
                    );
                }
            }
        }
    }

    /// The extent shrinks by half of 1/n voxels at either end of an odd axis, and stays at an even one.
    #[test]
    fn extents_stay() {
        for dims in [[8, 4, 2], [9, 7, 5]] {
            let volume = volume(dims, noise, SampleType::U8);
            let level = volume.at_level(1.0).unwrap();
            assert!(level.grid().center_mm().distance(volume.grid().center_mm()) < 1e-9);
            let size = |grid: &Grid| {
                let n = DVec3::from_array(grid.dims().map(|n| n as f64));
                n * grid.spacing_mm() / volume.grid().spacing_mm()
            };
            let lost = size(volume.grid()) - size(level.grid());
            for axis in 0..3 {
                let n = dims[axis] as f64;
                let expected = if dims[axis] % 2 == 1 { 1.0 / n } else { 0.0 };
                assert!((lost[axis] - expected).abs() < 1e-9, "{dims:?}: {lost}");
            }
        }
    }

    #[test]
    fn between_levels_values_are_mixed_on_the_finer_grid() {
        let ramp = |p: DVec3| p.x + p.z;
        let volume = volume([16, 9, 8], ramp, SampleType::F64);
        let between = volume.at_level(1.25).unwrap();
        let finer = volume.at_level(1.0).unwrap();
        assert_eq!(between.grid(), finer.grid());
        // Inside, both levels say the same of a ramp.
        for (x, y, z) in [(1, 1, 1), (4, 2, 2), (6, 1, 1)] {
            assert!((between.value(x, y, z) - finer.value(x, y, z)).abs() < 1e-9);
        }
        // A single bright voxel of 4 × 1 × 1: [0, 8 | 0, 0] becomes [4, 0] at −0.25, 0.25, 0.75, 1.25.
        let grid = Grid::centered([4, 1, 1], DVec3::ONE).unwrap();
        let samples = Samples::F32(vec![0.0, 8.0, 0.0, 0.0]);
        let single = Volume::new(grid, samples, Rescale::IDENTITY, Metadata::default()).unwrap();
        let found = single.at_level(0.5).unwrap();
        assert_eq!(found.samples(), &Samples::F32(vec![2.0, 5.5, 0.5, 0.0]));
    }

    #[test]
    fn voxels_that_are_not_finite_have_no_part() {
        let grid = Grid::centered([4, 1, 1], DVec3::ONE).unwrap();
        let samples = Samples::F32(vec![f32::NAN, 6.0, f32::INFINITY, f32::NAN]);
        let volume = Volume::new(grid, samples, Rescale::IDENTITY, Metadata::default()).unwrap();
        let level = volume.at_level(1.0).unwrap();
        assert_eq!(level.samples().get(0), 6.0);
        assert!(level.samples().get(1).is_nan());
        let between = volume.at_level(0.5).unwrap();
        assert_eq!(between.samples().get(1), 6.0);
        assert!(between.samples().get(3).is_nan());
    }
}
