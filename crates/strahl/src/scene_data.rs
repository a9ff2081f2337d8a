//! Reads everything that a scene names: volumes, masks, meshes, shader functions.

use crate::Error;
use crate::confinement::Confinement;
use crate::folder::{Folder, file_name};
use crate::picture::CarriedFiles;
use crate::scene_file::check_paths;
use crate::session::{ReadLabels, Session};
use std::any::Any;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use strahl_scene::{
    Clip, Headers, LabelHeader, LabelSource, MaskClip, NamedMask, PresetInfo, Scene, VolumeSource,
    segment_notes,
};
use strahl_shader::Module;
use strahl_volume::read::ReadOptions;
use strahl_volume::read::mesh::read_mesh_under;
use strahl_volume::{Control, Datasets, LabelVolume, Mesh, Phantom, Volume, VolumeHeader};

/// Which volume is a scene's own.
pub(crate) enum OwnVolume<'o> {
    /// A volume in memory.
    Volume(&'o Volume),
    /// A phantom with as many voxels.
    Phantom(Phantom, [usize; 3]),
    /// The volume in these files, which the scene names.
    Files(Vec<PathBuf>, ReadOptions),
    /// The same in files that were named beside the scene, wherever they lie.
    Given(Vec<PathBuf>, ReadOptions),
}

/// Who reads, where, and who may end it.
#[derive(Clone, Copy)]
struct Reading<'r> {
    session: &'r Session,
    /// Where the scene may read, if not everywhere.
    within: Option<&'r Confinement>,
    control: &'r Control,
}

impl<'r> Reading<'r> {
    /// The same for the file or folder `path`, whose reader may look around if somebody else than the scene named it.
    fn of(self, path: &Path) -> Reading<'r> {
        Reading {
            within: self.within.filter(|within| !within.allows_anywhere(path)),
            ..self
        }
    }
}

/// The data of a scene.
pub(crate) struct SceneData {
    /// The scene's own volume, then those of its objects, at the level that is drawn.
    volumes: Vec<Volume>,
    /// Their headers at level 0.
    whole: Vec<VolumeHeader>,
    /// Those of the clips, then the importance volume.
    masks: Vec<Volume>,
    meshes: Vec<Mesh>,
    labels: Option<LabelVolume>,
    modules: BTreeMap<String, Arc<Module>>,
    /// The texts of the modules.
    pub carried: CarriedFiles,
    /// What the user should know.
    pub notes: Vec<String>,
    /// What the session keeps, which must not be given up while this is there.
    held: Vec<Arc<dyn Any + Send + Sync>>,
}

impl SceneData {
    /// Has `session` read what `scene` names, with the volume that `own` says as its own. Files that are `carried` are
    /// not read.
    pub fn load(
        session: &Session,
        scene: &Scene,
        own: OwnVolume,
        carried: &CarriedFiles,
        within: Option<&Confinement>,
        control: &Control,
    ) -> Result<SceneData, Error> {
        scene.check_counts()?;
        let level = scene.volume.as_ref().and_then(|volume| volume.level);
        let mut data = SceneData {
            volumes: Vec::new(),
            whole: Vec::new(),
            masks: Vec::new(),
            meshes: Vec::new(),
            labels: None,
            modules: BTreeMap::new(),
            carried: CarriedFiles::default(),
            notes: Vec::new(),
            held: Vec::new(),
        };
        let reading = Reading {
            session,
            within,
            control,
        };
        if let Some(within) = within {
            check_paths(scene, carried, within)?;
        }
        // A file that says that it holds labels is not a scan, unless the scene says how its numbers are drawn.
        let source = scene.labels.clone().unwrap_or_default();
        source.check_itself()?;
        let mut labels_in = source.path.clone();
        let preset = scene.preset.as_deref().and_then(PresetInfo::find);
        let of_segments = preset.is_some_and(|preset| preset.scene().segments.is_some());
        let draws_values = scene.method.is_some()
            || (scene.preset.is_some() && !of_segments)
            || scene.transfer_function.is_some()
            || scene.debug.is_some()
            || scene.graph.is_some();
        let is_given = matches!(own, OwnVolume::Given(..));
        let own = match own {
            OwnVolume::Volume(volume) => volume.clone(),
            OwnVolume::Phantom(phantom, dims) => {
                let are_asked = scene.segments.is_some() || scene.labels.is_some() || of_segments;
                if !source.has_data() && are_asked {
                    let labels = session.phantom_labels(phantom, dims, control)?;
                    data.labels = Option::clone(&labels);
                    data.held.push(labels);
                }
                data.hold(session.phantom(phantom, dims, control)?)
            }
            OwnVolume::Files(paths, options) | OwnVolume::Given(paths, options) => {
                // Given files may lie anywhere.
                let within = within.filter(|_| !is_given);
                let reading = Reading { within, ..reading };
                let read = session.volume(&paths, &options, within, control)?;
                let brings_labels = read.value.labels.is_some() && !source.has_data();
                if let (true, false, [path]) = (brings_labels, draws_values, &paths[..]) {
                    labels_in = path.to_str().map(str::to_owned);
                }
                data.read_files(reading, &paths, &options)?
            }
        };
        data.add_volume(reading, own, level)?;
        // Labels in a given file are given, too.
        let is_given = is_given && !source.has_data();
        let of_labels = Reading {
            within: within.filter(|_| !is_given),
            ..reading
        };
        data.load_labels(of_labels, scene, &source, labels_in)?;
        for object in scene.objects.iter().flatten() {
            if let Some(source) = &object.volume {
                let volume = data.read_volume(reading, source)?;
                data.add_volume(reading, volume, source.level)?;
            }
            if let Some(path) = &object.mesh {
                let path = Path::new(path);
                fs::metadata(path).map_err(|error| Error::path(path, error))?;
                let read = session.mesh(path, control, || {
                    let (name, folder) = (file_name(path), Folder::around(path));
                    Ok(read_mesh_under(&name, &folder, None, control)?)
                })?;
                data.notes.extend(read.value.notes.iter().cloned());
                data.meshes.push(read.value.mesh.clone());
                data.held.push(read);
            }
        }
        for (i, clip) in scene.clips.iter().flatten().enumerate() {
            if let Clip::Mask(mask) = clip {
                let mask = data.read_mask(reading, mask, &format!("clips[{i}]"))?;
                data.masks.push(mask);
            }
        }
        if let Some(importance) = &scene.importance {
            let path = PathBuf::from(&importance.path);
            let volume = data.read_files(reading, &[path], &ReadOptions::default())?;
            data.masks.push(volume);
        }
        for function in scene.functions.iter().flat_map(BTreeMap::values) {
            if function.is_file() && !data.modules.contains_key(&function.module) {
                let text = match carried.file(&function.module) {
                    Some(text) => text.to_vec(),
                    None => read_module(Path::new(&function.module))?,
                };
                data.carried.add_file(&function.module, &text);
                let module = module_of(Path::new(&function.module), text)?;
                data.modules
                    .insert(function.module.clone(), Arc::new(module));
            }
        }
        Ok(data)
    }

    /// The labels whose segments are drawn: those that `source` says, or those in the file `path`.
    fn load_labels(
        &mut self,
        reading: Reading,
        scene: &Scene,
        source: &LabelSource,
        path: Option<String>,
    ) -> Result<(), Error> {
        let Reading {
            session, control, ..
        } = reading;
        if let Some(path) = path {
            // The table has been checked with all paths of the scene.
            let reading = reading.of(Path::new(&path));
            let read = self.read_labels(reading, &path, source.table.as_deref())?;
            self.labels = Some(read.value.0.clone());
            self.held.push(read);
        } else if let Some(masks) = &source.masks {
            let read = self.read_masks(reading, masks)?;
            self.labels = Some(read.value.0.clone());
            self.held.push(read);
        } else if let Some(layers) = &source.layers {
            let made = session.layers(&self.volumes[0], layers, control)?;
            self.labels = Some(LabelVolume::clone(&made));
            self.held.push(made);
        }
        if let Some(labels) = &self.labels {
            self.notes.extend(segment_notes(scene, &labels.into()));
        } else {
            for (key, is_set) in [
                ("labels", scene.labels.is_some()),
                ("techniques", scene.techniques.is_some()),
                ("composite", scene.composite.is_some()),
            ] {
                if is_set {
                    let note = match key {
                        "labels" => "labels names no file, masks or layers, and the volume has none of its own".to_owned(),
                        _ => format!("{key} has no effect without labels (key `labels`)"),
                    };
                    self.notes.push(note);
                }
            }
            let preset = scene.preset.as_deref().and_then(PresetInfo::find);
            if let Some(preset) = preset.filter(|preset| preset.scene().segments.is_some()) {
                self.notes.push(format!(
                    "the preset {} draws segments, and the volume has no labels: it is drawn as a whole; set `labels`, or choose another preset",
                    preset.name
                ));
            }
        }
        Ok(())
    }

    /// A volume that the session keeps.
    fn hold(&mut self, volume: Arc<Volume>) -> Volume {
        self.held.push(volume.clone());
        Volume::clone(&volume)
    }

    /// Adds `volume`, as coarse as a scene says.
    fn add_volume(
        &mut self,
        Reading {
            session, control, ..
        }: Reading,
        volume: Volume,
        level: Option<f64>,
    ) -> Result<(), Error> {
        self.whole.push(volume.header());
        let volume = match level {
            // What is no level is refused with the rest of the scene.
            Some(level) if level > 0.0 && level.is_finite() => {
                self.hold(session.level(&volume, level, control)?)
            }
            _ => volume,
        };
        self.volumes.push(volume);
        Ok(())
    }

    fn read_volume(&mut self, reading: Reading, source: &VolumeSource) -> Result<Volume, Error> {
        let options = source.read_options()?;
        // One of the two is there and known, as has just been checked.
        if let Some(phantom) = source.phantom.as_deref().and_then(Phantom::from_name) {
            let dims = source.dims.unwrap_or(phantom.default_dims());
            let Reading {
                session, control, ..
            } = reading;
            return Ok(self.hold(session.phantom(phantom, dims, control)?));
        }
        let path = PathBuf::from(source.path.clone().unwrap_or_default());
        self.read_files(reading, &[path], &options)
    }

    fn read_files(
        &mut self,
        Reading {
            session,
            within,
            control,
        }: Reading,
        paths: &[PathBuf],
        options: &ReadOptions,
    ) -> Result<Volume, Error> {
        let read = session.volume(paths, options, within, control)?;
        self.notes.extend(read.value.notes.iter().cloned());
        let volume = read.value.volume.clone();
        self.held.push(read);
        Ok(volume)
    }

    /// The mask of a clip, which is at `place` in the scene.
    fn read_mask(
        &mut self,
        reading: Reading,
        clip: &MaskClip,
        place: &str,
    ) -> Result<Volume, Error> {
        let Reading {
            session,
            within,
            control,
        } = reading;
        if clip.labels.is_none() {
            let options = ReadOptions::default();
            let read = session.volume(&[PathBuf::from(&clip.path)], &options, within, control)?;
            let volume = read.value.volume.clone();
            self.held.push(read);
            return Ok(volume);
        }
        let labels = self.read_labels(reading, &clip.path, None)?;
        let labels = &labels.value.0;
        let ids = clip.label_ids(place, labels)?;
        Ok(self.hold(session.mask(&ids, labels, control)?))
    }

    fn read_labels(
        &mut self,
        Reading {
            session,
            within,
            control,
        }: Reading,
        path: &str,
        table: Option<&str>,
    ) -> Result<Arc<ReadLabels>, Error> {
        let read = session.labels(path, table, within, control)?;
        let notes = read.value.1.iter().map(|note| format!("{path}: {note}"));
        self.notes.extend(notes);
        Ok(read)
    }

    /// The label volume that `masks` make.
    fn read_masks(
        &mut self,
        Reading {
            session,
            within,
            control,
        }: Reading,
        masks: &[NamedMask],
    ) -> Result<Arc<ReadLabels>, Error> {
        let read = session.masks(masks, within, control)?;
        self.notes.extend(read.value.1.iter().cloned());
        Ok(read)
    }

    /// What resolving a scene has to know.
    pub fn headers(&self) -> Headers {
        let drawn = self.volumes.iter().zip(&self.whole).enumerate();
        Headers {
            volumes: self.whole.clone(),
            coarser: drawn
                .filter(|(_, (volume, whole))| *volume.grid() != whole.grid)
                .map(|(i, (volume, _))| (i, volume.header()))
                .collect(),
            labels: self.labels.as_ref().map(LabelHeader::from),
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
    pub fn datasets(&self) -> Datasets {
        Datasets {
            volumes: self.volumes.clone(),
            labels: self.labels.iter().cloned().collect(),
            masks: self.masks.clone(),
            meshes: self.meshes.clone(),
        }
    }
}

/// The bytes of the shader function in a file.
#[cfg(feature = "graph")]
fn read_module(path: &Path) -> Result<Vec<u8>, Error> {
    use crate::confinement::open_regular;
    use std::io::Read;
    let mut text = Vec::new();
    let fail = |error| Error::path(path, error);
    let file = open_regular(path).map_err(fail)?;
    // One more, so that the parser sees what is too long and has the words for it.
    file.take(strahl_shader::MOST_MODULE_BYTES as u64 + 1)
        .read_to_end(&mut text)
        .map_err(fail)?;
    Ok(text)
}

/// They are not read.
#[cfg(not(feature = "graph"))]
fn read_module(_path: &Path) -> Result<Vec<u8>, Error> {
    Ok(Vec::new())
}

/// The shader function in a file.
#[cfg(not(feature = "graph"))]
fn module_of(path: &Path, _text: Vec<u8>) -> Result<Module, Error> {
    Err(Error::NoGraphs {
        file: Some(path.to_owned()),
        what: "a shader function of a file",
    })
}

/// The shader function in a file.
#[cfg(feature = "graph")]
fn module_of(path: &Path, text: Vec<u8>) -> Result<Module, Error> {
    let text = String::from_utf8(text)
        .map_err(|_| Error::not_usable(path, "a shader function is text in UTF-8"))?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    Ok(Module::parse(&stem, &path.display().to_string(), &text)?)
}
