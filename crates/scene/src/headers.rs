//! What is known of the files that a scene names, before a Plan is made.

use glam::DVec3;
use std::collections::BTreeMap;
use std::sync::Arc;
use strahl_shader::Module;
use strahl_volume::{Grid, Label, LabelVolume, VolumeHeader};

/// Headers of the data that a scene names, each list in the order in which the scene names it.
#[derive(Clone, Debug)]
pub struct Headers {
    /// Of the scene's own volume, then of each object that has a volume of its own, at level 0 whatever level of detail
    /// is drawn, so that nothing but detail depends on the level.
    pub volumes: Vec<VolumeHeader>,
    /// By the number of a volume the header of the level of detail that is drawn, where that is not level 0.
    pub coarser: BTreeMap<usize, VolumeHeader>,
    /// Of the labels, if the scene names them.
    pub labels: Option<LabelHeader>,
    /// The grid of each mask of a clip, then that of the importance volume.
    pub masks: Vec<Grid>,
    /// Opposite corners of the box around each mesh, in its own mm.
    pub meshes: Vec<[DVec3; 2]>,
    /// The shader functions in files, by the text that names them.
    pub modules: BTreeMap<String, Arc<Module>>,
}

impl Headers {
    /// The header of what is drawn of volume number `volume`.
    ///
    /// # Panics
    /// If there is no such volume.
    pub(crate) fn drawn(&self, volume: usize) -> &VolumeHeader {
        self.coarser.get(&volume).unwrap_or(&self.volumes[volume])
    }
}

/// What is known of a label volume.
#[derive(Clone, Debug)]
pub struct LabelHeader {
    /// Its grid.
    pub grid: Grid,
    /// The segments that have names.
    pub labels: Vec<Label>,
    /// The ids that voxels have or names belong to, ascending.
    pub ids: Vec<u32>,
    /// Those of them that no voxel has.
    pub unused_ids: Vec<u32>,
}

impl LabelHeader {
    /// The ids with what is known of them.
    pub(crate) fn segments(&self) -> impl Iterator<Item = (u32, Option<&Label>)> {
        let labels: BTreeMap<u32, &Label> =
            self.labels.iter().map(|label| (label.id, label)).collect();
        self.ids
            .iter()
            .map(move |id| (*id, labels.get(id).copied()))
    }
}

impl From<&LabelVolume> for LabelHeader {
    fn from(labels: &LabelVolume) -> LabelHeader {
        LabelHeader {
            grid: *labels.grid(),
            labels: labels.labels().to_vec(),
            ids: labels.known_ids().to_vec(),
            unused_ids: labels.unused_ids().to_vec(),
        }
    }
}

impl From<VolumeHeader> for Headers {
    /// One volume and nothing else.
    fn from(header: VolumeHeader) -> Headers {
        Headers {
            volumes: vec![header],
            coarser: BTreeMap::new(),
            labels: None,
            masks: Vec::new(),
            meshes: Vec::new(),
            modules: BTreeMap::new(),
        }
    }
}
