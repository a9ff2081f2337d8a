//! The data of one picture.

use crate::{LabelVolume, Mesh, Rescale, Volume};

/// The data that one picture is drawn from, in the order in which a Plan counts it. Volumes and meshes share their
/// content with those that they were cloned from.
///
/// ```
/// use strahl_volume::{Datasets, Phantom};
/// let volume = Phantom::Tree.volume([8, 8, 8])?;
/// let data = Datasets::from(&volume);
/// assert_eq!(data.volumes[0].id(), volume.id());
/// # Ok::<(), strahl_volume::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Datasets {
    /// The volumes that objects show.
    pub volumes: Vec<Volume>,
    /// The volumes that clips take as masks.
    pub masks: Vec<Volume>,
    /// The label volumes whose segments are drawn by techniques of their own.
    pub labels: Vec<LabelVolume>,
    /// The opaque surfaces.
    pub meshes: Vec<Mesh>,
}

impl Datasets {
    /// Whether every value is finite because the voxels are whole numbers and far from the largest float.
    pub fn are_finite(&self) -> bool {
        let is_finite = |volume: &Volume| {
            let Rescale { slope, intercept } = volume.rescale();
            volume.sample_type().is_integer() && slope.abs().max(intercept.abs()) < 1e20
        };
        self.volumes.iter().all(is_finite)
    }
}

impl From<Volume> for Datasets {
    /// One volume and nothing else.
    fn from(volume: Volume) -> Datasets {
        Datasets {
            volumes: vec![volume],
            ..Datasets::default()
        }
    }
}

impl From<&Volume> for Datasets {
    /// One volume and nothing else.
    fn from(volume: &Volume) -> Datasets {
        volume.clone().into()
    }
}

impl From<&Datasets> for Datasets {
    fn from(data: &Datasets) -> Datasets {
        data.clone()
    }
}
