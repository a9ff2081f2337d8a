//! Sessions keep data, derived data, devices and threads from picture to picture.

use crate::Error;
use crate::confinement::Confinement;
#[cfg(feature = "gpu")]
use crate::devices::Devices;
use crate::folder::file_name;
use crate::load::{Seen, load_label_table, load_seen};
use std::path::{Path, PathBuf};
use std::sync::Arc;
#[cfg(feature = "graph")]
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;
use std::{fs, io};
use strahl_cpu::Pools;
#[cfg(feature = "graph")]
use strahl_evaluate::Evaluator;
use strahl_scene::{NamedMask, ValueLayers};
#[cfg(feature = "graph")]
use strahl_volume::Datasets;
use strahl_volume::read::mesh::LoadedMesh;
use strahl_volume::read::{LoadedVolume, ReadOptions, stem_of};
use strahl_volume::{
    ContentId, Control, Counts, Key, LabelVolume, MergedMasks, Metadata, Phantom, Store, Volume,
};

/// Draws scenes and keeps what the next picture needs too: the data of scenes, derived data,
/// the graphics device, and thread pools. Several threads may use it at the same time.
///
/// ```
/// use strahl::{Backend, Control, Phantom, Render, Session, View};
///
/// let session = Session::new();
/// for view in [View::Front, View::Left, View::Top] {
///     Render::phantom(Phantom::Tree)
///         .size(64, 48)
///         .view(view)
///         .in_session(&session)
///         .picture()?;
/// }
/// // The volume was computed once, and so was what drawing needs of it.
/// assert_eq!(session.read().made, 1);
/// assert_eq!(session.derived().made_by_name["bricks"], 1);
/// # Ok::<(), strahl::Error>(())
/// ```
///
/// A file is read again if its length or modification time has changed.
pub struct Session {
    /// Data that was read or computed. Stays until [`Session::forget`].
    files: Store,
    store: Arc<Store>,
    pools: Pools,
    #[cfg(feature = "graph")]
    evaluators: Mutex<Vec<Evaluator>>,
    #[cfg(feature = "gpu")]
    devices: Devices,
}

impl Default for Session {
    fn default() -> Session {
        Session::new()
    }
}

impl Session {
    /// A session that keeps up to [`Store::USUAL_BUDGET_BYTES`] of derived data. It opens a
    /// device when a picture needs one.
    pub fn new() -> Session {
        Session::with_budget(Store::USUAL_BUDGET_BYTES)
    }

    /// A session that keeps up to `budget_bytes` of derived data. The data itself does not
    /// count. A device has a budget of its own (`Device::with_budget`).
    pub fn with_budget(budget_bytes: usize) -> Session {
        let store = Arc::new(Store::with_budget(budget_bytes));
        Session {
            files: Store::with_budget(usize::MAX),
            pools: Pools::default(),
            #[cfg(feature = "graph")]
            evaluators: Mutex::default(),
            #[cfg(feature = "gpu")]
            devices: Devices::new(store.clone()),
            store,
        }
    }

    /// Draws on `device`, for example that of a window, if a picture asks for a GPU without
    /// naming one.
    #[cfg(feature = "gpu")]
    pub fn on_device(mut self, device: strahl_gpu::Device) -> Session {
        self.devices.give(device);
        self
    }

    /// Volumes, labels and meshes that were read or computed so far.
    pub fn read(&self) -> Counts {
        self.files.counts()
    }

    /// Derived data that was computed so far.
    pub fn derived(&self) -> Counts {
        self.store.counts()
    }

    /// Number of graphics devices that were opened so far.
    #[cfg(feature = "gpu")]
    pub fn devices_opened(&self) -> u64 {
        self.devices.opened()
    }

    #[cfg(feature = "gpu")]
    pub(crate) fn devices(&self) -> &Devices {
        &self.devices
    }

    /// Drops data and derived data that no current picture uses.
    pub fn forget(&self) {
        self.store.clear();
        self.files.clear();
    }

    pub(crate) fn store(&self) -> &Arc<Store> {
        &self.store
    }

    pub(crate) fn pools(&self) -> &Pools {
        &self.pools
    }

    /// Runs `work` with an evaluator that nobody else uses. (It does not wait for one: a thread
    /// of a pool that waits may have to draw a second picture meanwhile.)
    #[cfg(feature = "graph")]
    pub(crate) fn with_evaluator<R>(&self, work: impl FnOnce(&mut Evaluator) -> R) -> R {
        let all = || {
            self.evaluators
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
        };
        let free = all().pop();
        let new = || Evaluator::with_store(Datasets::default(), self.store.clone());
        let mut evaluator = free.unwrap_or_else(new);
        let done = work(&mut evaluator);
        evaluator.set_data(Datasets::default());
        all().push(evaluator);
        done
    }

    /// The volume in `paths`, read if necessary.
    pub(crate) fn volume(
        &self,
        paths: &[PathBuf],
        options: &ReadOptions,
        within: Option<&Confinement>,
        control: &Control,
    ) -> Result<Arc<Read<LoadedVolume>>, Error> {
        let key = VolumeKey {
            files: States::of(paths)?,
            options: options.clone(),
        };
        self.found(&key, control, || {
            let (value, seen) = load_seen(paths, options, within, control)?;
            Ok(Read { value, seen })
        })
    }

    /// The label volume in the file or folder `path`, with the notes of its reader. Names and colors
    /// are those of the file `table` if there is one.
    pub(crate) fn labels(
        &self,
        path: &str,
        table: Option<&str>,
        within: Option<&Confinement>,
        control: &Control,
    ) -> Result<Arc<ReadLabels>, Error> {
        let table = table.map(PathBuf::from);
        if let (Some(within), Some(table)) = (within, &table) {
            within.check(table)?;
        }
        let paths = [PathBuf::from(path)];
        let key = LabelsKey {
            files: States::of(&paths)?,
            table: table
                .as_ref()
                .map(|table| States::of(std::slice::from_ref(table)))
                .transpose()?,
        };
        self.found(&key, control, || {
            let options = ReadOptions {
                as_labels: true,
                label_table: table.map(load_label_table).transpose()?,
                ..ReadOptions::default()
            };
            let (loaded, seen) = load_seen(&paths, &options, within, control)?;
            let labels = LabelVolume::from_volume(loaded.volume, loaded.labels.unwrap_or_default());
            let labels = labels.map_err(|error| error.in_file(path))?;
            Ok(Read {
                value: (labels, loaded.notes),
                seen,
            })
        })
    }

    /// The label volume that `masks` make, with notes.
    pub(crate) fn masks(
        &self,
        masks: &[NamedMask],
        within: Option<&Confinement>,
        control: &Control,
    ) -> Result<Arc<ReadLabels>, Error> {
        let paths: Vec<PathBuf> = masks.iter().map(|mask| PathBuf::from(&mask.path)).collect();
        let key = NamedMasksKey {
            files: States::of(&paths)?,
            masks: masks.to_vec(),
        };
        self.found(&key, control, || {
            let (mut merged, mut seen, mut notes) = (None, Seen::default(), Vec::new());
            let mut labels = Vec::new();
            for (id, mask) in (1..).zip(masks) {
                let path = &mask.path;
                let paths = [PathBuf::from(path)];
                // Only the ids are kept.
                let options = ReadOptions::default();
                let (loaded, opened) = load_seen(&paths, &options, within, control)?;
                seen.extend(opened);
                notes.extend(loaded.notes.iter().map(|note| format!("{path}: {note}")));
                let volume = &loaded.volume;
                let merged = match &mut merged {
                    Some(merged) => merged,
                    None => merged.insert(MergedMasks::new(volume.grid())?),
                };
                merged.add(volume, path, &masks[0].path)?;
                labels.push(mask.label(id, stem_of(&file_name(&paths[0]))));
            }
            // A list without masks has been refused.
            let Some(merged) = merged else {
                return Err(Error::not_usable(Path::new(""), "no mask is named"));
            };
            if merged.overlaps() > 0 {
                let overlaps = merged.overlaps();
                notes.push(format!(
                    "labels.masks: {overlaps} voxels are in several masks; the last one is kept"
                ));
            }
            let volume = merged.into_volume(Metadata::default())?;
            let labels = LabelVolume::from_volume(volume, labels)?;
            Ok(Read {
                value: (labels, notes),
                seen,
            })
        })
    }

    /// The layers of the values of `volume`.
    pub(crate) fn layers(
        &self,
        volume: &Volume,
        layers: &ValueLayers,
        control: &Control,
    ) -> Result<Arc<LabelVolume>, Error> {
        let key = LayersKey(volume.id(), layers.clone());
        self.store.find(&key, control, || {
            let thresholds = layers.thresholds(volume.statistics_under(control)?.range);
            let labels = layers.labels();
            Ok(LabelVolume::of_layers(
                volume,
                &thresholds,
                labels,
                control,
            )?)
        })
    }

    /// The mask of some of the `labels`.
    pub(crate) fn mask(
        &self,
        ids: &[u32],
        labels: &LabelVolume,
        control: &Control,
    ) -> Result<Arc<Volume>, Error> {
        let key = MaskKey {
            labels: labels.content_id(),
            ids: ids.to_owned(),
        };
        let make = || Ok::<_, Error>(labels.mask(ids)?);
        self.store.find(&key, control, make)
    }

    /// The mesh in the file `path`, read by `read` if necessary.
    pub(crate) fn mesh(
        &self,
        path: &Path,
        control: &Control,
        read: impl FnOnce() -> Result<LoadedMesh, Error>,
    ) -> Result<Arc<Read<LoadedMesh>>, Error> {
        let key = MeshKey(States::of(&[path.to_owned()])?);
        self.found(&key, control, || {
            Ok(Read {
                value: read()?,
                seen: Seen::default(),
            })
        })
    }

    /// A phantom, computed if necessary.
    pub(crate) fn phantom(
        &self,
        phantom: Phantom,
        dims: [usize; 3],
        control: &Control,
    ) -> Result<Arc<Volume>, Error> {
        let make = || Ok::<_, Error>(phantom.volume_under(dims, control)?);
        self.files.find(&PhantomKey(phantom, dims), control, make)
    }

    /// The labels of a phantom that has some, computed unless they are known.
    pub(crate) fn phantom_labels(
        &self,
        phantom: Phantom,
        dims: [usize; 3],
        control: &Control,
    ) -> Result<Arc<Option<LabelVolume>>, Error> {
        let make = || Ok::<_, Error>(phantom.labels(dims)?);
        let key = PhantomLabelsKey(phantom, dims);
        self.files.find(&key, control, make)
    }

    /// A coarser version of a volume.
    pub(crate) fn level(
        &self,
        volume: &Volume,
        level: f64,
        control: &Control,
    ) -> Result<Arc<Volume>, Error> {
        let make = || Ok::<_, Error>(volume.at_level_under(level, control)?);
        let key = LevelKey(volume.id(), level);
        self.store.find(&key, control, make)
    }

    /// The entry of `key` if its files have not changed, otherwise the result of `read`.
    fn found<T, K: Key<Value = Read<T>>>(
        &self,
        key: &K,
        control: &Control,
        read: impl FnOnce() -> Result<Read<T>, Error>,
    ) -> Result<Arc<Read<T>>, Error> {
        let is_old = |known: Arc<Read<T>>| !known.seen.is_same();
        if self.files.get(key).is_some_and(is_old) {
            self.files.remove(key);
        }
        self.files.find(key, control, read)
    }
}

/// Something that was read, and what was seen of files for it.
pub(crate) struct Read<T> {
    pub value: T,
    seen: Seen,
}

/// Labels, and the notes of their reader.
pub(crate) type ReadLabels = Read<(LabelVolume, Vec<String>)>;

/// The current state of files and folders that were named.
#[derive(Clone, PartialEq)]
struct States(Vec<(PathBuf, u64, Option<SystemTime>)>);

impl States {
    fn of(paths: &[PathBuf]) -> Result<States, Error> {
        let state = |path: &PathBuf| {
            let metadata = fs::metadata(path)?;
            let whole = std::path::absolute(path)?;
            Ok((whole, metadata.len(), metadata.modified().ok()))
        };
        let named = |path: &PathBuf| state(path).map_err(|why: io::Error| Error::path(path, why));
        Ok(States(paths.iter().map(named).collect::<Result<_, _>>()?))
    }
}

#[derive(Clone, PartialEq)]
struct VolumeKey {
    files: States,
    options: ReadOptions,
}

impl Key for VolumeKey {
    type Value = Read<LoadedVolume>;

    const NAME: &str = "volumes";

    fn bytes(&self, value: &Read<LoadedVolume>) -> usize {
        value.value.volume.samples().as_bytes().len()
    }
}

#[derive(Clone, PartialEq)]
struct LabelsKey {
    files: States,
    table: Option<States>,
}

impl Key for LabelsKey {
    type Value = ReadLabels;

    const NAME: &str = "labels";

    fn bytes(&self, value: &Self::Value) -> usize {
        value.value.0.byte_count()
    }
}

#[derive(Clone, PartialEq)]
struct NamedMasksKey {
    files: States,
    masks: Vec<NamedMask>,
}

impl Key for NamedMasksKey {
    type Value = ReadLabels;

    const NAME: &str = "labels of masks";

    fn bytes(&self, value: &Self::Value) -> usize {
        value.value.0.byte_count()
    }
}

#[derive(Clone, PartialEq)]
struct LayersKey(ContentId, ValueLayers);

impl Key for LayersKey {
    type Value = LabelVolume;

    const NAME: &str = "layers of values";

    fn bytes(&self, value: &LabelVolume) -> usize {
        value.byte_count()
    }
}

#[derive(Clone, PartialEq)]
struct MaskKey {
    labels: ContentId,
    ids: Vec<u32>,
}

impl Key for MaskKey {
    type Value = Volume;

    const NAME: &str = "masks of labels";

    fn bytes(&self, value: &Volume) -> usize {
        value.samples().as_bytes().len()
    }
}

#[derive(Clone, PartialEq)]
struct MeshKey(States);

impl Key for MeshKey {
    type Value = Read<LoadedMesh>;

    const NAME: &str = "meshes";

    fn bytes(&self, value: &Read<LoadedMesh>) -> usize {
        let mesh = &value.value.mesh;
        size_of_val(mesh.positions()) + size_of_val(mesh.triangles())
    }
}

#[derive(Clone, PartialEq)]
struct PhantomLabelsKey(Phantom, [usize; 3]);

impl Key for PhantomLabelsKey {
    type Value = Option<LabelVolume>;

    const NAME: &str = "labels of phantoms";

    fn bytes(&self, value: &Self::Value) -> usize {
        value.as_ref().map_or(0, LabelVolume::byte_count)
    }
}

#[derive(Clone, PartialEq)]
struct PhantomKey(Phantom, [usize; 3]);

impl Key for PhantomKey {
    type Value = Volume;

    const NAME: &str = "phantoms";

    fn bytes(&self, value: &Volume) -> usize {
        value.samples().as_bytes().len()
    }
}

#[derive(Clone, PartialEq)]
struct LevelKey(ContentId, f64);

impl Key for LevelKey {
    type Value = Volume;

    const NAME: &str = "coarser levels";

    fn bytes(&self, value: &Volume) -> usize {
        value.samples().as_bytes().len()
    }
}
