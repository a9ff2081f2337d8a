//! Pictures that are drawn again.

use super::*;
use std::fs;
use strahl::scene::Quality;
use strahl::{Encoding, Output, Picture, Recipe, Render, Scene, SceneFile, Told};

fn scene_in(folder: &Path, text: &str) -> SceneFile {
    let path = folder.join("scene.json");
    fs::write(&path, text).unwrap();
    SceneFile::open(&path).unwrap().unwrap()
}

fn again(path: &Path) -> Picture {
    let file = SceneFile::open(path).unwrap().unwrap();
    Render::scene_file(file).picture().unwrap()
}

/// A picture can be drawn again although its shader functions, patterns and textures are gone, and lay outside of the folder
/// to which its scene is confined.
#[test]
fn a_picture_carries_its_functions_patterns_and_textures() {
    let twice = "fn classify(value: f32, position: vec3f) -> Surface { return Surface(vec3f(value, 0.4, 0.1), 0.2); }";
    let posterise = "/// Posterise.\n/// color: color.linear\n/// levels: default 4\n/// result: color.linear\nfn posterise(color: vec3f, levels: f32) -> vec3f { return floor(color * levels + 0.5) / levels; }";
    let texture = Render::volume(&shells()).size(4, 4).picture().unwrap();
    for text in [
        r#"{ "volume": { "path": "shells.nrrd" }, "size": [20, 16], "functions": { "classify": { "module": "made/twice.wgsl" } } }"#,
        r#"{ "volume": { "path": "shells.nrrd" }, "size": [20, 16], "graph": { "strahl_graph": 1, "patterns": ["made/pats"],
            "edits": [{ "name": "poster", "commands": [
                { "add": { "poster": { "pattern": "posterise", "inputs": { "levels": 3 } } } },
                { "insert": { "node": "poster", "into": "after_shade_color" } } ] }] } }"#,
        r#"{ "volume": { "path": "shells.nrrd" }, "size": [20, 16], "graph": { "strahl_graph": 1,
            "edits": [{ "name": "map", "commands": [
                { "add": {
                    "map": { "texture": { "file": "made/map.png" } },
                    "at": { "wgsl": "fn at(color: vec3f) -> vec2f { return color.rg; }" },
                    "look": { "pattern": "sample_2d", "inputs": { "image": "map", "place": "at" } },
                    "rgb": { "wgsl": "fn rgb(c: vec4f) -> vec3f { return c.rgb; }", "inputs": { "c": "look" } } } },
                { "insert": { "node": "at", "into": "after_shade_color" } },
                { "connect": { "after_shade_color": "rgb" } } ] }] } }"#,
    ] {
        let folder = folder_with_shells();
        let elsewhere = tempfile::tempdir().unwrap();
        let made = elsewhere.path().join("made");
        fs::create_dir_all(made.join("pats")).unwrap();
        let text = &text.replace("made/", &format!("{}/", made.display()));
        fs::write(made.join("twice.wgsl"), twice).unwrap();
        fs::write(made.join("pats/posterise.wgsl"), posterise).unwrap();
        texture.save(made.join("map.png")).unwrap();
        let file = scene_in(folder.path(), text);
        let picture = folder.path().join("picture.png");
        let first = Render::scene_file(file).save(&picture).unwrap();
        assert!(!first.made_from.files.is_empty());
        let anonymous = folder.path().join("anonymous.png");
        let output = Output::create(&anonymous).unwrap();
        let written = first.write_telling(Told::Anonymous, Encoding::Png8, output);
        written.unwrap();
        let recipe = Recipe::of_file(&anonymous).unwrap().unwrap();
        assert!(recipe.made_from().unwrap().files.is_empty());
        fs::remove_dir_all(&made).unwrap();
        assert_eq!(again(&picture).image, first.image, "{text}");
        // The picture of the picture contains them, too.
        let second = folder.path().join("second.png");
        let file = SceneFile::open(&picture).unwrap().unwrap();
        Render::scene_file(file).save(&second).unwrap();
        assert_eq!(again(&second).image, first.image);
    }
}

/// Quality and preset set the keys that the scene of a picture was given without.
#[test]
fn quality_and_preset_change_a_picture_that_is_drawn_again() {
    let folder = folder_with_shells();
    let text = r#"{ "volume": { "path": "shells.nrrd" }, "size": [20, 16], "step_mm": 0.9 }"#;
    let file = scene_in(folder.path(), text);
    let picture = folder.path().join("picture.png");
    Render::scene_file(file.clone()).save(&picture).unwrap();
    let of_picture = SceneFile::open(&picture).unwrap().unwrap();
    type Change = fn(&mut Scene);
    let changes: [Change; 4] = [
        |_| (),
        |scene| scene.quality = Some(Quality::Minimum),
        |scene| scene.quality = Some(Quality::Maximum),
        |scene| scene.preset = Some("grey".into()),
    ];
    let mut images = Vec::new();
    for change in changes {
        let [a, b] = [&file, &of_picture].map(|file| {
            let render = Render::scene_file(file.clone()).with(change);
            render.picture().unwrap()
        });
        assert_eq!(a.image, b.image);
        assert_eq!(a.scene, b.scene);
        assert!(!images.contains(&a.image));
        images.push(a.image);
    }
}

/// The picture of another version is drawn with its defaults, which may differ from ours.
#[test]
fn a_picture_of_another_version_keeps_its_defaults() {
    let folder = folder_with_shells();
    let picture = Render::file(folder.path().join("shells.nrrd"))
        .size(8, 8)
        .picture()
        .unwrap();
    let mut recipe = Recipe::new(picture.scene.to_json()).with_made_from(&picture.made_from);
    recipe.software = "Strahl 0.0.1".into();
    let path = folder.path().join("old.png");
    let mut output = Output::create(&path).unwrap();
    let encoding = Encoding::Png8;
    strahl::write_picture(
        &picture.image,
        None,
        &picture.display,
        encoding,
        Some(&recipe),
        &mut output,
    )
    .unwrap();
    output.finish().unwrap();
    let scene = SceneFile::open(&path).unwrap().unwrap().scene;
    assert!(scene.reconstruct.is_some() && scene.camera.is_some());
    assert_eq!(again(&path).image, picture.image);
}

/// The background of the file is that of the scene, whatever exposure, tone map and gamma do to the light.
#[test]
fn the_background_is_not_tone_mapped() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.png");
    for (display, background, expected) in [
        (r#"{ "tone_map": "reinhard" }"#, "#ffffff", [255; 3]),
        (
            r#"{ "tone_map": "aces", "exposure": 3 }"#,
            "#8040c0",
            [0x80, 0x40, 0xc0],
        ),
        (r#"{ "gamma": 1.5 }"#, "#8040c0", [0x80, 0x40, 0xc0]),
        ("{}", "#8040c0", [0x80, 0x40, 0xc0]),
    ] {
        let text = format!(r#"{{ "background": "{background}", "display": {display} }}"#);
        let scene = Scene::parse("scene", &text).unwrap();
        let keys = scene.clone();
        let render = Render::volume(&shells()).size(24, 24).with(|scene| {
            (scene.background, scene.display) = (keys.background, keys.display);
        });
        render.save(&path).unwrap();
        let file = std::io::BufReader::new(fs::File::open(&path).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!(info.color_type, png::ColorType::Rgb);
        assert_eq!(bytes[..3], expected, "{display}");
        let objects = bytes.chunks(3).filter(|pixel| **pixel != expected);
        assert!(objects.count() > 50);
    }
}
