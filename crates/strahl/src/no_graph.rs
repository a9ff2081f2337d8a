//! In place of graphs, in a build without them.

use crate::Error;
use crate::confinement::Confinement;
use crate::picture::CarriedFiles;
use std::path::{Path, PathBuf};
use strahl_scene::GraphText;

/// What a scene asks of the graph that draws it: nothing.
pub enum SceneGraph {}

impl SceneGraph {
    /// That of no scene.
    pub fn with_carried(
        _name: &str,
        _text: Option<&GraphText>,
        _carried: &CarriedFiles,
    ) -> Result<SceneGraph, Error> {
        Err(no_graphs(None))
    }

    /// Its files.
    pub fn carried(&self) -> &CarriedFiles {
        match *self {}
    }
}

/// The text of a graph with other paths.
pub fn with_paths(
    name: &str,
    _text: &str,
    _folder: &Path,
    _confinement: Option<&Confinement>,
    _change: impl FnMut(&mut String),
) -> Result<GraphText, Error> {
    Err(no_graphs(Some(name.into())))
}

fn no_graphs(file: Option<PathBuf>) -> Error {
    Error::NoGraphs {
        file,
        what: "a graph",
    }
}
