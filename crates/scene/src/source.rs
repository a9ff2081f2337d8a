//! What a Plan reads of its data: decided here for every renderer.

use crate::plan::{ClipShape, Field, Plan};
use std::sync::Arc;
use strahl_shader::BRICK_VOXELS;
use strahl_volume::bricks::{Bricks, BricksKey};
use strahl_volume::{
    CoefficientsKey, Control, Datasets, Error, Rescale, SampleType, Store, Volume,
};

/// Data that a Plan was not resolved for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum OtherData {
    /// The Plan counts more data than was handed over.
    #[error(
        "the plan needs {what} number {index}, of which {there} were handed over; hand over the data that the plan was resolved for"
    )]
    Missing {
        /// `volume`, `label volume`, `mask` or `mesh`.
        what: &'static str,
        /// Which one, from 0.
        index: usize,
        /// How many there are.
        there: usize,
    },
    /// The Plan was resolved for another volume.
    #[error(
        "the plan is for a grid of {plan:?} voxels, the volume has {volume:?} (or lies elsewhere); resolve the scene with this volume's header"
    )]
    Grid {
        /// Dimensions in the Plan.
        plan: [usize; 3],
        /// Dimensions of the volume.
        volume: [usize; 3],
    },
    /// The Plan was made or changed by hand, and no picture can be drawn of it.
    #[error("the plan cannot be drawn: {what}; a plan that resolve has made can")]
    NotDrawable {
        /// What is wrong, and what would be right.
        what: String,
    },
    /// The Plan was resolved for another label volume.
    #[error(
        "the plan is for labels in a grid of {plan:?} voxels, the label volume has {labels:?} (or lies elsewhere); make the plan with the grid of this label volume"
    )]
    LabelGrid {
        /// Dimensions in the Plan.
        plan: [usize; 3],
        /// Dimensions of the label volume.
        labels: [usize; 3],
    },
}

impl OtherData {
    /// `Ok` if number `index` is one of those that are `there`.
    ///
    /// # Errors
    /// It is not.
    pub fn unless_there(what: &'static str, index: usize, there: usize) -> Result<(), OtherData> {
        match index < there {
            true => Ok(()),
            false => Err(OtherData::Missing { what, index, there }),
        }
    }
}

impl Plan {
    /// Whether this is a Plan of `data` that can be drawn: one that `resolve` has made is, one that was changed by hand may
    /// count what is not there or be out of range.
    ///
    /// # Errors
    /// It is one of other data, or of none.
    pub fn check(&self, data: &Datasets) -> Result<(), OtherData> {
        self.check_itself()
            .map_err(|what| OtherData::NotDrawable { what })?;
        for field in self.drawn_fields() {
            OtherData::unless_there("volume", field.volume, data.volumes.len())?;
            let own = data.volumes[field.volume].grid();
            // A field may be placed elsewhere, but has the voxels of its volume.
            let has_place = field.is_moved || field.grid == *own;
            if field.grid.dims() != own.dims() || !has_place {
                return Err(OtherData::Grid {
                    plan: field.grid.dims(),
                    volume: own.dims(),
                });
            }
        }
        if let Some(labeled) = self.labeled() {
            OtherData::unless_there("label volume", labeled.labels, data.labels.len())?;
            let own = data.labels[labeled.labels].grid();
            let has_place = labeled.is_moved || labeled.grid == *own;
            if labeled.grid.dims() != own.dims() || !has_place {
                return Err(OtherData::LabelGrid {
                    plan: labeled.grid.dims(),
                    labels: own.dims(),
                });
            }
        }
        for clip in &self.sample_clips {
            if let ClipShape::Mask { mask, .. } = clip.shape {
                OtherData::unless_there("mask", mask, data.masks.len())?;
            }
        }
        if let Some(importance) = self.importance {
            OtherData::unless_there("mask", importance.mask, data.masks.len())?;
        }
        for mesh in &self.meshes {
            OtherData::unless_there("mesh", mesh.mesh, data.meshes.len())?;
        }
        Ok(())
    }
}

impl Field {
    /// What the numbers mean that it is reconstructed from: coefficients are values.
    pub fn read_rescale(&self) -> Rescale {
        match self.reads_coefficients() {
            true => Rescale::IDENTITY,
            false => self.rescale,
        }
    }

    /// The type of the numbers that it is reconstructed from, where `own` is its volume.
    pub fn read_type(&self, own: &Volume) -> SampleType {
        match self.reads_coefficients() {
            true => SampleType::F32,
            false => own.sample_type(),
        }
    }
}

/// What a field is reconstructed from.
#[derive(Clone, Debug)]
pub struct Source {
    /// Its volume, or B-spline coefficients in place of the voxels.
    pub volume: Arc<Volume>,
    /// What the stored numbers mean.
    pub rescale: Rescale,
}

impl Source {
    /// That of `field` in `data`; `coefficients` finds or makes those of a volume.
    ///
    /// # Errors
    /// There are no coefficients.
    pub fn new<E>(
        field: &Field,
        data: &Datasets,
        coefficients: impl FnOnce(&Volume) -> Result<Arc<Volume>, E>,
    ) -> Result<Source, E> {
        let own = &data.volumes[field.volume];
        Ok(Source {
            volume: match field.reads_coefficients() {
                true => coefficients(own)?,
                false => Arc::new(own.clone()),
            },
            rescale: field.read_rescale(),
        })
    }

    /// That of `field` in `data`. Coefficients are found in `store`, or made under `control`.
    ///
    /// # Errors
    /// The volume has no coefficients; it was cancelled.
    pub fn find(
        field: &Field,
        data: &Datasets,
        store: &Store,
        control: &Control,
    ) -> Result<Source, Error> {
        Source::new(field, data, |own| {
            store.find(&CoefficientsKey(own.id()), control, || {
                own.b_spline_coefficients_under(control)
            })
        })
    }

    /// Its bricks, with as many voxels along an edge as programs want; found in `store`, or made under `control`.
    ///
    /// # Errors
    /// It was cancelled; no memory.
    pub fn bricks(&self, store: &Store, control: &Control) -> Result<Arc<Bricks>, Error> {
        let edge = BRICK_VOXELS as usize;
        let key = BricksKey::new(&self.volume, edge, 0);
        store.find(&key, control, || {
            Bricks::under(&self.volume, edge, 0, control)
        })
    }
}
