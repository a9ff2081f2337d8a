//! The data of pictures, as programs read it.

use crate::error::Error;
use crate::resources::{Numbers, Texture};
use std::borrow::Cow;
use strahl_scene::plan::{ClipShape, Field, Plan};
use strahl_volume::{
    Datasets, Mesh, Metadata, Rescale, SampleType, Samples, Volume, bricks::Bricks, with_samples,
};

/// Everything that Plans of the same data read.
#[derive(Debug)]
pub struct Data<'v> {
    volumes: Vec<&'v Volume>,
    bricks: Vec<Bricks>,
    /// What interpolating B-splines read in place of the voxels: made when a Plan first asks for it.
    coefficients: Vec<Option<(Volume, Bricks)>>,
    masks: Vec<Cow<'v, Volume>>,
    pub meshes: Vec<&'v Mesh>,
}

impl<'v> Data<'v> {
    pub fn new(data: Datasets<'v>) -> Result<Data<'v>, Error> {
        Ok(Data {
            bricks: data.volumes.iter().map(|v| Bricks::new(v)).collect(),
            coefficients: data.volumes.iter().map(|_| None).collect(),
            masks: data
                .masks
                .iter()
                .map(|mask| growing(mask))
                .collect::<Result<_, _>>()?,
            volumes: data.volumes,
            meshes: data.meshes,
        })
    }

    /// Whether `plan` is one of this data.
    pub fn check(&self, plan: &Plan) -> Result<(), Error> {
        let there = |what, index: usize, there: usize| {
            (index < there)
                .then_some(())
                .ok_or(Error::NoData { what, index, there })
        };
        for field in plan.drawn_fields() {
            there("volume", field.volume, self.volumes.len())?;
            let own = self.volumes[field.volume].grid();
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
                there("mask", mask, self.masks.len())?;
            }
        }
        for mesh in &plan.meshes {
            there("mesh", mesh.mesh, self.meshes.len())?;
        }
        Ok(())
    }

    /// Makes the coefficients that `plan` reads, if it reads any.
    pub fn make_coefficients(&mut self, plan: &Plan) -> Result<(), Error> {
        if !plan.field().reads_coefficients() {
            return Ok(());
        }
        for field in plan.drawn_fields() {
            let slot = &mut self.coefficients[field.volume];
            if slot.is_none() {
                let volume = self.volumes[field.volume].b_spline_coefficients()?;
                let bricks = Bricks::new(&volume);
                *slot = Some((volume, bricks));
            }
        }
        Ok(())
    }

    fn read(&self, plan: &Plan, volume: usize) -> (&Volume, &Bricks) {
        match &self.coefficients[volume] {
            Some((volume, bricks)) if plan.field().reads_coefficients() => (volume, bricks),
            _ => (self.volumes[volume], &self.bricks[volume]),
        }
    }

    pub fn volumes(&self) -> usize {
        self.volumes.len()
    }

    pub fn bricks(&self, plan: &Plan, layer: usize) -> &Bricks {
        self.read(plan, plan.field_of(layer).volume).1
    }

    /// Whether every value is finite because the voxels are whole numbers and far from the largest float.
    pub fn are_finite(&self) -> bool {
        let is_finite = |volume: &&Volume| {
            let Rescale { slope, intercept } = volume.rescale();
            !matches!(volume.sample_type(), SampleType::F32 | SampleType::F64)
                && slope.abs().max(intercept.abs()) < 1e20
        };
        self.volumes.iter().all(is_finite)
    }

    /// The texture of volume `volume`: its stored numbers, as floats or, for a program that reads whole
    /// ones, as those.
    pub fn volume(
        &self,
        plan: &Plan,
        volume: usize,
        kind: naga::ScalarKind,
    ) -> Result<Texture<'_>, Error> {
        let volume = self.read(plan, volume).0;
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

    /// A threshold in values, in the numbers of the mask's texture.
    pub fn mask_threshold(&self, mask: usize, threshold: f32) -> f64 {
        self.masks[mask].rescale().stored(f64::from(threshold))
    }

    /// value = slope · texel + intercept: slope and intercept.
    pub fn value_of_texel(&self, plan: &Plan, field: &Field) -> (f64, f64) {
        // Coefficients are values.
        if plan.field().reads_coefficients() {
            return (1.0, 0.0);
        }
        (field.rescale.slope, field.rescale.intercept)
    }
}

/// A mask whose stored numbers grow with its values, so that a threshold can be one in stored numbers.
fn growing(mask: &Volume) -> Result<Cow<'_, Volume>, Error> {
    if mask.rescale().slope > 0.0 {
        return Ok(Cow::Borrowed(mask));
    }
    let value = |i| mask.rescale().value(mask.samples().get(i)) as f32;
    let values = Samples::F32((0..mask.grid().voxel_count()).map(value).collect());
    let values = Volume::new(*mask.grid(), values, Rescale::IDENTITY, Metadata::default())?;
    Ok(Cow::Owned(values))
}
