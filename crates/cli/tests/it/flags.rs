//! What flags do to a scene: `scene show` prints what `render` would draw.

use super::*;
use serde_json::{Value, json};
use std::fs;

fn shown(folder: &Path, args: &[&str]) -> Value {
    let args = [&["scene", "show"], args].concat();
    serde_json::from_str(&run_well(folder, &args)).unwrap()
}

/// A scene in which everything is said: that of a volume, settled.
fn folder_with_scene() -> tempfile::TempDir {
    let folder = folder_with_shells();
    run_well(
        folder.path(),
        &["scene", "show", "shells.nrrd", "-o", "all.json"],
    );
    folder
}

#[test]
fn every_flag_reaches_its_key() {
    let folder = folder_with_shells();
    let scene = shown(
        folder.path(),
        &[
            "shells.nrrd",
            "--preset",
            "grey",
            "--window",
            "0.5",
            "--level",
            "0.25",
            "--color-map",
            "viridis",
            "--opacity",
            "0.1,0.7",
            "--shade",
            "unlit",
            "--clip-plane",
            "0,0,1,-20",
            "--clip-box",
            "0.5,0,0,0,1,1",
            "--clip-space",
            "fraction",
            "--background",
            "#102030",
            "--exposure",
            "1.5",
            "--tone-map",
            "reinhard-extended",
            "--white-point",
            "3",
            "--gamma",
            "1.8",
            "--fxaa",
            "--view",
            "left",
            "--azimuth",
            "-30",
            "--elevation",
            "20",
            "--zoom",
            "1.25",
            "--projection",
            "orthographic",
            "--focus",
            "-1,2,3",
            "--size",
            "320x200",
            "--step",
            "0.5",
            "--jitter",
            "7",
            "--reconstruct",
            "nearest",
        ],
    );
    assert_eq!(scene["volume"]["path"], "shells.nrrd");
    assert_eq!(scene["preset"], "grey");
    let function = &scene["transfer_function"];
    assert_eq!(
        (&function["window"], &function["level"]),
        (&json!(0.5), &json!(0.25))
    );
    assert_eq!(function["color_map"], "viridis");
    assert_eq!(function["opacity"], json!([0.1, 0.7]));
    assert_eq!(scene["shading"], json!({"model": "unlit"}));
    assert_eq!(scene["clips"][0]["plane"]["distance_mm"], -20.0);
    assert_eq!(scene["clips"][1]["box"]["max"], json!([0.5, 1.0, 1.0]));
    assert_eq!(scene["clips"][1]["box"]["space"], "fraction");
    assert_eq!(scene["background"], "#102030");
    assert_eq!(
        scene["display"],
        json!({
            "exposure": 1.5, "tone_map": "reinhard-extended", "white_point": 3.0, "gamma": 1.8,
            "fxaa": true,
            "invert": false
        })
    );
    let camera = &scene["camera"];
    assert_eq!(
        (&camera["view"], &camera["zoom"]),
        (&json!("left"), &json!(1.25))
    );
    assert_eq!(
        (&camera["azimuth_deg"], &camera["elevation_deg"]),
        (&json!(-30.0), &json!(20.0))
    );
    assert_eq!(camera["projection"], "orthographic");
    assert_eq!(camera["focus"], json!([-1.0, 2.0, 3.0]));
    assert_eq!(scene["size"], json!([320, 200]));
    assert_eq!(scene["step_mm"], 0.5);
    assert_eq!(scene.get("step_voxels"), None);
    assert_eq!(scene["jitter"], json!({"seed": 7}));
    assert_eq!(scene["reconstruct"], "nearest");

    let scene = shown(
        folder.path(),
        &[
            "shells.nrrd",
            "--method",
            "first-hit",
            "--threshold",
            "0.3",
            "--transparent",
            "--step-voxels",
            "0.25",
            "--position",
            "-300,10,5",
        ],
    );
    assert_eq!(
        (&scene["method"], &scene["threshold"]),
        (&json!("first-hit"), &json!(0.3))
    );
    assert_eq!(scene["background"], "transparent");
    assert_eq!(scene["step_voxels"], 0.25);
    assert_eq!(scene["camera"]["position"], json!([-300.0, 10.0, 5.0]));
}

#[test]
fn flags_win_over_a_scene_that_says_everything() {
    let folder = folder_with_scene();
    let all = shown(folder.path(), &["all.json"]);
    let plain = shown(folder.path(), &["shells.nrrd"]);
    assert_eq!(all, plain);

    // A preset brings its whole look …
    let scene = shown(folder.path(), &["all.json", "--preset", "mip"]);
    assert_eq!(scene["transfer_function"]["color_map"], "grey");
    assert_eq!(
        (&scene["method"], &scene["shading"]["model"]),
        (&json!("mip"), &json!("unlit"))
    );
    // … and leaves the camera.
    assert_eq!(scene["camera"], all["camera"]);
    // A projection drops the light.
    let scene = shown(folder.path(), &["all.json", "--method", "average"]);
    assert_eq!(scene["shading"]["model"], "unlit");
    // A window moves the preset's points, as it does without a scene.
    let window = ["--window", "0.5", "--level", "0.4"];
    let scene = shown(folder.path(), &[&["all.json"], &window[..]].concat());
    let plain = shown(folder.path(), &[&["shells.nrrd"], &window[..]].concat());
    assert_eq!(scene["transfer_function"], plain["transfer_function"]);
    assert_ne!(scene["transfer_function"], all["transfer_function"]);
    // A view is a new camera, fitted again; angles alone turn the old one.
    let scene = shown(folder.path(), &["all.json", "--view", "back"]);
    assert_eq!(
        scene["camera"],
        shown(folder.path(), &["shells.nrrd", "--view", "back"])["camera"]
    );
    let scene = shown(folder.path(), &["all.json", "--azimuth", "70"]);
    assert_eq!(
        scene["camera"]["elevation_deg"],
        all["camera"]["elevation_deg"]
    );
    // Either step replaces the other.
    let scene = shown(folder.path(), &["all.json", "--step", "2"]);
    assert_eq!(
        (&scene["step_mm"], scene.get("step_voxels")),
        (&json!(2.0), None)
    );
    // Orthographic measures in mm, not degrees.
    let scene = shown(folder.path(), &["all.json", "--projection", "orthographic"]);
    assert_eq!(scene["camera"].get("view_angle_deg"), None);
}

#[test]
fn a_scene_can_be_drawn_with_another_volume() {
    let folder = folder_with_scene();
    save(
        &Phantom::Tree.volume([8, 8, 8]).unwrap(),
        folder.path(),
        "tree.mha",
    );
    let scene = shown(folder.path(), &["all.json", "tree.mha"]);
    assert_eq!(scene["volume"], json!({"path": "tree.mha"}));
}

#[test]
fn reading_flags_are_part_of_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.bin"), (0..24).collect::<Vec<u8>>()).unwrap();
    let scene = shown(
        folder.path(),
        &[
            "a.bin",
            "--dims",
            "2x2x3",
            "--type",
            "u16",
            "--endian",
            "big",
            "--spacing",
            "2",
        ],
    );
    let expected = json!({
        "path": "a.bin", "dims": [2, 2, 3], "type": "u16", "spacing_mm": [2.0, 2.0, 2.0],
        "endian": "big",
    });
    assert_eq!(scene["volume"], expected);
}

#[test]
fn paths_count_from_the_folder_of_the_scene() {
    let folder = folder_with_shells();
    let out = folder.path().join("scenes/deep");
    fs::create_dir_all(&out).unwrap();
    run_well(
        folder.path(),
        &["scene", "show", "shells.nrrd", "-o", "scenes/deep/a.json"],
    );
    let text = fs::read_to_string(out.join("a.json")).unwrap();
    assert!(text.contains("\"../../shells.nrrd\""), "{text}");
    // From wherever it is named.
    let here = shown(folder.path(), &["scenes/deep/a.json"]);
    assert_eq!(here["volume"]["path"], "shells.nrrd");
    assert_eq!(
        shown(&out, &["a.json"])["volume"]["path"],
        "../../shells.nrrd"
    );
}

/// What a scene says of the display gives way: a white point belongs to its tone map.
#[test]
fn display_flags_go_before_a_scene() {
    let folder = folder_with_shells();
    let scene = r#"{
        "volume": { "path": "shells.nrrd" },
        "display": { "tone_map": "hable", "white_point": 6, "fxaa": true }
    }"#;
    std::fs::write(folder.path().join("scene.json"), scene).unwrap();
    let display =
        |flags: &[&str]| shown(folder.path(), &[&["scene.json"], flags].concat())["display"].take();
    let found = display(&["--tone-map", "reinhard-extended", "--fxaa=off"]);
    assert_eq!(
        found,
        json!({"exposure": 1.0, "tone_map": "reinhard-extended", "white_point": 4.0, "fxaa": false, "invert": false})
    );
    let found = display(&["--tone-map", "hable"]);
    assert_eq!(
        found,
        json!({"exposure": 1.0, "tone_map": "hable", "white_point": 6.0, "fxaa": true, "invert": false})
    );
    let found = display(&["--tone-map", "aces"]);
    assert_eq!(
        found,
        json!({"exposure": 1.0, "tone_map": "aces", "fxaa": true, "invert": false})
    );
}
