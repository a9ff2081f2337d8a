//! The data of pictures, as programs read it.

use crate::error::Error;
use crate::resources::{Numbers, Texture};
use std::sync::Arc;
use strahl_scene::Source;
use strahl_scene::plan::{Field, Plan};
use strahl_volume::bricks::Bricks;
use strahl_volume::{
    ContentId, Control, Datasets, LabelIds, LabelNumbers, LabelNumbersKey, Mesh, Rescale, Store,
    ValuesKey, Volume, with_samples,
};

/// What a Plan reads of its data.
pub struct Data<'d> {
    datasets: &'d Datasets,
    /// What each object is reconstructed from, by its volume: the voxels, or in their place the coefficients that
    /// interpolating B-splines read; with the bricks. `None` for volumes that no object shows.
    read: Vec<Option<(Source, Arc<Bricks>)>>,
    masks: Vec<Arc<Volume>>,
    /// Of the label volume whose segments are drawn.
    label_numbers: Option<Arc<LabelNumbers>>,
}

/// A threshold in values, in the numbers of the texture of mask `mask`.
pub fn mask_threshold(datasets: &Datasets, mask: usize, threshold: f32) -> f64 {
    let rescale = datasets.masks[mask].rescale();
    match rescale.slope > 0.0 {
        true => rescale.stored(f64::from(threshold)),
        // Such masks are read as their values.
        false => f64::from(threshold),
    }
}

impl<'d> Data<'d> {
    /// Finds in `store`, or makes under `control`, what `plan` reads beside the data itself.
    pub fn new(
        datasets: &'d Datasets,
        plan: &Plan,
        store: &Store,
        control: &Control,
    ) -> Result<Data<'d>, Error> {
        plan.check(datasets)?;
        let mut read = vec![None; datasets.volumes.len()];
        for field in plan.drawn_fields() {
            let source = Source::find(field, datasets, store, control)?;
            let bricks = source.bricks(store, control)?;
            read[field.volume] = Some((source, bricks));
        }
        let mut masks = Vec::new();
        for mask in &datasets.masks {
            masks.push(match mask.rescale().slope > 0.0 {
                true => Arc::new(mask.clone()),
                false => store.find(&ValuesKey(mask.id()), control, || {
                    mask.values_under(control)
                })?,
            });
        }
        let label_numbers = match plan.labeled() {
            Some(labeled) => {
                let labels = &datasets.labels[labeled.labels];
                let key = LabelNumbersKey(labels.content_id());
                Some(store.find(&key, control, || labels.numbers_under(control))?)
            }
            None => None,
        };
        Ok(Data {
            datasets,
            read,
            masks,
            label_numbers,
        })
    }

    /// A value of mask `mask`, in the numbers of its texture.
    pub fn mask_number(&self, mask: usize, value: f32) -> f64 {
        mask_threshold(self.datasets, mask, value)
    }

    /// The opaque surfaces.
    pub fn meshes(&self) -> &'d [Mesh] {
        &self.datasets.meshes
    }

    /// Of each object of `plan`, what it is reconstructed from, and its bricks.
    pub fn of_objects(&self, plan: &Plan) -> Vec<(ContentId, &Bricks)> {
        let mut found = Vec::new();
        for field in plan.drawn_fields() {
            if let Some((source, bricks)) = &self.read[field.volume] {
                found.push((source.volume.id(), &**bricks));
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
            Some((source, _)) => &source.volume,
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

    /// The numbers of the segments, if those of a label volume are drawn.
    pub fn segments(&self) -> Option<&LabelNumbers> {
        self.label_numbers.as_deref()
    }

    /// Their texture.
    pub fn labels(&self, plan: &Plan) -> Option<Result<Texture<'_>, Error>> {
        let LabelNumbers { numbers, .. } = self.segments()?;
        let labels = &self.datasets.labels[plan.labeled()?.labels];
        let numbers: Vec<u32> = match numbers {
            LabelIds::U8(numbers) => numbers.iter().map(|n| u32::from(*n)).collect(),
            LabelIds::U16(numbers) => numbers.iter().map(|n| u32::from(*n)).collect(),
            LabelIds::U32(numbers) => numbers.clone(),
        };
        let dims = labels.grid().dims().map(|n| n as u32);
        Some(Texture::new(dims, 1, Numbers::U32(numbers.into())))
    }

    /// The texture of mask `mask`, if there is one.
    pub fn mask(&self, mask: usize) -> Option<Result<Texture<'_>, Error>> {
        let mask = self.masks.get(mask)?;
        let dims = mask.grid().dims().map(|n| n as u32);
        Some(Texture::new(dims, 1, Numbers::Stored(mask.samples())))
    }

    /// value = slope · texel + intercept: slope and intercept.
    pub fn value_of_texel(&self, field: &Field) -> (f64, f64) {
        let Rescale { slope, intercept } = field.read_rescale();
        (slope, intercept)
    }
}
