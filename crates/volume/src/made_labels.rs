//! Label volumes that are made from other volumes: from masks, and from intervals of values.

use crate::error::Error;
use crate::{
    Control, Grid, Label, LabelVolume, Metadata, Rescale, Sample, Samples, Volume, memory,
    with_samples,
};

/// Most masks that one label volume is made of.
const MOST_MASKS_OF_LABELS: usize = u16::MAX as usize;

/// Most thresholds between layers of values.
pub const MOST_THRESHOLDS: usize = u8::MAX as usize;

/// Samples between two looks at whether the work is still wanted.
const AT_ONCE: usize = 1 << 16;

/// Binary masks on one grid that become the labels 1, 2, …, in the order in which they are added. Only their ids are kept.
#[derive(Debug)]
pub struct MergedMasks {
    grid: Grid,
    ids: Vec<u16>,
    count: u16,
    overlaps: u64,
}

impl MergedMasks {
    /// No mask yet.
    ///
    /// # Errors
    /// The ids do not fit into memory.
    pub fn new(grid: &Grid) -> Result<MergedMasks, Error> {
        let mut ids = memory::reserved(grid.voxel_count())?;
        ids.resize(grid.voxel_count(), 0);
        Ok(MergedMasks {
            grid: *grid,
            ids,
            count: 0,
            overlaps: 0,
        })
    }

    /// Adds the voxels that are not 0 in `mask`, with the next id. `name` and `first` are what messages call this mask and the
    /// first one.
    ///
    /// # Errors
    /// The mask is on another grid, or there are too many; it has two values other than 0, or one that is no number.
    pub fn add(&mut self, mask: &Volume, name: &str, first: &str) -> Result<(), Error> {
        self.add_or_values(mask, name, first)?
            .map_err(|[one, two]| {
                let value = match two.is_nan() {
                    true => "no numbers".to_owned(),
                    false => format!("{one} and {two}"),
                };
                let what = format!("values of the mask {name}");
                Error::field(what, value, "0 and one other value")
            })
    }

    /// As `add`; in place of an error, two values of what is no mask.
    pub(crate) fn add_or_values(
        &mut self,
        mask: &Volume,
        name: &str,
        first: &str,
    ) -> Result<Result<(), [f64; 2]>, Error> {
        if usize::from(self.count) == MOST_MASKS_OF_LABELS {
            let there = MOST_MASKS_OF_LABELS + 1;
            let allowed = format!("up to {MOST_MASKS_OF_LABELS}");
            return Err(Error::field("the number of masks", there, allowed));
        }
        if !self
            .grid
            .matches(mask.grid(), 0.1 * self.grid.min_spacing_mm())
        {
            return Err(other_grid(name, first, mask.grid(), &self.grid));
        }
        self.count += 1;
        let (id, ids) = (self.count, &mut self.ids);
        let added = with_samples!(mask.samples(), samples => add(samples, mask.rescale(), id, ids));
        Ok(added.map(|overlaps| self.overlaps += overlaps))
    }

    /// How many voxels were in a mask and are in a later one, which they belong to.
    pub fn overlaps(&self) -> u64 {
        self.overlaps
    }

    /// The ids, in as few bytes as they need.
    ///
    /// # Errors
    /// Never: there is an id for each voxel.
    pub fn into_volume(self, metadata: Metadata) -> Result<Volume, Error> {
        let samples = match self.count <= u8::MAX.into() {
            true => Samples::U8(self.ids.into_iter().map(|id| id as u8).collect()),
            false => Samples::U16(self.ids),
        };
        Volume::new(self.grid, samples, Rescale::IDENTITY, metadata)
    }
}

/// Sets the id of the voxels in a mask. Returns how many had another one, or two different values
/// that are not 0.
fn add<T: Sample>(
    samples: &[T],
    rescale: Rescale,
    id: u16,
    ids: &mut [u16],
) -> Result<u64, [f64; 2]> {
    let mut inside = None;
    let mut overlaps = 0;
    let mut at = 0;
    for run in samples.chunk_by(|a, b| a == b) {
        let ids = &mut ids[at..at + run.len()];
        at += run.len();
        let value = rescale.value(run[0].to_f64());
        if value == 0.0 {
            continue;
        }
        let inside = *inside.get_or_insert(value);
        // NaN is not equal to itself.
        if value != inside || value.is_nan() {
            return Err([inside, value]);
        }
        overlaps += ids.iter().filter(|id| **id != 0).count() as u64;
        ids.fill(id);
    }
    Ok(overlaps)
}

fn other_grid(name: &str, first: &str, grid: &Grid, other: &Grid) -> Error {
    let describe = |grid: &Grid| {
        let [x, y, z] = grid.dims();
        let affine = crate::grid::rows(&grid.world_from_voxel());
        format!("{x}×{y}×{z} voxels, world_from_voxel {affine}")
    };
    Error::field(
        format!("the grid of {name}"),
        describe(grid),
        format!("the grid of {first}: {}", describe(other)),
    )
}

impl LabelVolume {
    /// The layers of values of `volume`: the id of a voxel is the number of `thresholds` that its value reaches, so 0 is what lies
    /// below the first, or is no number. Values that no layer has keep their id all the same.
    ///
    /// # Errors
    /// `thresholds` that do not ascend, or more than [`MOST_THRESHOLDS`]; an id named twice in `labels`; memory; `control` cancelled it.
    pub fn of_layers(
        volume: &Volume,
        thresholds: &[f64],
        labels: Vec<Label>,
        control: &Control,
    ) -> Result<LabelVolume, Error> {
        let ascends = thresholds.is_sorted_by(|a, b| a < b);
        if !ascends || thresholds.len() > MOST_THRESHOLDS {
            let allowed = format!("up to {MOST_THRESHOLDS} ascending numbers");
            return Err(Error::field(
                "thresholds",
                format!("{thresholds:?}"),
                allowed,
            ));
        }
        let rescale = volume.rescale();
        let ids = with_samples!(volume.samples(), samples => layers(samples, rescale, thresholds, control))?;
        let (grid, metadata) = (*volume.grid(), Metadata::default());
        let ids = Volume::new(grid, Samples::U8(ids), Rescale::IDENTITY, metadata)?;
        LabelVolume::from_volume(ids, labels)
    }
}

fn layers<T: Sample>(
    samples: &[T],
    rescale: Rescale,
    thresholds: &[f64],
    control: &Control,
) -> Result<Vec<u8>, Error> {
    let mut ids = memory::reserved(samples.len())?;
    for part in samples.chunks(AT_ONCE) {
        control.check()?;
        ids.extend(part.iter().map(|sample| {
            let value = rescale.value(sample.to_f64());
            // Comparisons with what is no number are false.
            thresholds.iter().filter(|t| value >= **t).count() as u8
        }));
    }
    Ok(ids)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn volume(samples: Samples, rescale: Rescale) -> Volume {
        let grid = Grid::centered([samples.len(), 1, 1], DVec3::ONE).unwrap();
        Volume::new(grid, samples, rescale, Metadata::default()).unwrap()
    }

    fn ids(labels: &LabelVolume) -> Vec<u32> {
        (0..labels.grid().dims()[0])
            .map(|x| labels.id(x, 0, 0))
            .collect()
    }

    #[test]
    fn a_layer_begins_at_its_threshold() {
        let stored = volume(
            Samples::F32(vec![-1.0, 0.0, 4.99, 5.0, 7.5, f32::NAN, f32::INFINITY]),
            Rescale::new(2.0, 1.0),
        );
        // Values −1, 1, 10.98, 11, 16.
        let layers =
            LabelVolume::of_layers(&stored, &[1.0, 11.0, 16.0], Vec::new(), &Control::NONE);
        assert_eq!(ids(&layers.unwrap()), [0, 1, 1, 2, 3, 0, 3]);
        let none = LabelVolume::of_layers(&stored, &[], Vec::new(), &Control::NONE).unwrap();
        assert_eq!(ids(&none), [0; 7]);
        for wrong in [&[2.0, 1.0][..], &[1.0, 1.0], &[f64::NAN, 1.0]] {
            let refused = LabelVolume::of_layers(&stored, wrong, Vec::new(), &Control::NONE);
            let message = refused.unwrap_err().to_string();
            assert!(message.contains("ascending numbers"), "{message}");
        }
    }

    #[test]
    fn a_voxel_belongs_to_the_last_mask_that_it_is_in() {
        let first = volume(Samples::U8(vec![0, 255, 255, 0]), Rescale::IDENTITY);
        let second = volume(Samples::F32(vec![0.0, 0.0, 0.5, 0.5]), Rescale::IDENTITY);
        let mut merged = MergedMasks::new(first.grid()).unwrap();
        merged.add(&first, "a", "a").unwrap();
        merged.add(&second, "b", "a").unwrap();
        assert_eq!(merged.overlaps(), 1);
        let other = volume(Samples::U8(vec![0; 3]), Rescale::IDENTITY);
        let refused = merged.add(&other, "c", "a").unwrap_err().to_string();
        assert!(refused.starts_with("the grid of c is 3×1×1"), "{refused}");
        let ids = merged.into_volume(Metadata::default()).unwrap();
        assert_eq!(*ids.samples(), Samples::U8(vec![0, 1, 2, 2]));
        let grades = volume(Samples::U8(vec![0, 1, 2, 0]), Rescale::IDENTITY);
        let mut merged = MergedMasks::new(grades.grid()).unwrap();
        let refused = merged.add(&grades, "d", "a").unwrap_err().to_string();
        assert!(
            refused.contains("mask d is 1 and 2; allowed: 0 and one"),
            "{refused}"
        );
    }
}
