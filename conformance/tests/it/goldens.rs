//! The scenes of `conformance/scenes`: each within the bounds of the truth, and as its golden picture.

use std::path::Path;
use strahl_conformance::golden::{self, Golden};
use strahl_conformance::scenes::{SCENES, prepare};
use strahl_conformance::{renderers, truth};
use strahl_scene::{Scene, resolve};
use strahl_volume::phantom::Phantom;

#[test]
fn every_scene_looks_like_its_golden_picture() {
    let remake = std::env::var_os("STRAHL_REMAKE_GOLDENS").is_some();
    let mut failures = Vec::new();
    for (name, text) in SCENES {
        let (volume, plan) = prepare(name, text).unwrap_or_else(|error| panic!("{name}: {error}"));
        for renderer in renderers() {
            let actual = Golden::of(&renderer.draw(&volume, &plan));
            let path = golden::path(name);
            if remake {
                actual.write(&path).unwrap();
                failures.push(format!("{} is new", path.display()));
                continue;
            }
            let expected =
                Golden::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            if let Some(difference) = actual.difference(&expected) {
                let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(renderer.name);
                for (what, picture) in [
                    ("expected", &expected),
                    ("actual", &actual),
                    ("difference", &difference),
                ] {
                    picture
                        .write(&folder.join(format!("{name}-{what}.png")))
                        .unwrap();
                }
                failures.push(format!("{name} differs: see {}", folder.display()));
            }
        }
    }
    // Remaking fails too: nobody shall take it for a test that has passed.
    let advice = if remake {
        "look at each picture, then run without STRAHL_REMAKE_GOLDENS"
    } else {
        "CONTRIBUTING.md says how to remake them"
    };
    assert!(failures.is_empty(), "{}\n{advice}", failures.join("\n"));
}

#[test]
fn every_scene_lies_within_the_bounds_of_the_truth() {
    for (name, text) in SCENES {
        let (volume, mut plan) = prepare(name, text).unwrap();
        // Brute force over every sample: fewer rays do.
        (plan.width, plan.height) = (plan.width / 4, plan.height / 4);
        let field = truth::Voxels::new(&volume, plan.field().reconstruct);
        for renderer in renderers() {
            let image = renderer.draw(&volume, &plan);
            let bounds = renderer.bounds(&plan, &field);
            for (i, (pixel, bounds)) in image.pixels().iter().zip(&bounds).enumerate() {
                let outside = bounds.distance(*pixel);
                let allowed = 2.0 * renderer.tolerance(&plan);
                assert!(
                    outside <= allowed,
                    "{}, {name}, pixel {i}: {outside}",
                    renderer.name
                );
            }
        }
    }
}

#[test]
fn a_picture_of_another_camera_is_noticed() {
    let (name, text) = SCENES[SCENES.len() - 1];
    let scene = Scene::parse(name, text).unwrap();
    let source = scene.volume.clone().unwrap();
    let phantom = Phantom::from_name(&source.phantom.unwrap()).unwrap();
    let volume = phantom.volume(source.dims.unwrap()).unwrap();
    let mut camera = scene.camera.unwrap();
    camera.azimuth_deg = camera.azimuth_deg.map(|angle| angle + 0.5);
    let turned = Scene {
        camera: Some(camera),
        ..scene
    };
    let plan = resolve(&turned, &volume.header(), None).unwrap();
    let expected = Golden::read(&golden::path(name)).unwrap();
    for renderer in renderers() {
        let actual = Golden::of(&renderer.draw(&volume, &plan));
        assert!(actual.difference(&expected).is_some(), "{}", renderer.name);
    }
}

#[test]
fn scenes_and_goldens_are_listed() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    for (sub, extension) in [("scenes", "json"), ("goldens", "png")] {
        let mut found: Vec<_> = std::fs::read_dir(folder.join(sub))
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        found.sort();
        let listed: Vec<_> = SCENES
            .iter()
            .map(|(name, _)| format!("{name}.{extension}"))
            .collect();
        assert_eq!(found, listed, "{sub}");
    }
}
