//! The volume as the host loads it into the memory modules: 16-bit words, and what they mean.

use crate::Error;
use glam::{DAffine3, DVec3};
use std::ops::Range;
use strahl_volume::{SampleType, Volume};

/// 16-bit voxels with their meaning.
#[derive(Clone, Debug)]
pub struct VolumeStore {
    /// Voxels along x, y, z.
    pub dims: [usize; 3],
    /// Stored words, x fastest.
    pub words: Vec<u16>,
    /// Value of the word 0.
    pub offset: f64,
    /// Values per word.
    pub slope: f64,
    /// Smallest and largest value.
    pub range: [f64; 2],
    /// What it is called.
    pub name: String,
    /// Where it lies among meshes: RAS mm → voxel index.
    pub voxel_from_world: DAffine3,
}

impl VolumeStore {
    /// The voxels of a volume. Integers of up to 16 bits are kept as they are (signed ones moved up); others are rounded
    /// to 65,535 steps over the range. Spacing and place matter to meshes only: the processor works in voxels.
    ///
    /// # Errors
    /// If an axis has fewer than 2 voxels.
    pub fn new(volume: &Volume) -> Result<VolumeStore, Error> {
        let dims = volume.grid().dims();
        if let Some(n) = dims.iter().find(|n| **n < 2) {
            let problem = "every axis needs at least 2 voxels to interpolate between";
            return Err(Error::field("volume dims", n, problem));
        }
        let rescale = volume.rescale();
        let samples = volume.samples();
        let (offset, slope, shift) = match volume.sample_type() {
            SampleType::U8 | SampleType::U16 => (rescale.value(0.0), rescale.slope, 0.0),
            SampleType::I8 => (rescale.value(-128.0), rescale.slope, 128.0),
            SampleType::I16 => (rescale.value(-32768.0), rescale.slope, 32768.0),
            _ => {
                let (lo, hi) = finite_range(samples);
                let width = if hi > lo { hi - lo } else { 1.0 };
                let words = (0..samples.len())
                    .map(|i| {
                        let stored = samples.get(i);
                        let stored = if stored.is_finite() { stored } else { lo };
                        ((stored - lo) / width * 65535.0).round() as u16
                    })
                    .collect();
                let offset = rescale.value(lo);
                let slope = rescale.slope * width / 65535.0;
                return Ok(VolumeStore::of_words(volume, words, offset, slope));
            }
        };
        let words = (0..samples.len())
            .map(|i| (samples.get(i) + shift) as u16)
            .collect();
        Ok(VolumeStore::of_words(volume, words, offset, slope))
    }

    fn of_words(volume: &Volume, words: Vec<u16>, offset: f64, slope: f64) -> VolumeStore {
        let (lo, hi) = words
            .iter()
            .fold((u16::MAX, 0), |(lo, hi), w| (lo.min(*w), hi.max(*w)));
        let a = offset + slope * f64::from(lo);
        let b = offset + slope * f64::from(hi);
        VolumeStore {
            dims: volume.grid().dims(),
            words,
            offset,
            slope,
            range: [a.min(b), a.max(b)],
            name: volume.metadata().name.clone(),
            voxel_from_world: volume.grid().voxel_from_world(),
        }
    }

    /// The voxels of a range of an axis, with the range of the whole.
    pub(crate) fn part(&self, axis: usize, range: Range<usize>) -> VolumeStore {
        let stride: usize = self.dims[..axis].iter().product();
        let [length, first] = [self.dims[axis], range.start];
        let blocks = self.words.chunks_exact(stride * length);
        let kept = blocks.flat_map(|block| &block[stride * first..stride * range.end]);
        let mut dims = self.dims;
        dims[axis] = range.len();
        VolumeStore {
            dims,
            words: kept.copied().collect(),
            name: self.name.clone(),
            voxel_from_world: DAffine3::from_translation(-DVec3::AXES[axis] * first as f64)
                * self.voxel_from_world,
            ..*self
        }
    }

    /// The value of a stored word.
    pub fn value(&self, word: u16) -> f64 {
        self.offset + self.slope * f64::from(word)
    }
}

fn finite_range(samples: &strahl_volume::Samples) -> (f64, f64) {
    let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
    for i in 0..samples.len() {
        let value = samples.get(i);
        if value.is_finite() {
            lo = lo.min(value);
            hi = hi.max(value);
        }
    }
    if lo > hi { (0.0, 0.0) } else { (lo, hi) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use strahl_volume::{Grid, Metadata, Rescale, Samples};

    #[test]
    fn values_survive() {
        let grid = Grid::centered([2, 2, 2], glam::DVec3::ONE).unwrap();
        let rescale = Rescale::new(0.5, -10.0);
        let stored = [-32768i16, -1000, -1, 0, 1, 2, 1000, 32767];
        let cases = [
            Samples::I16(stored.to_vec()),
            Samples::F32(stored.map(f32::from).to_vec()),
            Samples::U16(stored.map(|s| s.unsigned_abs()).to_vec()),
            Samples::U8(vec![0, 1, 2, 3, 4, 5, 6, 255]),
        ];
        for samples in cases {
            let volume = Volume::new(grid, samples, rescale, Metadata::default()).unwrap();
            let store = VolumeStore::new(&volume).unwrap();
            for i in 0..8 {
                let value = volume.value(i & 1, i >> 1 & 1, i >> 2);
                assert!((store.value(store.words[i]) - value).abs() <= 0.26, "{i}");
            }
        }
    }
}
