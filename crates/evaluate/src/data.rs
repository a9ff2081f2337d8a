//! The data of pictures, as programs read it.

use crate::error::Error;
use crate::resources::{Numbers, Texture};
use std::sync::Arc;
use strahl_scene::plan::{ClipShape, Field, Plan};
use strahl_volume::bricks::{Bricks, BricksOf};
use strahl_volume::{
    CoefficientsOf, ContentId, Control, Datasets, Key, Mesh, Metadata, Rescale, SampleType,
    Samples, Store, Volume, with_samples,
};

/// What a Plan reads of its data.
pub struct Data<'d> {
    datasets: &'d Datasets,
    /// What each object is reconstructed from, by its volume: the voxels, or in their place the coefficients that
    /// interpolating B-splines read; with the bricks. `None` for volumes that no object shows.
    read: Vec<Option<(Arc<Volume>, Arc<Bricks>)>>,
    masks: Vec<Arc<Volume>>,
}

/// Whether `plan` is one of this data.
pub fn check(datasets: &Datasets, plan: &Plan) -> Result<(), Error> {
    let there = |what, index: usize, there: usize| {
        (index < there)
            .then_some(())
            .ok_or(Error::NoData { what, index, there })
    };
    for field in plan.drawn_fields() {
        there("volume", field.volume, datasets.volumes.len())?;
        let own = datasets.volumes[field.volume].grid();
        // A field may be placed elsewhere, but has the voxels of its volume.
        let is_own = field.is_moved || field.grid == *own;
        if field.grid.dims() != own.dims() || !is_own {
            return Err(Error::OtherGrid {
                plan: field.grid.dims(),
                volume: own.dims(),
            });
        }
    }
    for clip in &plan.sample_clips {
        if let ClipShape::Mask { mask, .. } = clip.shape {
            there("mask", mask, datasets.masks.len())?;
        }
    }
    for mesh in &plan.meshes {
        there("mesh", mesh.mesh, datasets.meshes.len())?;
    }
    Ok(())
}

/// A threshold in values, in the numbers of the texture of mask `mask`.
pub fn mask_threshold(datasets: &Datasets, mask: usize, threshold: f32) -> f64 {
    let rescale = datasets.masks[mask].rescale();
    match rescale.slope > 0.0 {
        true => rescale.stored(f64::from(threshold)),
        // [`growing`] ones hold values.
        false => f64::from(threshold),
    }
}

/// Whether every value is finite because the voxels are whole numbers and far from the largest float.
pub fn are_finite(datasets: &Datasets) -> bool {
    let is_finite = |volume: &Volume| {
        let Rescale { slope, intercept } = volume.rescale();
        !matches!(volume.sample_type(), SampleType::F32 | SampleType::F64)
            && slope.abs().max(intercept.abs()) < 1e20
    };
    datasets.volumes.iter().all(is_finite)
}

impl<'d> Data<'d> {
    /// Finds in `store`, or makes under `control`, what `plan` reads beside the data itself.
    pub fn new(
        datasets: &'d Datasets,
        plan: &Plan,
        store: &Store,
        control: &Control,
    ) -> Result<Data<'d>, Error> {
        check(datasets, plan)?;
        let mut read = vec![None; datasets.volumes.len()];
        for field in plan.drawn_fields() {
            let own = &datasets.volumes[field.volume];
            let volume = match field.reads_coefficients() {
                true => store.find(&CoefficientsOf(own.id()), control, || {
                    own.b_spline_coefficients_under(control)
                })?,
                false => Arc::new(own.clone()),
            };
            let key = BricksOf::new(&volume, Bricks::EDGE, 0);
            let make = || Bricks::under(&volume, Bricks::EDGE, 0, control);
            let bricks = store.find(&key, control, make)?;
            read[field.volume] = Some((volume, bricks));
        }
        let mut masks = Vec::new();
        for mask in &datasets.masks {
            masks.push(match mask.rescale().slope > 0.0 {
                true => Arc::new(mask.clone()),
                false => store.find(&GrowingOf(mask.id()), control, || growing(mask, control))?,
            });
        }
        Ok(Data {
            datasets,
            read,
            masks,
        })
    }

    /// The opaque surfaces.
    pub fn meshes(&self) -> &'d [Mesh] {
        &self.datasets.meshes
    }

    /// Of each object of `plan`, what it is reconstructed from, and its bricks.
    pub fn of_objects(&self, plan: &Plan) -> Vec<(ContentId, &Bricks)> {
        let mut found = Vec::new();
        for field in plan.drawn_fields() {
            if let Some((volume, bricks)) = &self.read[field.volume] {
                found.push((volume.id(), &**bricks));
            }
        }
        found
    }

    pub fn volumes(&self) -> usize {
        self.read.len()
    }

    /// The texture of volume `volume`: its stored numbers, as floats or, for a program that reads whole
    /// ones, as those.
    pub fn volume(&self, volume: usize, kind: naga::ScalarKind) -> Result<Texture<'_>, Error> {
        let volume = match &self.read[volume] {
            Some((volume, _)) => volume,
            None => &self.datasets.volumes[volume],
        };
        let samples = volume.samples();
        let numbers = match kind {
            naga::ScalarKind::Uint => Numbers::U32(
                with_samples!(samples, s => {
                    s.iter().map(|v| strahl_volume::Sample::to_f64(*v) as u32).collect::<Vec<_>>()
                })
                .into(),
            ),
            naga::ScalarKind::Sint => Numbers::I32(
                with_samples!(samples, s => {
                    s.iter().map(|v| strahl_volume::Sample::to_f64(*v) as i32).collect::<Vec<_>>()
                })
                .into(),
            ),
            _ => Numbers::Stored(samples),
        };
        Texture::new(volume.grid().dims().map(|n| n as u32), 1, numbers)
    }

    /// The texture of mask `mask`, if there is one.
    pub fn mask(&self, mask: usize) -> Option<Result<Texture<'_>, Error>> {
        let mask = self.masks.get(mask)?;
        let dims = mask.grid().dims().map(|n| n as u32);
        Some(Texture::new(dims, 1, Numbers::Stored(mask.samples())))
    }

    /// value = slope · texel + intercept: slope and intercept.
    pub fn value_of_texel(&self, field: &Field) -> (f64, f64) {
        // Coefficients are values.
        if field.reads_coefficients() {
            return (1.0, 0.0);
        }
        (field.rescale.slope, field.rescale.intercept)
    }
}

/// Key of the mask whose stored numbers grow with its values.
#[derive(Clone, PartialEq)]
struct GrowingOf(ContentId);

impl Key for GrowingOf {
    type Value = Volume;

    const NAME: &str = "growing masks";

    fn bytes(&self, value: &Volume) -> usize {
        value.samples().as_bytes().len()
    }
}

/// The values of a mask whose stored numbers fall with them, so that a threshold can be one in stored numbers.
fn growing(mask: &Volume, control: &Control) -> Result<Volume, Error> {
    const PIECE: usize = 1 << 16;
    let number = mask.grid().voxel_count();
    let mut values = Vec::with_capacity(number);
    for start in (0..number).step_by(PIECE) {
        control.check()?;
        let value = |i| mask.rescale().value(mask.samples().get(i)) as f32;
        values.extend((start..number.min(start + PIECE)).map(value));
    }
    let values = Samples::F32(values);
    let metadata = Metadata::default();
    Ok(Volume::new(
        *mask.grid(),
        values,
        Rescale::IDENTITY,
        metadata,
    )?)
}
