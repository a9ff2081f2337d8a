//! Scenes that every renderer draws: `conformance/scenes/*.json`, each with a golden picture.
//!
//! Phantoms only, so that they run anywhere; everything that a preset or default may change one day
//! is stated in them.

use std::error::Error;
use strahl_scene::plan::Plan;
use strahl_scene::{Scene, resolve};
use strahl_volume::Volume;
use strahl_volume::phantom::Phantom;

macro_rules! scenes {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../scenes/", $name, ".json")))),*]
    };
}

/// Name and text of every scene.
pub const SCENES: &[(&str, &str)] = scenes![
    "fog-average",
    "hydrogen-glow",
    "marschner-lobb-first-hit",
    "shells-cut",
    "shells-minip",
    "tree-mip",
    "tree-shaded",
];

/// The volume and the Plan of a scene of a phantom.
///
/// # Errors
/// If the text is no scene, names no phantom, or does not resolve.
pub fn prepare(name: &str, text: &str) -> Result<(Volume, Plan), Box<dyn Error>> {
    let scene = Scene::parse(name, text)?;
    let source = scene.volume.as_ref().ok_or("no volume")?;
    let phantom = source.phantom.as_deref().and_then(Phantom::from_name);
    let phantom = phantom.ok_or("no phantom")?;
    let volume = phantom.volume(source.dims.unwrap_or(phantom.default_dims()))?;
    let plan = resolve(&scene, &volume.header(), None)?;
    Ok((volume, plan))
}
