//! Label volumes: which object a voxel belongs to, with the objects' names and colors.

use crate::{ContentId, Error, Grid, Metadata, Rescale, Samples, Volume, memory};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, OnceLock};

/// One object of a label volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// The number stored in its voxels; 0 is the background by custom.
    pub id: u32,
    /// Its name, such as `left kidney`.
    pub name: String,
    /// Display color, sRGB 0 to 1, if known.
    pub color: Option<[f32; 3]>,
    /// What kind of thing it is, such as `Tissue`, if the file says.
    pub group: Option<String>,
}

impl Label {
    /// A label of which nothing but id and name is known.
    pub fn new(id: u32, name: impl Into<String>) -> Label {
        Label {
            id,
            name: name.into(),
            color: None,
            group: None,
        }
    }
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
    /// Found when somebody first asks.
    known_ids: Arc<OnceLock<KnownIds>>,
}

/// Ids, ascending.
#[derive(Debug)]
struct KnownIds {
    /// Those that voxels have or names belong to.
    all: Vec<u32>,
    /// Those of names that no voxel has.
    unused: Vec<u32>,
}

impl LabelVolume {
    /// Takes the whole numbers of `volume` as object ids; u8, u16 and u32 stay as they are, signed
    /// and floating-point samples become the narrowest type that holds all of them.
    ///
    /// # Errors
    /// The first voxel whose number is negative, not whole or above `u32::MAX`; a rescale that is
    /// not identity; an id named twice in `labels`.
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
            other => narrowest(&grid, &other)?,
        };
        Ok(LabelVolume {
            grid,
            ids: Arc::new(ids),
            labels,
            content_id: ContentId::unique(),
            known_ids: Arc::default(),
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

    /// Memory that the ids take, in bytes.
    pub fn byte_count(&self) -> usize {
        match &*self.ids {
            LabelIds::U8(ids) => size_of_val(&ids[..]),
            LabelIds::U16(ids) => size_of_val(&ids[..]),
            LabelIds::U32(ids) => size_of_val(&ids[..]),
        }
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

    /// The ids that voxels have, ascending, each with the number of its voxels.
    pub fn counts(&self) -> Vec<(u32, u64)> {
        let counts = match &*self.ids {
            LabelIds::U8(s) => counted(s),
            LabelIds::U16(s) => counted(s),
            LabelIds::U32(s) => counted(s),
        };
        counts.into_iter().collect()
    }

    /// The ids that voxels have or names belong to, ascending.
    pub fn known_ids(&self) -> &[u32] {
        &self.known().all
    }

    /// The ids that names belong to and no voxel has, ascending.
    pub fn unused_ids(&self) -> &[u32] {
        &self.known().unused
    }

    fn known(&self) -> &KnownIds {
        self.known_ids.get_or_init(|| {
            let used: BTreeSet<u32> = self.counts().into_iter().map(|(id, _)| id).collect();
            let named: BTreeSet<u32> = self.labels.iter().map(|label| label.id).collect();
            KnownIds {
                all: used.union(&named).copied().collect(),
                unused: named.difference(&used).copied().collect(),
            }
        })
    }

    /// A mask: 1 in the voxels with one of these `ids`, 0 elsewhere.
    ///
    /// # Errors
    /// No memory.
    pub fn mask(&self, ids: &[u32]) -> Result<Volume, Error> {
        let ids: BTreeSet<u32> = ids.iter().copied().collect();
        let samples = match &*self.ids {
            LabelIds::U8(s) => is_in(s, &ids),
            LabelIds::U16(s) => is_in(s, &ids),
            LabelIds::U32(s) => is_in(s, &ids),
        };
        let samples = Samples::U8(samples?);
        Volume::new(self.grid, samples, Rescale::IDENTITY, Metadata::default())
    }
}

/// Labels lie in runs: whatever is asked of one is asked once.
fn runs<T: PartialEq>(ids: &[T]) -> impl Iterator<Item = &[T]> {
    ids.chunk_by(|a, b| a == b)
}

fn counted<T: Copy + Into<u32> + PartialEq>(ids: &[T]) -> BTreeMap<u32, u64> {
    let mut counts = BTreeMap::new();
    for run in runs(ids) {
        *counts.entry(run[0].into()).or_default() += run.len() as u64;
    }
    counts
}

fn is_in<T: Copy + Into<u32> + PartialEq>(
    ids: &[T],
    asked: &BTreeSet<u32>,
) -> Result<Vec<u8>, Error> {
    let mut inside = memory::reserved(ids.len())?;
    for run in runs(ids) {
        let is_asked = asked.contains(&run[0].into());
        inside.resize(inside.len() + run.len(), u8::from(is_asked));
    }
    Ok(inside)
}

fn narrowest(grid: &Grid, samples: &Samples) -> Result<LabelIds, Error> {
    let mut largest = 0.0f64;
    for i in 0..samples.len() {
        let id = samples.get(i);
        if !(0.0..=f64::from(u32::MAX)).contains(&id) || id.fract() != 0.0 {
            let [nx, ny, _] = grid.dims();
            let voxel = [i % nx, i / nx % ny, i / (nx * ny)];
            return Err(Error::field(
                format!("label id at voxel {voxel:?}"),
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
        let grid = Grid::centered(dims, DVec3::ONE).unwrap();
        let ids: Vec<u32> = (0..count as u32).map(|i| (i / 700) % 4 * 1000).collect();
        let named = Label::new(7, "nowhere");
        let volume = |samples| Volume::new(grid, samples, Rescale::IDENTITY, Metadata::default());
        let wide = volume(Samples::U32(ids.clone())).unwrap();
        let narrow = volume(Samples::U16(ids.iter().map(|&id| id as u16).collect())).unwrap();
        for stored in [wide, narrow] {
            let labels = LabelVolume::from_volume(stored, vec![named.clone()]).unwrap();
            assert_eq!(labels.known_ids(), [0, 7, 1000, 2000, 3000]);
            assert_eq!(labels.unused_ids(), [7]);
            // 3600 voxels in runs of 700: the first id has 700 and the last 100 again.
            let counts = [(0, 1400), (1000, 800), (2000, 700), (3000, 700)];
            assert_eq!(labels.counts(), counts);
            for asked in [&[1000, 3000][..], &[0], &[7], &[]] {
                let mask = labels.mask(asked).unwrap();
                let inside = ids.iter().map(|id| u8::from(asked.contains(id))).collect();
                assert_eq!(*mask.samples(), Samples::U8(inside), "{asked:?}");
                assert_eq!(mask.grid(), labels.grid());
            }
        }
    }

    #[test]
    fn whole_numbers_of_any_type_are_ids_and_others_are_refused_by_voxel() {
        let grid = Grid::centered([2, 3, 2], DVec3::ONE).unwrap();
        let of = |samples, slope| {
            let rescale = Rescale::new(slope, 0.0);
            let volume = Volume::new(grid, samples, rescale, Metadata::default()).unwrap();
            LabelVolume::from_volume(volume, Vec::new())
        };
        let mut floats = vec![0.0f32; 12];
        (floats[3], floats[11]) = (300.0, -0.0);
        let labels = of(Samples::F32(floats.clone()), 1.0).unwrap();
        assert!(matches!(labels.ids(), LabelIds::U16(_)));
        assert_eq!((labels.id(1, 1, 0), labels.id(1, 2, 1)), (300, 0));
        for (bad, said) in [
            (0.5, "0.5"),
            (f32::NAN, "NaN"),
            (-1.0, "-1"),
            (1e10, "10000000000"),
        ] {
            // x = 0, y = 2, z = 1: index 0 + 2 · (2 + 3 · 1).
            floats[10] = bad;
            let message = of(Samples::F32(floats.clone()), 1.0)
                .unwrap_err()
                .to_string();
            let expected = format!("label id at voxel [0, 2, 1] is {said}; allowed: whole numbers");
            assert!(message.starts_with(&expected), "{message}");
        }
        let message = of(Samples::I16(vec![-3; 12]), 1.0).unwrap_err().to_string();
        assert!(
            message.starts_with("label id at voxel [0, 0, 0] is -3"),
            "{message}"
        );
        let message = of(Samples::U8(vec![1; 12]), 2.0).unwrap_err().to_string();
        assert!(
            message.contains("2 · stored + 0; allowed: slope 1"),
            "{message}"
        );
    }
}
