//! Why a picture shows nothing.

use crate::engine;
use strahl_scene::{Headers, Scene, resolve_with, why_nothing_is_seen};
use strahl_volume::{Metadata, Rescale, Samples, Volume};

fn why(text: &str, headers: &Headers) -> String {
    let scene = Scene::parse("scene", text).unwrap();
    let plan = resolve_with(&scene, headers).unwrap_or_else(|problems| panic!("{problems}"));
    why_nothing_is_seen(&plan, headers).join("; ")
}

#[test]
fn every_reason_is_named() {
    let headers = Headers::from(engine());
    for (text, expected) in [
        (
            r#"{ "method": "first-hit", "threshold": 300 }"#,
            "the threshold 300 lies above all values, 0 to 255",
        ),
        (
            r##"{ "transfer_function": { "points": [[300, 0, "#fff"], [400, 1, "#fff"]] } }"##,
            "the transfer function is transparent for all values, 0 to 255",
        ),
        (
            r#"{ "camera": { "position": [0, 900, 0], "focus": [0, 1800, 0] } }"#,
            "no ray meets a volume",
        ),
        (
            r#"{ "clips": [{ "plane": { "normal": [0, 1, 0], "distance_mm": 1000 } }] }"#,
            "the clips leave nothing",
        ),
        (
            r#"{ "camera": { "view": "front" }, "clips": [{ "plane": { "normal": [0, 1, 0], "distance_mm": 0 } }, { "plane": { "normal": [0, -1, 0], "distance_mm": -0.1 } }] }"#,
            "at most 0.1",
        ),
        (
            r#"{ "clips": [{ "box": { "min": [0, 0, 0], "max": [1, 1, 1], "space": "fraction", "keep": "outside" } }] }"#,
            "the clips may leave only what is transparent",
        ),
        ("{}", ""),
    ] {
        let found = why(text, &headers);
        assert!(
            found.contains(expected) && found.is_empty() == expected.is_empty(),
            "{text}: {found}"
        );
    }
}

#[test]
fn volumes_without_anything_to_see_are_named() {
    for (number, expected) in [
        (f32::NAN, "no voxel has a value"),
        (7.0, "all voxels have the value 7"),
    ] {
        let volume = Volume::new(
            engine().grid,
            Samples::F32(vec![number; 256 * 256 * 128]),
            Rescale::IDENTITY,
            Metadata::default(),
        );
        let headers = Headers::from(volume.unwrap().header());
        assert!(why("{}", &headers).contains(expected));
    }
}
