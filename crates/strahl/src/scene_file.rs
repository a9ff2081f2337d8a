//! Scenes on disk: JSON files, and pictures that contain their scene.

use crate::confinement::{Confinement, open_regular};
use crate::picture::{CarriedFiles, MadeFrom, SOFTWARE, is_cut_off};
use crate::{Error, Recipe, scene_graph};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::collections::BTreeSet;
use std::fs;
use std::io::Read;
use std::path::{Component, Path, PathBuf};
use strahl_scene::{Clip, GraphText, MOST_SCENE_BYTES, Scene};

/// A scene and where it comes from.
#[derive(Clone, Debug)]
pub struct SceneFile {
    /// The file.
    pub path: PathBuf,
    /// The scene, with paths relative to the current folder. The scene of a picture has no defaults if this version has
    /// made the picture, and all defaults otherwise, since those of another version may differ.
    pub scene: Scene,
    /// Files of the scene that a picture contains. They are used instead of those at the paths.
    pub carried: CarriedFiles,
    /// The program that made the picture, if the scene comes from one.
    pub software: Option<String>,
    /// Whether the scene comes from a PNG file that ends before its last pixel. The scene is whole.
    pub is_cut: bool,
    /// Where the scene may read, if not everywhere.
    pub confinement: Option<Confinement>,
}

/// How much of a file is looked at to tell a scene from a volume.
const HEAD_BYTES: u64 = 1 << 16;

impl SceneFile {
    /// The scene in the file at `path`: JSON with comments, or the scene in a PNG or EXR
    /// picture. `None` if the content is something else. A file whose name ends in `.json`
    /// always counts as a scene, so that its error message is useful.
    ///
    /// The scene of a picture is confined to what lies beside the picture, see [`Confinement`].
    ///
    /// # Errors
    /// If the file cannot be read, or is meant as a scene and is not one; it names a graph that it may not read.
    pub fn open(path: &Path) -> Result<Option<SceneFile>, Error> {
        SceneFile::open_within(path, None)
    }

    /// The same of a scene that may read as `confinement` says, whatever it comes from.
    ///
    /// # Errors
    /// As [`SceneFile::open`].
    pub fn open_within(
        path: &Path,
        confinement: Option<&Confinement>,
    ) -> Result<Option<SceneFile>, Error> {
        let fail = |error| Error::path(path, error);
        if fs::metadata(path).map_err(fail)?.is_dir() {
            return Ok(None);
        }
        let (mut made_from, mut is_cut) = (None, false);
        let (text, software) = if let Some(recipe) = recipe(path)? {
            made_from = recipe.made_from();
            is_cut = is_cut_off(path)?;
            (recipe.scene, Some(recipe.software))
        } else {
            let mut file = open_regular(path).map_err(fail)?;
            let mut bytes = Vec::new();
            (&mut file)
                .take(HEAD_BYTES)
                .read_to_end(&mut bytes)
                .map_err(fail)?;
            let named = path
                .extension()
                .is_some_and(|e| e.eq_ignore_ascii_case("json"));
            if !named && !begins_like_a_scene(&bytes) {
                return Ok(None);
            }
            // One more, so that the parser sees what is too long and has the words for it.
            file.take(MOST_SCENE_BYTES as u64 + 1)
                .read_to_end(&mut bytes)
                .map_err(fail)?;
            let text = String::from_utf8(bytes).map_err(|e| {
                let at = e.utf8_error().valid_up_to();
                Error::not_usable(path, format!("a scene is text in UTF-8; byte {at} is not"))
            })?;
            (text, None)
        };
        let name = path.display().to_string();
        let folder = path.parent().unwrap_or(Path::new(""));
        let confinement = match (confinement, &software) {
            (Some(confinement), _) => Some(confinement.clone()),
            (None, Some(_)) => Some(Confinement::to(folder)?),
            (None, None) => None,
        };
        let within = confinement.as_ref();
        let mut scene = if is_graph(&name, &text) {
            Scene {
                graph: Some(whole_graph(&name, &text, folder, within)?),
                ..Scene::default()
            }
        } else {
            let mut scene = Scene::parse(&name, &text)?;
            if let Some(graph) = &mut scene.graph {
                *graph = whole_graph(&name, graph.as_str(), folder, within)?;
            }
            scene
        };
        let join = |path: &mut String| {
            if let Some(joined) = folder.join(&*path).to_str() {
                *path = joined.to_owned();
            }
        };
        let mut carried = CarriedFiles::default();
        if let Some(made_from) = made_from {
            carried = made_from.files.with_paths(join);
            // Defaults of this version need not be set, so that quality and preset can change them.
            if software.as_deref() == Some(SOFTWARE) {
                let graph = scene.graph.take();
                scene = made_from.given;
                scene.graph = graph;
            }
        }
        paths_of(&mut scene).into_iter().for_each(join);
        Ok(Some(SceneFile {
            path: path.to_owned(),
            scene,
            carried,
            software,
            is_cut,
            confinement,
        }))
    }
}

/// Whether a file is that of a graph alone: by its name, or as its outermost object has the key that says its
/// version. (A text cut off has no keys that could be read; what is wrong with it is for the graph to say.)
fn is_graph(name: &str, text: &str) -> bool {
    if name.ends_with(".graph.json") {
        return true;
    }
    let mut plain = text.strip_prefix('\u{feff}').unwrap_or(text).to_owned();
    let is_plain = json_strip_comments::strip(&mut plain).is_ok();
    if strahl_scene::check_json_size(&plain).is_err() {
        return false;
    }
    let keys = serde_json::from_str::<serde_json::Map<String, serde_json::Value>>(&plain);
    is_plain && keys.is_ok_and(|keys| keys.contains_key("strahl_graph"))
}

/// A graph with every graph and WGSL file that it names inside it, and its other paths put as seen from the
/// current folder.
fn whole_graph(
    name: &str,
    text: &str,
    folder: &Path,
    confinement: Option<&Confinement>,
) -> Result<GraphText, Error> {
    scene_graph::with_paths(name, text, folder, confinement, |path| {
        if let Some(joined) = folder.join(&*path).to_str() {
            *path = joined.to_owned();
        }
    })
}

/// A damaged picture may still be a slice of a volume, whose reader has better words for it.
fn recipe(path: &Path) -> Result<Option<Recipe>, Error> {
    match Recipe::of_file(path) {
        Err(Error::NotUsable { .. }) => Ok(None),
        other => other,
    }
}

/// Whether the first thing in a text, after blanks and comments, is an object with a key, or an
/// empty one. No header of a volume begins so, and no samples do by chance.
fn begins_like_a_scene(head: &[u8]) -> bool {
    let head = match std::str::from_utf8(head) {
        Ok(text) => text,
        // The end may cut a character.
        Err(e) if e.error_len().is_none() => {
            std::str::from_utf8(&head[..e.valid_up_to()]).unwrap_or_default()
        }
        Err(_) => return false,
    };
    let head = head.strip_prefix('\u{feff}').unwrap_or(head);
    skip_comments(head)
        .strip_prefix('{')
        .is_some_and(|inside| skip_comments(inside).starts_with(['"', '}']))
}

fn skip_comments(mut text: &str) -> &str {
    loop {
        text = text.trim_start();
        let end = if text.starts_with("//") || text.starts_with('#') {
            text.find('\n')
        } else if text.starts_with("/*") {
            text.find("*/").map(|at| at + 2)
        } else {
            return text;
        };
        match end {
            Some(end) => text = &text[end..],
            None => return "",
        }
    }
}

/// `scene` with its paths put as seen from `folder`, with `/` between, for a file that will lie
/// there. A file on another branch of the file system keeps its whole path.
pub fn seen_from(folder: &Path, scene: &Scene) -> Scene {
    with_paths(scene, see_from(folder))
}

fn see_from(folder: &Path) -> impl Fn(&mut String) {
    let folder = whole(if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    });
    move |path| {
        if let Some(relative) = relative(&whole(Path::new(&*path)), &folder) {
            *path = relative;
        }
    }
}

/// The same for a picture in `folder`, which may go anywhere: a path that would be whole becomes the name of its file.
pub(crate) fn told_from(folder: &Path, scene: &Scene) -> Scene {
    with_paths(scene, tell_from(folder))
}

/// The files of which [`told_from`] tells only the name, and whose content is not `carried`.
pub(crate) fn names_told_from(folder: &Path, scene: &Scene, carried: &CarriedFiles) -> Vec<String> {
    let see = see_from(folder);
    let names = RefCell::new(BTreeSet::new());
    with_paths(scene, |path| {
        let mut seen = path.clone();
        see(&mut seen);
        if Path::new(&seen).is_absolute() && !carried.has(path) {
            names.borrow_mut().insert(last_name(path));
        }
    });
    names.into_inner().into_iter().collect()
}

/// What a scene was made from, for a picture in `folder`, as [`told_from`] does it.
pub(crate) fn made_from_told_from(folder: &Path, made_from: &MadeFrom) -> MadeFrom {
    MadeFrom {
        given: told_from(folder, &without_graph(&made_from.given)),
        files: made_from.files.with_paths(tell_from(folder)),
    }
}

/// The same without what may say whose data it shows: the files are left out.
pub(crate) fn anonymous_made_from(made_from: &MadeFrom) -> MadeFrom {
    MadeFrom {
        given: anonymous(&without_graph(&made_from.given)),
        ..MadeFrom::default()
    }
}

fn without_graph(scene: &Scene) -> Scene {
    Scene {
        graph: None,
        ..scene.clone()
    }
}

/// Puts a path as seen from `folder`; a path that would be whole becomes the name of its file.
fn tell_from(folder: &Path) -> impl Fn(&mut String) {
    let see = see_from(folder);
    move |path| {
        see(path);
        if Path::new(&*path).is_absolute() {
            *path = last_name(path);
        }
    }
}

/// `scene` without what may say whose data it shows: files and folders have numbers for names. Names that the scene gives
/// to segments, techniques and objects stay.
pub(crate) fn anonymous(scene: &Scene) -> Scene {
    let names = RefCell::new(BTreeMap::new());
    let mut scene = with_paths(scene, |path| {
        let mut names = names.borrow_mut();
        let number = names.len() + 1;
        let name = names
            .entry(path.clone())
            .or_insert_with(|| format!("data-{number}{}", known_ending(path)));
        *path = String::clone(name);
    });
    let objects = scene.objects.iter_mut().flatten();
    let of_objects = objects.filter_map(|object| object.volume.as_mut());
    for volume in scene.volume.as_mut().into_iter().chain(of_objects) {
        volume.series = None;
    }
    scene
}

/// The ending that says the format of a file, if it has one of those.
fn known_ending(path: &str) -> &'static str {
    const ENDINGS: [&str; 26] = [
        ".seg.nrrd",
        ".nii.gz",
        ".nii",
        ".hdr",
        ".img",
        ".nrrd",
        ".nhdr",
        ".mha",
        ".mhd",
        ".dcm",
        ".tif",
        ".tiff",
        ".png",
        ".bmp",
        ".jpg",
        ".mgz",
        ".mgh",
        ".vti",
        ".vtk",
        ".mrc",
        ".npy",
        ".npz",
        ".obj",
        ".stl",
        ".wgsl",
        ".json",
    ];
    let path = path.to_ascii_lowercase();
    let ending = ENDINGS.into_iter().find(|ending| path.ends_with(ending));
    ending.unwrap_or("")
}

fn last_name(path: &str) -> String {
    let name = Path::new(path).file_name();
    name.map_or(".".to_owned(), |name| name.to_string_lossy().into_owned())
}

/// `scene` with every path changed, also those of its graph.
fn with_paths(scene: &Scene, change: impl Fn(&mut String)) -> Scene {
    let mut scene = scene.clone();
    paths_of(&mut scene).into_iter().for_each(&change);
    if let Some(graph) = &mut scene.graph
        && let Ok(text) =
            scene_graph::with_paths("graph", graph.as_str(), Path::new(""), None, &change)
    {
        *graph = text;
    }
    scene
}

/// Checks that everything that `scene` names, and that is not `carried`, lies where `confinement` says.
pub(crate) fn check_paths(
    scene: &Scene,
    carried: &CarriedFiles,
    confinement: &Confinement,
) -> Result<(), Error> {
    let mut scene = scene.clone();
    let check_path = |path: &str| match carried.has(path) {
        true => Ok(()),
        false => confinement.check(Path::new(path)),
    };
    for path in paths_of(&mut scene) {
        check_path(path)?;
    }
    let Some(graph) = &scene.graph else {
        return Ok(());
    };
    let mut checked = Ok(());
    let check = |path: &mut String| {
        if checked.is_ok() {
            checked = check_path(path);
        }
    };
    scene_graph::with_paths(
        "graph",
        graph.as_str(),
        Path::new(""),
        Some(confinement),
        check,
    )?;
    checked
}

/// Every path in a scene: volumes, labels, meshes, masks, shader functions.
fn paths_of(scene: &mut Scene) -> Vec<&mut String> {
    let mut paths = Vec::new();
    paths.extend(
        scene
            .volume
            .as_mut()
            .and_then(|volume| volume.path.as_mut()),
    );
    for object in scene.objects.iter_mut().flatten() {
        paths.extend(
            object
                .volume
                .as_mut()
                .and_then(|volume| volume.path.as_mut()),
        );
        paths.extend(object.mesh.as_mut());
    }
    if let Some(labels) = &mut scene.labels {
        paths.extend(&mut labels.path);
        paths.extend(labels.masks.iter_mut().flatten().map(|mask| &mut mask.path));
        paths.extend(&mut labels.table);
    }
    paths.extend(
        scene
            .importance
            .as_mut()
            .map(|importance| &mut importance.path),
    );
    paths.extend(scene.clips.iter_mut().flatten().filter_map(Clip::mask_path));
    let functions = scene.functions.iter_mut().flat_map(|map| map.values_mut());
    paths.extend(functions.filter(|f| f.is_file()).map(|f| &mut f.module));
    paths
}

fn whole(path: &Path) -> PathBuf {
    fs::canonicalize(path)
        .or_else(|_| std::path::absolute(path))
        .unwrap_or_else(|_| path.to_owned())
}

/// `path` as seen from `folder`; both are whole.
fn relative(path: &Path, folder: &Path) -> Option<String> {
    let shared = path
        .components()
        .zip(folder.components())
        .take_while(|(a, b)| a == b)
        .count();
    let is_name = |c: &Component| matches!(c, Component::Normal(_));
    if !path.components().take(shared).any(|c| is_name(&c)) {
        return path.to_str().map(str::to_owned);
    }
    let up = folder.components().skip(shared).map(|_| Some(".."));
    let down = path.components().skip(shared);
    let parts: Option<Vec<&str>> = up.chain(down.map(|c| c.as_os_str().to_str())).collect();
    let parts = parts?;
    Some(if parts.is_empty() {
        ".".to_owned()
    } else {
        parts.join("/")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_are_told_by_their_first_characters() {
        for text in [
            "{}",
            "{\"volume\": {}}",
            " \n// a head\n/* in { two }\nlines */ # and more\n{ // here\n \"preset\": \"mr\"",
            "\u{feff}{ }",
        ] {
            assert!(begins_like_a_scene(text.as_bytes()), "{text}");
        }
        for text in [
            "",
            "[1]",
            "{{{{",
            "NRRD0004\n{",
            "// only a comment",
            "\"\"",
        ] {
            assert!(!begins_like_a_scene(text.as_bytes()), "{text}");
        }
        assert!(!begins_like_a_scene(b"{\xff\xfe\"\""));
        assert!(begins_like_a_scene(
            "{\"title é".as_bytes().split_last().unwrap().1
        ));
    }

    #[test]
    fn paths_are_put_as_seen_from_a_folder() {
        for (path, folder, expected) in [
            ("/data/a.nii", "/data", "a.nii"),
            ("/data/in/a.nii", "/data", "in/a.nii"),
            ("/data/a.nii", "/data/out/today", "../../a.nii"),
            ("/data/in", "/data/in", "."),
            ("/data/a.nii", "/elsewhere", "/data/a.nii"),
        ] {
            let found = relative(Path::new(path), Path::new(folder));
            assert_eq!(found.as_deref(), Some(expected));
        }
    }
}
