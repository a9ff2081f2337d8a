//! The data of pictures on the device.

use crate::device::Device;
use crate::error::Error;
use crate::geometry::MeshCorners;
use crate::label_texture::LabelTexture;
use crate::volume_texture::{Pages, Storage, VolumeTexture};
use std::sync::Arc;
use strahl_scene::Source;
use strahl_scene::plan::{Field, Plan};
use strahl_shader::Texels;
use strahl_volume::bricks::Bricks;
use strahl_volume::{
    ContentId, Control, Datasets, Key, LabelNumbersKey, LabelVolume, Store, ValuesKey, Volume,
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
struct TextureKey {
    volume: ContentId,
    most: u32,
}

impl Key for TextureKey {
    type Value = VolumeTexture;

    const NAME: &str = "textures of volumes";

    fn bytes(&self, value: &VolumeTexture) -> usize {
        value.bytes
    }
}

/// Key of the segments of a label volume on the device.
#[derive(Clone, PartialEq)]
struct LabelTextureKey(ContentId);

impl Key for LabelTextureKey {
    type Value = LabelTexture;

    const NAME: &str = "textures of labels";

    fn bytes(&self, value: &LabelTexture) -> usize {
        value.bytes
    }
}

/// Key of a mesh on the device.
#[derive(Clone, PartialEq)]
struct CornersKey(ContentId);

impl Key for CornersKey {
    type Value = MeshCorners;

    const NAME: &str = "corners of meshes";

    fn bytes(&self, value: &MeshCorners) -> usize {
        value.bytes()
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
        Ok(plan.check(&self.datasets)?)
    }

    /// How the texture is stored that `plan` reads volume `volume` from.
    fn storage(&self, device: &Device, plan: &Plan, volume: usize) -> Storage {
        let reader = reader(plan, volume);
        let volume = &self.datasets.volumes[volume];
        let sample_type = match reader {
            Some(field) => field.read_type(volume),
            None => volume.sample_type(),
        };
        let storage = Storage::of(sample_type, device);
        if VolumeTexture::is_paged(volume, self.most) {
            storage.paged()
        } else if storage.is_filterable && !has_all_values(volume) {
            storage.unfiltered()
        } else {
            storage
        }
    }

    /// How the textures that `plan` reads are read. One volume stands for itself.
    pub fn texels(&self, device: &Device, plan: &Plan) -> Vec<Texels> {
        (0..self.datasets.volumes.len())
            .map(|volume| self.storage(device, plan, volume).texels)
            .collect()
    }

    /// Whether every value is known to be finite.
    pub fn are_finite(&self) -> bool {
        self.datasets.are_finite()
    }

    /// Whether a texture unit interpolates any of the fields' volumes.
    pub fn is_filtered(&self, device: &Device, plan: &Plan) -> bool {
        plan.drawn_fields()
            .any(|field| self.storage(device, plan, field.volume).is_filterable)
    }

    /// value = slope · texel + intercept: slope and intercept.
    pub fn value_of_texel(&self, device: &Device, plan: &Plan, field: &Field) -> (f64, f64) {
        let rescale = field.read_rescale();
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
    ) -> Result<DeviceData, Error> {
        let mut volumes = Vec::new();
        for (index, own) in self.datasets.volumes.iter().enumerate() {
            let source = match reader(plan, index) {
                Some(field) => Source::find(field, &self.datasets, &self.store, control)?,
                // The program may not look at it, but it has a texture.
                None => Source {
                    volume: Arc::new(own.clone()),
                    rescale: own.rescale(),
                },
            };
            volumes.push(VolumeOnDevice {
                source: source.volume.id(),
                texture: self.texture(device, &source.volume, control).await?,
                bricks: source.bricks(&self.store, control)?,
            });
        }
        let mut masks = Vec::new();
        for mask in &self.datasets.masks {
            masks.push(self.mask(device, mask, control).await?);
        }
        let mut meshes = Vec::new();
        for mesh in &self.datasets.meshes {
            let key = CornersKey(mesh.id());
            meshes.push(match device.store().get(&key) {
                Some(known) => known,
                None => device.store().put(&key, MeshCorners::new(device, mesh)?),
            });
        }
        let labels = match plan.labeled() {
            Some(labeled) => {
                let labels = &self.datasets.labels[labeled.labels];
                Some(self.labels(device, labels, control)?)
            }
            None => None,
        };
        device.check()?;
        Ok(DeviceData {
            volumes,
            masks,
            labels,
            meshes,
        })
    }

    async fn texture(
        &self,
        device: &Device,
        volume: &Volume,
        control: &Control,
    ) -> Result<Arc<VolumeTexture>, Error> {
        let key = TextureKey {
            volume: volume.id(),
            most: self.most,
        };
        if let Some(known) = device.store().get(&key) {
            return Ok(known);
        }
        let texture = VolumeTexture::new(device, volume, self.most, control).await?;
        Ok(device.store().put(&key, texture))
    }

    fn labels(
        &self,
        device: &Device,
        labels: &LabelVolume,
        control: &Control,
    ) -> Result<Arc<LabelTexture>, Error> {
        let key = LabelTextureKey(labels.content_id());
        if let Some(known) = device.store().get(&key) {
            return Ok(known);
        }
        let numbers = self.store.find(&LabelNumbersKey(key.0), control, || {
            labels.numbers_under(control)
        })?;
        let texture = LabelTexture::new(device, labels.grid().dims(), &numbers, self.most)?;
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
        let values = self.store.find(&ValuesKey(mask.id()), control, || {
            mask.values_under(control)
        })?;
        self.texture(device, &values, control).await
    }
}

/// Whether single precision has every voxel. Texture units may leave out what they give no weight, and so find
/// numbers beside voxels that have none. Whoever resolved the Plan has counted those already.
fn has_all_values(volume: &Volume) -> bool {
    if volume.sample_type().is_integer() {
        return true;
    }
    let (statistics, rescale) = (volume.statistics(), volume.rescale());
    let stored = statistics
        .range
        .map(|value| (value - rescale.intercept) / rescale.slope);
    statistics.not_finite == 0 && stored.iter().all(|n| n.abs() < f64::from(f32::MAX))
}

/// Whether the texture of a mask has its stored numbers: above a threshold is above it in the numbers of the texture
/// only if both grow together.
fn holds_stored_numbers(device: &Device, mask: &Volume) -> bool {
    let texels = Storage::of(mask.sample_type(), device).texels;
    let is_float = matches!(texels, Texels::Float | Texels::UnfilterableFloat);
    is_float && mask.rescale().slope > 0.0
}

/// The field of `plan` that reads volume `volume`. Those of one volume read it alike.
fn reader(plan: &Plan, volume: usize) -> Option<&Field> {
    plan.drawn_fields().find(|field| field.volume == volume)
}

/// What a picture reads on the device.
pub struct DeviceData {
    volumes: Vec<VolumeOnDevice>,
    masks: Vec<Arc<VolumeTexture>>,
    /// The segments that are drawn.
    pub labels: Option<Arc<LabelTexture>>,
    pub meshes: Vec<Arc<MeshCorners>>,
}

/// A volume, or coefficients in its place, on the device, and its bricks here.
struct VolumeOnDevice {
    source: ContentId,
    texture: Arc<VolumeTexture>,
    bricks: Arc<Bricks>,
}

impl DeviceData {
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
