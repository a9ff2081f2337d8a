//! Label volumes: which object a voxel belongs to, with the objects' names and colours.

use crate::{ContentId, Error, Grid, Metadata, Rescale, Samples, Volume};
use std::collections::BTreeSet;
use std::sync::Arc;

/// One object of a label volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// The number stored in its voxels; 0 is the background by custom.
    pub id: u32,
    /// Its name, such as `left kidney`.
    pub name: String,
    /// Display colour, sRGB 0 to 1, if known.
    pub color: Option<[f32; 3]>,
}

/// The ids of a label volume, x fastest.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub enum LabelIds {
    U8(Vec<u8>),
    U16(Vec<u16>),
    U32(Vec<u32>),
}

/// A grid of object ids. Clones share them.
#[derive(Clone, Debug)]
pub struct LabelVolume {
    grid: Grid,
    ids: Arc<LabelIds>,
    labels: Vec<Label>,
    content_id: ContentId,
}

impl LabelVolume {
    /// Takes the whole numbers of `volume` as object ids; u8, u16 and u32 stay as they are, signed
    /// types without a negative number become unsigned of the same width, and floating-point
    /// samples that are all whole become the narrowest fitting type.
    ///
    /// # Errors
    /// A number that is negative, not whole or above `u32::MAX`; a rescale that is not identity; an
    /// id named twice in `labels`.
    pub fn from_volume(volume: Volume, labels: Vec<Label>) -> Result<LabelVolume, Error> {
        let (grid, samples, rescale, _) = volume.into_parts();
        if rescale != crate::Rescale::IDENTITY {
            return Err(Error::field(
                "rescale of a label volume",
                format!("{} · stored + {}", rescale.slope, rescale.intercept),
                "slope 1 and intercept 0",
            ));
        }
        let mut seen = BTreeSet::new();
        for label in &labels {
            if !seen.insert(label.id) {
                return Err(Error::field("label id", label.id, "each id named once"));
            }
        }
        let ids = match samples {
            Samples::U8(s) => LabelIds::U8(s),
            Samples::U16(s) => LabelIds::U16(s),
            Samples::U32(s) => LabelIds::U32(s),
            other => narrowest(&other)?,
        };
        Ok(LabelVolume {
            grid,
            ids: Arc::new(ids),
            labels,
            content_id: ContentId::unique(),
        })
    }

    /// Where the voxels lie.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Which ids these are, wherever they go.
    pub fn content_id(&self) -> ContentId {
        self.content_id
    }

    /// The object ids.
    pub fn ids(&self) -> &LabelIds {
        &self.ids
    }

    /// The named objects, in the order of the file.
    pub fn labels(&self) -> &[Label] {
        &self.labels
    }

    /// The id at a voxel.
    ///
    /// # Panics
    /// If the voxel is outside the grid.
    pub fn id(&self, x: usize, y: usize, z: usize) -> u32 {
        let index = self.grid.index(x, y, z);
        match &*self.ids {
            LabelIds::U8(s) => s[index].into(),
            LabelIds::U16(s) => s[index].into(),
            LabelIds::U32(s) => s[index],
        }
    }

    /// The ids that voxels have or names belong to, ascending.
    pub fn known_ids(&self) -> Vec<u32> {
        let mut known = match &*self.ids {
            LabelIds::U8(s) => different(s),
            LabelIds::U16(s) => different(s),
            LabelIds::U32(s) => different(s),
        };
        known.extend(self.labels.iter().map(|label| label.id));
        known.into_iter().collect()
    }

    /// A mask: 1 in the voxels with one of these `ids`, 0 elsewhere.
    pub fn mask(&self, ids: &[u32]) -> Volume {
        let ids: BTreeSet<u32> = ids.iter().copied().collect();
        let samples = match &*self.ids {
            LabelIds::U8(s) => is_in(s, &ids),
            LabelIds::U16(s) => is_in(s, &ids),
            LabelIds::U32(s) => is_in(s, &ids),
        };
        let samples = Samples::U8(samples);
        Volume::new(self.grid, samples, Rescale::IDENTITY, Metadata::default())
            .expect("a sample for each voxel, as there is an id")
    }
}

/// Labels lie in runs: whatever is asked of one is asked once.
fn runs<T: PartialEq>(ids: &[T]) -> impl Iterator<Item = &[T]> {
    ids.chunk_by(|a, b| a == b)
}

fn different<T: Copy + Into<u32> + PartialEq>(ids: &[T]) -> BTreeSet<u32> {
    runs(ids).map(|run| run[0].into()).collect()
}

fn is_in<T: Copy + Into<u32> + PartialEq>(ids: &[T], asked: &BTreeSet<u32>) -> Vec<u8> {
    let mut inside = Vec::with_capacity(ids.len());
    for run in runs(ids) {
        let is_asked = asked.contains(&run[0].into());
        inside.resize(inside.len() + run.len(), u8::from(is_asked));
    }
    inside
}

fn narrowest(samples: &Samples) -> Result<LabelIds, Error> {
    let mut largest = 0.0f64;
    for i in 0..samples.len() {
        let id = samples.get(i);
        if !(0.0..=f64::from(u32::MAX)).contains(&id) || id.fract() != 0.0 {
            return Err(Error::field(
                "label id",
                id,
                "whole numbers from 0 to 4294967295",
            ));
        }
        largest = largest.max(id);
    }
    let ids = (0..samples.len()).map(|i| samples.get(i));
    Ok(if largest <= f64::from(u8::MAX) {
        LabelIds::U8(ids.map(|id| id as u8).collect())
    } else if largest <= f64::from(u16::MAX) {
        LabelIds::U16(ids.map(|id| id as u16).collect())
    } else {
        LabelIds::U32(ids.map(|id| id as u32).collect())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_mask_has_the_voxels_of_its_labels() {
        let dims = [20, 20, 9];
        let count = dims.iter().product::<usize>();
        let grid = Grid::centred(dims, DVec3::ONE).unwrap();
        let ids: Vec<u32> = (0..count as u32).map(|i| (i / 700) % 4 * 1000).collect();
        let named = Label {
            id: 7,
            name: "nowhere".into(),
            color: None,
        };
        let volume = |samples| Volume::new(grid, samples, Rescale::IDENTITY, Metadata::default());
        let wide = volume(Samples::U32(ids.clone())).unwrap();
        let narrow = volume(Samples::U16(ids.iter().map(|&id| id as u16).collect())).unwrap();
        for stored in [wide, narrow] {
            let labels = LabelVolume::from_volume(stored, vec![named.clone()]).unwrap();
            assert_eq!(labels.known_ids(), [0, 7, 1000, 2000, 3000]);
            for asked in [&[1000, 3000][..], &[0], &[7], &[]] {
                let mask = labels.mask(asked);
                let inside = ids.iter().map(|id| u8::from(asked.contains(id))).collect();
                assert_eq!(*mask.samples(), Samples::U8(inside), "{asked:?}");
                assert_eq!(mask.grid(), labels.grid());
            }
        }
    }
}
