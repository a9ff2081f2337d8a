//! What is known of the files that a scene names, before a Plan is made.

use glam::DVec3;
use std::collections::BTreeMap;
use std::sync::Arc;
use strahl_shader::Module;
use strahl_volume::{Grid, VolumeHeader};

/// Headers of the data that a scene names, each list in the order in which the scene names it.
#[derive(Clone, Debug)]
pub struct Headers {
    /// Of the scene's own volume, then of each object that has a volume of its own.
    pub volumes: Vec<VolumeHeader>,
    /// The grid of the labels, if the scene names them.
    pub labels: Option<Grid>,
    /// The grid of each mask.
    pub masks: Vec<Grid>,
    /// Opposite corners of the box around each mesh, in its own mm.
    pub meshes: Vec<[DVec3; 2]>,
    /// The shader functions in files, by the text that names them.
    pub modules: BTreeMap<String, Arc<Module>>,
}

impl From<VolumeHeader> for Headers {
    /// One volume and nothing else.
    fn from(header: VolumeHeader) -> Headers {
        Headers {
            volumes: vec![header],
            labels: None,
            masks: Vec::new(),
            meshes: Vec::new(),
            modules: BTreeMap::new(),
        }
    }
}
