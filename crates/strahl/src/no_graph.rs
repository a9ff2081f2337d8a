//! In place of graphs, in a build without them.

use crate::Error;
use crate::confinement::Confinement;
use std::path::{Path, PathBuf};
use strahl_scene::GraphText;

/// What a scene asks of the graph that draws it: nothing.
pub enum SceneGraph {}

impl SceneGraph {
    /// That of no scene.
    pub fn new(_name: &str, _text: Option<&GraphText>) -> Result<SceneGraph, Error> {
        Err(no_graphs(None))
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
