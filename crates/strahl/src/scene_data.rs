//! Everything that a scene names, read: volumes, masks, meshes, shader functions.

use crate::folder::{Folder, file_name};
use crate::{Error, load, load_with_progress};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use strahl_scene::{Clip, Headers, MaskClip, Scene, VolumeSource};
use strahl_shader::{MOST_MODULE_BYTES, Module};
use strahl_volume::read::ReadOptions;
use strahl_volume::read::mesh::read_mesh;
use strahl_volume::{Datasets, Grid, LabelVolume, Mesh, Phantom, Volume};

/// The data of a scene.
pub(crate) struct SceneData<'a> {
    /// The scene's own volume, then those of its objects.
    volumes: Vec<Cow<'a, Volume>>,
    masks: Vec<Volume>,
    meshes: Vec<Mesh>,
    labels: Option<Grid>,
    modules: BTreeMap<String, Arc<Module>>,
    /// What the user should know.
    pub notes: Vec<String>,
}

impl<'a> SceneData<'a> {
    /// Reads what `scene` names beside its own volume, which is `own`, with `notes` about it.
    pub fn load(
        scene: &Scene,
        own: Cow<'a, Volume>,
        notes: Vec<String>,
    ) -> Result<SceneData<'a>, Error> {
        let level = scene.volume.as_ref().and_then(|volume| volume.level);
        let mut data = SceneData {
            volumes: vec![at_level(own, level)?],
            masks: Vec::new(),
            meshes: Vec::new(),
            labels: None,
            modules: BTreeMap::new(),
            notes,
        };
        for object in scene.objects.iter().flatten() {
            if let Some(source) = &object.volume {
                let volume = data.read_volume(source)?;
                data.volumes
                    .push(at_level(Cow::Owned(volume), source.level)?);
            }
            if let Some(path) = &object.mesh {
                let path = Path::new(path);
                fs::metadata(path).map_err(|error| Error::path(path, error))?;
                let loaded = read_mesh(&file_name(path), &Folder::around(path), None)?;
                data.notes.extend(loaded.notes);
                data.meshes.push(loaded.mesh);
            }
        }
        for (i, clip) in scene.clips.iter().flatten().enumerate() {
            if let Clip::Mask(mask) = clip {
                let mask = data.read_mask(mask, &format!("clips[{i}]"))?;
                data.masks.push(mask);
            }
        }
        if let Some(labels) = &scene.labels {
            data.labels = Some(*data.read_labels(&labels.path)?.grid());
            data.notes.push(
                "the labels lie on the volume's grid; drawing them is not there yet (a clip `mask` with `labels` shows or hides some)"
                    .into(),
            );
        }
        for function in scene.functions.iter().flat_map(BTreeMap::values) {
            if function.is_file() && !data.modules.contains_key(&function.module) {
                let module = read_module(Path::new(&function.module))?;
                data.modules
                    .insert(function.module.clone(), Arc::new(module));
            }
        }
        Ok(data)
    }

    fn read_volume(&mut self, source: &VolumeSource) -> Result<Volume, Error> {
        let options = source.read_options()?;
        // One of the two is there and known, as has just been checked.
        if let Some(phantom) = source.phantom.as_deref().and_then(Phantom::from_name) {
            return Ok(phantom.volume(source.dims.unwrap_or(phantom.default_dims()))?);
        }
        let path = PathBuf::from(source.path.clone().unwrap_or_default());
        let loaded = load_with_progress(&[path], &options, &|_| ())?;
        self.notes.extend(loaded.notes);
        Ok(loaded.volume)
    }

    /// The mask of a clip, which is at `place` in the scene.
    fn read_mask(&mut self, clip: &MaskClip, place: &str) -> Result<Volume, Error> {
        if clip.labels.is_none() {
            return Ok(load(&clip.path, &ReadOptions::default())?.volume);
        }
        let labels = self.read_labels(&clip.path)?;
        let ids = clip.label_ids(place, &labels)?;
        Ok(labels.mask(&ids))
    }

    fn read_labels(&mut self, path: &str) -> Result<LabelVolume, Error> {
        let loaded = load(path, &ReadOptions::default())?;
        let notes = loaded.notes.iter().map(|note| format!("{path}: {note}"));
        self.notes.extend(notes);
        let labels = LabelVolume::from_volume(loaded.volume, loaded.labels.unwrap_or_default());
        labels.map_err(|error| error.in_file(path).into())
    }

    /// What resolving a scene has to know.
    pub fn headers(&self) -> Headers {
        Headers {
            volumes: self.volumes.iter().map(|volume| volume.header()).collect(),
            labels: self.labels,
            masks: self.masks.iter().map(|mask| *mask.grid()).collect(),
            meshes: self
                .meshes
                .iter()
                .map(|mesh| mesh.bounds_mm().into())
                .collect(),
            modules: self.modules.clone(),
        }
    }

    /// What a renderer draws from.
    pub fn datasets(&self) -> Datasets<'_> {
        Datasets {
            volumes: self.volumes.iter().map(|volume| &**volume).collect(),
            masks: self.masks.iter().collect(),
            meshes: self.meshes.iter().collect(),
        }
    }
}

/// `volume` as coarse as a scene says.
fn at_level(volume: Cow<'_, Volume>, level: Option<f64>) -> Result<Cow<'_, Volume>, Error> {
    match level {
        // What is no level is refused with the rest of the scene.
        Some(level) if level > 0.0 && level.is_finite() => Ok(Cow::Owned(volume.at_level(level)?)),
        _ => Ok(volume),
    }
}

/// The shader function in a file.
fn read_module(path: &Path) -> Result<Module, Error> {
    use std::io::Read;
    let fail = |error| Error::path(path, error);
    let mut text = Vec::new();
    let file = fs::File::open(path).map_err(fail)?;
    // One more, so that the parser sees what is too long and has the words for it.
    file.take(MOST_MODULE_BYTES as u64 + 1)
        .read_to_end(&mut text)
        .map_err(fail)?;
    let text = String::from_utf8(text)
        .map_err(|_| Error::not_usable(path, "a shader function is text in UTF-8"))?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    Ok(Module::parse(&stem, &path.display().to_string(), &text)?)
}
