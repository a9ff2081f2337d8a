//! A scalar grid: samples, their place in the world, and what a stored number means.

use crate::{Cancelled, ContentId, Control, Error, Grid, Rescale, SampleType, Samples, Statistics};
use crate::{cores, with_samples};
use std::sync::{Arc, OnceLock};

/// What kind of device made the data; decides which preset is taken when nothing is said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Modality {
    /// Computed tomography in Hounsfield units.
    Ct,
    /// Magnetic resonance, arbitrary units.
    Mr,
    /// Positron emission or single-photon tomography.
    Nuclear,
    /// Ultrasound.
    Ultrasound,
    /// Optical or electron microscopy.
    Microscopy,
    /// Computed, not measured.
    Simulation,
}

/// The numbers that a file has for each voxel. A [`Volume`] has one of them, or their luminance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Components {
    /// How many there are.
    pub count: usize,
    /// Whether they are red, green, blue and perhaps opacity, or gray and opacity.
    pub are_colors: bool,
}

impl Default for Components {
    fn default() -> Components {
        Components {
            count: 1,
            are_colors: false,
        }
    }
}

/// What is worth keeping of a file's header beside grid and rescale.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metadata {
    /// What the data is called: file name, series description, phantom name.
    pub name: String,
    /// The kind of file, such as `NIfTI-1` or `DICOM`.
    pub format: String,
    /// The device, if the file says.
    pub modality: Option<Modality>,
    /// Unit of the values, such as `HU`, if the file says.
    pub value_unit: Option<String>,
    /// Whether the file says what its lengths mean. Without, a spacing of 1 counts as 1 mm.
    pub has_length_unit: bool,
    /// How many time points the file holds (1 for a single volume) …
    pub time_points: usize,
    /// … and which one this is, from 0.
    pub time_index: usize,
    /// The numbers that the file has for each voxel.
    pub components: Components,
    /// Other header entries worth showing, such as patient position, series, study date.
    pub entries: Vec<(String, String)>,
}

/// A scalar grid. Immutable once made; clones share its content and its [`id`](Volume::id).
///
/// ```
/// use strahl_volume::{Grid, Metadata, Rescale, Samples, Volume};
/// let grid = Grid::centered([2, 1, 1], glam::DVec3::ONE)?;
/// let volume = Volume::new(grid, Samples::I16(vec![-1000, 40]), Rescale::IDENTITY, Metadata::default())?;
/// assert_eq!(volume.value(1, 0, 0), 40.0);
/// # Ok::<(), strahl_volume::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Volume(Arc<Content>);

#[derive(Debug)]
struct Content {
    id: ContentId,
    grid: Grid,
    samples: Samples,
    rescale: Rescale,
    metadata: Metadata,
    /// Counted when somebody asks.
    statistics: OnceLock<Statistics>,
}

impl Volume {
    /// A volume of `samples` (x fastest) on `grid`.
    ///
    /// # Errors
    /// If the number of samples is not the number of voxels.
    pub fn new(
        grid: Grid,
        samples: Samples,
        rescale: Rescale,
        metadata: Metadata,
    ) -> Result<Volume, Error> {
        if samples.len() != grid.voxel_count() {
            return Err(Error::field(
                "number of samples",
                samples.len(),
                format!("{} for a grid of {:?}", grid.voxel_count(), grid.dims()),
            ));
        }
        Ok(Volume(Arc::new(Content {
            id: ContentId::unique(),
            grid,
            samples,
            rescale,
            metadata,
            statistics: OnceLock::new(),
        })))
    }

    /// The same voxels under metadata without what may say whose they are: name, descriptions, dates. Copies them if
    /// the volume has clones.
    #[must_use]
    pub fn anonymous(self) -> Volume {
        let (grid, samples, rescale, metadata) = self.into_parts();
        Volume(Arc::new(Content {
            id: ContentId::unique(),
            grid,
            samples,
            rescale,
            metadata: Metadata {
                name: String::new(),
                entries: Vec::new(),
                ..metadata
            },
            statistics: OnceLock::new(),
        }))
    }

    /// What clones of this volume have in common, and no other volume has.
    pub fn id(&self) -> ContentId {
        self.0.id
    }

    /// Where the samples lie.
    pub fn grid(&self) -> &Grid {
        &self.0.grid
    }

    /// The stored samples, x fastest.
    pub fn samples(&self) -> &Samples {
        &self.0.samples
    }

    /// The type of a stored sample.
    pub fn sample_type(&self) -> SampleType {
        self.0.samples.sample_type()
    }

    /// What a stored number means.
    pub fn rescale(&self) -> Rescale {
        self.0.rescale
    }

    /// What else the file said.
    pub fn metadata(&self) -> &Metadata {
        &self.0.metadata
    }

    /// Range and histogram of the values, counted when they are first asked for.
    pub fn statistics(&self) -> &Statistics {
        let content = &self.0;
        let count = || Statistics::of(&content.samples, content.rescale);
        content.statistics.get_or_init(count)
    }

    /// The same under `control`. What readers give has been counted.
    ///
    /// # Errors
    /// It was cancelled before all samples were counted.
    pub fn statistics_under(&self, control: &Control) -> Result<&Statistics, Cancelled> {
        let content = &self.0;
        if let Some(known) = content.statistics.get() {
            return Ok(known);
        }
        let counted = Statistics::under(&content.samples, content.rescale, control)?;
        Ok(content.statistics.get_or_init(|| counted))
    }

    /// The value at a voxel.
    ///
    /// # Panics
    /// If the voxel is outside the grid.
    pub fn value(&self, x: usize, y: usize, z: usize) -> f64 {
        let [nx, ny, nz] = self.0.grid.dims();
        assert!(
            x < nx && y < ny && z < nz,
            "voxel ({x}, {y}, {z}) outside {:?}",
            self.0.grid.dims()
        );
        self.0
            .rescale
            .value(self.0.samples.get(self.0.grid.index(x, y, z)))
    }

    /// What a scene needs to know without the voxels.
    pub fn header(&self) -> VolumeHeader {
        VolumeHeader {
            grid: self.0.grid,
            sample_type: self.sample_type(),
            rescale: self.0.rescale,
            statistics: self.statistics().clone(),
            metadata: self.0.metadata.clone(),
        }
    }

    /// The parts, for those who build another volume of them. Copies them if the volume has clones.
    pub fn into_parts(self) -> (Grid, Samples, Rescale, Metadata) {
        match Arc::try_unwrap(self.0) {
            Ok(mut own) => (
                own.grid,
                std::mem::replace(&mut own.samples, Samples::U8(Vec::new())),
                own.rescale,
                std::mem::take(&mut own.metadata),
            ),
            Err(shared) => (
                shared.grid,
                shared.samples.clone(),
                shared.rescale,
                shared.metadata.clone(),
            ),
        }
    }
}

/// Samples of at least as many bytes are given up by a thread of their own.
const LARGE_BYTES: usize = 64 << 20;

impl Drop for Content {
    /// Whoever drops a volume does not wait until the system has taken back its memory, which takes a
    /// tenth of a second for a GiB: a reader that is cancelled ends at once.
    fn drop(&mut self) {
        if self.samples.as_bytes().len() >= LARGE_BYTES {
            let samples = std::mem::replace(&mut self.samples, Samples::U8(Vec::new()));
            with_samples!(samples, s => cores::free(s));
        }
    }
}

impl From<&Volume> for Volume {
    /// A clone.
    fn from(volume: &Volume) -> Volume {
        volume.clone()
    }
}

/// A volume without its voxels: what `scene::resolve` sees.
#[derive(Clone, Debug)]
pub struct VolumeHeader {
    /// Where the samples lie.
    pub grid: Grid,
    /// The type of a stored sample.
    pub sample_type: SampleType,
    /// What a stored number means.
    pub rescale: Rescale,
    /// Range and histogram of the values.
    pub statistics: Statistics,
    /// What else the file said.
    pub metadata: Metadata,
}
