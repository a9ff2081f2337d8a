//! The data of pictures on the device.

use crate::device::Device;
use crate::error::Error;
use crate::geometry::MeshCorners;
use crate::volume_texture::{Pages, Storage, VolumeTexture};
use std::sync::Arc;
use strahl_scene::plan::{ClipShape, Field, Plan};
use strahl_shader::Texels;
use strahl_volume::bricks::{Bricks, BricksOf};
use strahl_volume::{
    CoefficientsOf, ContentId, Control, Datasets, Key, Metadata, Rescale, SampleType, Samples,
    Store, Volume,
};

/// Data that Plans are drawn from, and how the device holds it: known before anything is copied.
#[derive(Clone, Debug)]
pub struct Data {
    datasets: Datasets,
    /// What is made of the data, here.
    pub store: Arc<Store>,
    /// Voxels along an axis of the largest texture.
    most: u32,
}

/// Key of a volume on the device.
#[derive(Clone, PartialEq)]
struct TextureOf {
    volume: ContentId,
    most: u32,
}

impl Key for TextureOf {
    type Value = VolumeTexture;

    const NAME: &str = "textures of volumes";

    fn bytes(&self, value: &VolumeTexture) -> usize {
        value.bytes
    }
}

/// Key of a mesh on the device.
#[derive(Clone, PartialEq)]
struct CornersOf(ContentId);

impl Key for CornersOf {
    type Value = MeshCorners;

    const NAME: &str = "corners of meshes";

    fn bytes(&self, value: &MeshCorners) -> usize {
        value.bytes()
    }
}

/// Key of the values of a mask.
#[derive(Clone, PartialEq)]
struct ValuesOf(ContentId);

impl Key for ValuesOf {
    type Value = Volume;

    const NAME: &str = "values of masks";

    fn bytes(&self, value: &Volume) -> usize {
        value.samples().as_bytes().len()
    }
}

impl Data {
    pub fn new(datasets: Datasets, store: Arc<Store>, most: u32) -> Data {
        Data {
            datasets,
            store,
            most,
        }
    }

    /// The same of other data.
    pub fn of(&self, datasets: Datasets) -> Data {
        Data {
            datasets,
            ..self.clone()
        }
    }

    /// Whether `plan` is one of this data.
    pub fn check(&self, plan: &Plan) -> Result<(), Error> {
        let there = |what, index: usize, there: usize| {
            (index < there)
                .then_some(())
                .ok_or(Error::NoData { what, index, there })
        };
        let data = &self.datasets;
        for field in plan.drawn_fields() {
            there("volume", field.volume, data.volumes.len())?;
            let own = data.volumes[field.volume].grid();
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
                there("mask", mask, data.masks.len())?;
            }
        }
        for mesh in &plan.meshes {
            there("mesh", mesh.mesh, data.meshes.len())?;
        }
        Ok(())
    }

    /// How the texture is stored that `plan` reads volume `volume` from.
    fn storage(&self, device: &Device, plan: &Plan, volume: usize) -> Storage {
        let sample_type = match reads_coefficients(plan, volume) {
            true => SampleType::F32,
            false => self.datasets.volumes[volume].sample_type(),
        };
        let volume = &self.datasets.volumes[volume];
        let storage = Storage::of(sample_type, device);
        match VolumeTexture::is_paged(volume, self.most) {
            true => storage.paged(),
            false => storage,
        }
    }

    /// How the textures that `plan` reads are read. One volume stands for itself.
    pub fn texels(&self, device: &Device, plan: &Plan) -> Vec<Texels> {
        (0..self.datasets.volumes.len())
            .map(|volume| self.storage(device, plan, volume).texels)
            .collect()
    }

    /// Whether every value is finite because the voxels are whole numbers and far from the largest float.
    pub fn are_finite(&self) -> bool {
        let is_finite = |volume: &Volume| {
            let Rescale { slope, intercept } = volume.rescale();
            !matches!(volume.sample_type(), SampleType::F32 | SampleType::F64)
                && slope.abs().max(intercept.abs()) < 1e20
        };
        self.datasets.volumes.iter().all(is_finite)
    }

    /// Whether a texture unit interpolates any of the fields' volumes.
    pub fn is_filtered(&self, device: &Device, plan: &Plan) -> bool {
        plan.drawn_fields()
            .any(|field| self.storage(device, plan, field.volume).is_filterable)
    }

    /// value = slope · texel + intercept: slope and intercept.
    pub fn value_of_texel(&self, device: &Device, plan: &Plan, field: &Field) -> (f64, f64) {
        // Coefficients are values.
        let rescale = if reads_coefficients(plan, field.volume) {
            Rescale::IDENTITY
        } else {
            field.rescale
        };
        // stored = scale · texel + shift
        let storage = self.storage(device, plan, field.volume);
        (
            rescale.slope * f64::from(storage.scale),
            rescale.slope * f64::from(storage.shift) + rescale.intercept,
        )
    }

    /// A threshold in values, in the numbers of the texture of mask `mask`.
    pub fn mask_threshold(&self, device: &Device, mask: usize, threshold: f32) -> f64 {
        let mask = &self.datasets.masks[mask];
        if !holds_stored_numbers(device, mask) {
            return f64::from(threshold);
        }
        let storage = Storage::of(mask.sample_type(), device);
        let stored = mask.rescale().stored(f64::from(threshold));
        (stored - f64::from(storage.shift)) / f64::from(storage.scale)
    }

    /// Copies to the device what `plan` reads and is not there yet.
    pub async fn on_device(
        &self,
        device: &Device,
        plan: &Plan,
        control: &Control,
    ) -> Result<OnDevice, Error> {
        let mut volumes = Vec::new();
        for (index, own) in self.datasets.volumes.iter().enumerate() {
            let volume = match reads_coefficients(plan, index) {
                true => self.store.find(&CoefficientsOf(own.id()), control, || {
                    own.b_spline_coefficients_under(control)
                })?,
                false => Arc::new(own.clone()),
            };
            let key = BricksOf::new(&volume, Bricks::EDGE, 0);
            let make = || Bricks::under(&volume, Bricks::EDGE, 0, control);
            let bricks = self.store.find(&key, control, make)?;
            volumes.push(VolumeOnDevice {
                source: volume.id(),
                texture: self.texture(device, &volume, control).await?,
                bricks,
            });
        }
        let mut masks = Vec::new();
        for mask in &self.datasets.masks {
            masks.push(self.mask(device, mask, control).await?);
        }
        let mut meshes = Vec::new();
        for mesh in &self.datasets.meshes {
            let key = CornersOf(mesh.id());
            meshes.push(match device.store().get(&key) {
                Some(known) => known,
                None => device.store().put(&key, MeshCorners::new(device, mesh)?),
            });
        }
        device.check()?;
        Ok(OnDevice {
            volumes,
            masks,
            meshes,
        })
    }

    async fn texture(
        &self,
        device: &Device,
        volume: &Volume,
        control: &Control,
    ) -> Result<Arc<VolumeTexture>, Error> {
        let key = TextureOf {
            volume: volume.id(),
            most: self.most,
        };
        if let Some(known) = device.store().get(&key) {
            return Ok(known);
        }
        let texture = VolumeTexture::new(device, volume, self.most, control).await?;
        Ok(device.store().put(&key, texture))
    }

    async fn mask(
        &self,
        device: &Device,
        mask: &Volume,
        control: &Control,
    ) -> Result<Arc<VolumeTexture>, Error> {
        let (dims, most) = (mask.grid().dims(), self.most);
        if dims.iter().any(|n| *n > most as usize) {
            return Err(Error::MaskTooLarge { dims, most });
        }
        if holds_stored_numbers(device, mask) {
            return self.texture(device, mask, control).await;
        }
        let values = self
            .store
            .find(&ValuesOf(mask.id()), control, || values(mask, control))?;
        self.texture(device, &values, control).await
    }
}

/// Whether the texture of a mask has its stored numbers: above a threshold is above it in the numbers of the texture
/// only if both grow together.
fn holds_stored_numbers(device: &Device, mask: &Volume) -> bool {
    let texels = Storage::of(mask.sample_type(), device).texels;
    let is_float = matches!(texels, Texels::Float | Texels::UnfilterableFloat);
    is_float && mask.rescale().slope > 0.0
}

/// The values of a mask.
fn values(mask: &Volume, control: &Control) -> Result<Volume, strahl_volume::Error> {
    const PIECE: usize = 1 << 16;
    let number = mask.grid().voxel_count();
    let mut values = Vec::with_capacity(number);
    for start in (0..number).step_by(PIECE) {
        control.check()?;
        let value = |i| mask.rescale().value(mask.samples().get(i)) as f32;
        values.extend((start..number.min(start + PIECE)).map(value));
    }
    let (values, metadata) = (Samples::F32(values), Metadata::default());
    Volume::new(*mask.grid(), values, Rescale::IDENTITY, metadata)
}

/// Whether `plan` reads coefficients in place of the voxels of volume `volume`.
fn reads_coefficients(plan: &Plan, volume: usize) -> bool {
    plan.drawn_fields()
        .any(|field| field.volume == volume && field.reads_coefficients())
}

/// What a picture reads on the device.
pub struct OnDevice {
    volumes: Vec<VolumeOnDevice>,
    masks: Vec<Arc<VolumeTexture>>,
    pub meshes: Vec<Arc<MeshCorners>>,
}

/// A volume, or coefficients in its place, on the device, and its bricks here.
struct VolumeOnDevice {
    source: ContentId,
    texture: Arc<VolumeTexture>,
    bricks: Arc<Bricks>,
}

impl OnDevice {
    pub fn view(&self, volume: usize) -> &wgpu::TextureView {
        &self.volumes[volume].texture.view
    }

    /// What volume `volume` is reconstructed from, and its bricks.
    pub fn bricks(&self, volume: usize) -> (ContentId, &Bricks) {
        let volume = &self.volumes[volume];
        (volume.source, &volume.bricks)
    }

    pub fn pages(&self, volume: usize) -> Option<&Pages> {
        self.volumes[volume].texture.pages.as_ref()
    }

    pub fn mask(&self, mask: usize) -> Option<&wgpu::TextureView> {
        self.masks.get(mask).map(|mask| &mask.view)
    }
}
