//! Label volumes: which object a voxel belongs to, with the objects' names and colours.

use crate::{Error, Grid, Samples, Volume};

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

/// A grid of object ids.
#[derive(Clone, Debug)]
pub struct LabelVolume {
    grid: Grid,
    ids: LabelIds,
    labels: Vec<Label>,
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
        let mut seen = std::collections::BTreeSet::new();
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
        Ok(LabelVolume { grid, ids, labels })
    }

    /// Where the voxels lie.
    pub fn grid(&self) -> &Grid {
        &self.grid
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
        match &self.ids {
            LabelIds::U8(s) => s[index].into(),
            LabelIds::U16(s) => s[index].into(),
            LabelIds::U32(s) => s[index],
        }
    }
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
