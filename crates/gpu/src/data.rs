//! The data of pictures on the device.

use crate::device::Device;
use crate::error::Error;
use crate::geometry::Meshes;
use crate::volume_texture::{Pages, VolumeTexture};
use strahl_scene::plan::{ClipShape, Field, Plan};
use strahl_shader::Texels;
use strahl_volume::{Datasets, Metadata, Rescale, SampleType, Samples, Volume, bricks::Bricks};

/// Everything that Plans of the same data read.
#[derive(Debug)]
pub struct Data<'v> {
    volumes: Vec<&'v Volume>,
    stored: Vec<OnDevice>,
    /// What interpolating B-splines read in place of the voxels: made when a Plan first asks for it.
    coefficients: Vec<Option<OnDevice>>,
    pub masks: Vec<Mask>,
    pub meshes: Meshes,
    most: u32,
}

/// A volume on the device, and its bricks here.
#[derive(Debug)]
struct OnDevice {
    texture: VolumeTexture,
    bricks: Bricks,
}

impl OnDevice {
    fn new(device: &Device, volume: &Volume, most: u32) -> Result<OnDevice, Error> {
        Ok(OnDevice {
            texture: VolumeTexture::new(device, volume, most)?,
            bricks: Bricks::new(volume),
        })
    }
}

/// A mask on the device.
#[derive(Debug)]
pub struct Mask {
    texture: VolumeTexture,
    rescale: Rescale,
}

impl Mask {
    fn new(device: &Device, volume: &Volume, most: u32) -> Result<Mask, Error> {
        let dims = volume.grid().dims();
        if dims.iter().any(|n| *n > most as usize) {
            return Err(Error::MaskTooLarge { dims, most });
        }
        let texture = VolumeTexture::new(device, volume, most)?;
        let is_float = matches!(
            texture.storage.texels,
            Texels::Float | Texels::UnfilterableFloat
        );
        if is_float && volume.rescale().slope > 0.0 {
            return Ok(Mask {
                texture,
                rescale: volume.rescale(),
            });
        }
        // Above a threshold is above it in the numbers of the texture only if both grow together.
        let number = volume.grid().voxel_count();
        let value = |i| volume.rescale().value(volume.samples().get(i)) as f32;
        let values = Samples::F32((0..number).map(value).collect());
        let values = Volume::new(
            *volume.grid(),
            values,
            Rescale::IDENTITY,
            Metadata::default(),
        )?;
        Ok(Mask {
            texture: VolumeTexture::new(device, &values, most)?,
            rescale: Rescale::IDENTITY,
        })
    }

    pub fn view(&self) -> &wgpu::TextureView {
        &self.texture.view
    }

    /// A threshold in values, in the numbers of the texture.
    pub fn threshold(&self, threshold: f32) -> f64 {
        let storage = self.texture.storage;
        let stored = self.rescale.stored(f64::from(threshold));
        (stored - f64::from(storage.shift)) / f64::from(storage.scale)
    }
}

impl<'v> Data<'v> {
    pub fn new(device: &Device, data: Datasets<'v>, most: u32) -> Result<Data<'v>, Error> {
        let volumes = data.volumes.iter();
        let stored = volumes.map(|volume| OnDevice::new(device, volume, most));
        let masks = data.masks.iter();
        Ok(Data {
            stored: stored.collect::<Result<_, _>>()?,
            coefficients: data.volumes.iter().map(|_| None).collect(),
            masks: masks
                .map(|mask| Mask::new(device, mask, most))
                .collect::<Result<_, _>>()?,
            meshes: Meshes::new(device, &data.meshes)?,
            volumes: data.volumes,
            most,
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
    pub fn make_coefficients(&mut self, device: &Device, plan: &Plan) -> Result<(), Error> {
        if !plan.field().reads_coefficients() {
            return Ok(());
        }
        for field in plan.drawn_fields() {
            let slot = &mut self.coefficients[field.volume];
            if slot.is_none() {
                let volume = self.volumes[field.volume].b_spline_coefficients()?;
                *slot = Some(OnDevice::new(device, &volume, self.most)?);
            }
        }
        Ok(())
    }

    fn on_device(&self, plan: &Plan, volume: usize) -> &OnDevice {
        match &self.coefficients[volume] {
            Some(coefficients) if plan.field().reads_coefficients() => coefficients,
            _ => &self.stored[volume],
        }
    }

    /// How the textures that `plan` reads are read. One volume stands for itself.
    pub fn texels(&self, plan: &Plan) -> Vec<Texels> {
        (0..self.volumes.len())
            .map(|volume| self.on_device(plan, volume).texture.storage.texels)
            .collect()
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

    /// Whether a texture unit interpolates any of the fields' volumes.
    pub fn is_filtered(&self, plan: &Plan) -> bool {
        plan.drawn_fields().any(|field| {
            let texture = &self.on_device(plan, field.volume).texture;
            texture.storage.is_filterable
        })
    }

    pub fn view(&self, plan: &Plan, volume: usize) -> &wgpu::TextureView {
        &self.on_device(plan, volume).texture.view
    }

    pub fn bricks(&self, plan: &Plan, layer: usize) -> &Bricks {
        &self.on_device(plan, plan.field_of(layer).volume).bricks
    }

    pub fn pages(&self, plan: &Plan, volume: usize) -> Option<&Pages> {
        self.on_device(plan, volume).texture.pages.as_ref()
    }

    /// value = slope · texel + intercept: slope and intercept.
    pub fn value_of_texel(&self, plan: &Plan, field: &Field) -> (f64, f64) {
        // Coefficients are values.
        let rescale = if plan.field().reads_coefficients() {
            Rescale::IDENTITY
        } else {
            field.rescale
        };
        // stored = scale · texel + shift
        let storage = &self.on_device(plan, field.volume).texture.storage;
        (
            rescale.slope * f64::from(storage.scale),
            rescale.slope * f64::from(storage.shift) + rescale.intercept,
        )
    }
}
