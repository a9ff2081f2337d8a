//! The library front.

use super::*;
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex};
use strahl::scene::{PlaneClip, TransferPoint};
use strahl::volume::{Grid, Metadata, Rescale, Samples, Volume};
use strahl::{
    Background, Clip, Color, Control, Error, Recipe, Render, Scene, Session, TransferFunction, Work,
};

#[test]
fn a_file_becomes_a_picture() {
    let folder = folder_with_shells();
    let picture = folder.path().join("picture.png");
    strahl::render_file(folder.path().join("shells.nrrd"), &picture).unwrap();
    let recipe = Recipe::of_file(&picture).unwrap().unwrap();
    assert_eq!(recipe.software, strahl::SOFTWARE);
    let scene = Scene::parse("recipe", &recipe.scene).unwrap();
    assert_eq!(scene.volume.unwrap().path.as_deref(), Some("shells.nrrd"));
}

#[test]
fn memory_and_file_give_the_same_picture() {
    let folder = folder_with_shells();
    let path = folder.path().join("shells.nrrd");
    let loaded = strahl::load(&path, &Default::default()).unwrap();
    let from_memory = Render::volume(&loaded.volume)
        .size(32, 24)
        .picture()
        .unwrap();
    let from_file = Render::file(&path).size(32, 24).picture().unwrap();
    assert_eq!(from_memory.image, from_file.image);
    assert_eq!(from_memory.scene.volume, None);
}

/// A level of detail changes detail only: what a scene leaves out follows from the whole volume.
#[test]
fn a_level_of_detail_keeps_the_look() {
    let session = Session::default();
    let at = |level: f64, text: &str| {
        let scene = Scene::parse("scene", text).unwrap();
        let render = Render::phantom(Phantom::Anatomy)
            .with(|own| {
                let volume = own.volume.take();
                *own = scene;
                own.volume = volume;
                let volume = own.volume.as_mut().unwrap();
                volume.dims = Some([40, 40, 40]);
                volume.level = Some(level);
            })
            .size(24, 24)
            .in_session(&session)
            .background(Background::Transparent);
        let mut settled = render.settled_scene().unwrap();
        settled.volume = None;
        let image = render.picture().unwrap().image;
        let alphas = (0..24 * 24).map(|i| f64::from(image.pixel(i % 24, i / 24)[3]));
        (settled, alphas.sum::<f64>() / f64::from(24 * 24))
    };
    for text in ["{}", r#"{ "method": "gmip" }"#, r#"{ "debug": "depth" }"#] {
        let (whole, alpha) = at(0.0, text);
        for level in [0.5, 1.0] {
            let (coarse, coarse_alpha) = at(level, text);
            assert_eq!(coarse, whole, "{text} at level {level}");
            assert!(
                (coarse_alpha / alpha - 1.0).abs() < 0.3,
                "{text} at level {level}: {coarse_alpha}, {alpha}"
            );
        }
    }
}

/// The notes of a picture of the shells, whose values are 0 to 1.
fn notes(text: &str) -> String {
    let scene = Scene::parse("scene", text).unwrap();
    let picture = Render::volume(&shells())
        .with(|own| *own = scene)
        .size(24, 20)
        .with_depth()
        .picture()
        .unwrap();
    let notes: Vec<_> = picture.notes.iter().map(ToString::to_string).collect();
    notes.join("\n")
}

#[test]
fn what_changes_nothing_is_noted() {
    let mida = notes(r#"{ "method": "mida", "threshold": 0.3 }"#);
    assert_eq!(
        mida,
        "threshold changes nothing: the method is mida; only first-hit draws a surface at a threshold\n\
         depth changes nothing: mida finds no surface, and there is no mesh"
    );
    assert_eq!(notes(r#"{ "method": "first-hit", "threshold": 0.3 }"#), "");
}

/// The picture shows the other volume, so that nobody would look for what is missing.
#[test]
fn volumes_of_which_clips_leave_nothing_are_noted() {
    // A mask of the right half, where the moved object does not come.
    let grid = Grid::centered([32; 3], strahl::glam::DVec3::ONE).unwrap();
    let half: Vec<u8> = (0..32 * 32 * 32).map(|i| u8::from(i % 32 >= 16)).collect();
    let of = |samples| Volume::new(grid, samples, Rescale::IDENTITY, Metadata::default()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    save(&of(Samples::U8(half)), folder.path(), "half.nrrd");
    save(
        &of(Samples::U8(vec![200; 32 * 32 * 32])),
        folder.path(),
        "full.nrrd",
    );
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let notes = |move_mm: f64, clip: &str| {
        let scene = Scene::parse(
            "scene",
            &format!(
                r##"{{ "volume": {{ "path": {:?} }}, "size": [24, 24], "camera": {{ "view": "front" }},
                "objects": [{{ "name": "b", "like": "volume", "transform": {{ "translate_mm": [{move_mm}, 0, 0] }},
                    "transfer_function": {{ "points": [[0, 0, "#000"], [200, 0.5, "#f00"]] }} }}],
                "transfer_function": {{ "points": [[0, 0, "#000"], [200, 0.5, "#fff"]] }},
                "clips": [{{ {clip} }}] }}"##,
                path("full.nrrd")
            ),
        );
        let picture = Render::scene(scene.unwrap()).picture();
        let notes = picture.unwrap_or_else(|error| panic!("{error}")).notes;
        notes.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    let mask = format!(
        r#""mask": {{ "path": {:?}, "objects": ["b"] }}"#,
        path("half.nrrd")
    );
    let found = notes(-24.0, &mask);
    assert!(
        found.len() == 1 && found[0].contains("leave nothing of the object \"b\""),
        "{found:?}"
    );
    // Part of it, or all, is left.
    assert_eq!(notes(-12.0, &mask), [""; 0]);
    assert_eq!(notes(4.0, &mask), [""; 0]);
    for (clip, expected) in [
        (
            r#""plane": { "normal": [1, 0, 0], "point": [40, 0, 0], "objects": ["b"] }"#,
            "the object \"b\"",
        ),
        (
            r#""box": { "min": [-60, -60, -60], "max": [17, 60, 60], "keep": "outside", "objects": ["volume"] }"#,
            "the scene's own volume",
        ),
    ] {
        let found = notes(20.0, clip);
        assert!(
            found.len() == 1 && found[0].contains(expected),
            "{clip}: {found:?}"
        );
    }
}

#[test]
fn empty_pictures_are_noted() {
    let above = notes(r#"{ "method": "first-hit", "threshold": 7 }"#);
    assert!(
        above.contains("shows nothing but its background: the threshold 7"),
        "{above}"
    );
    for background in ["#000", "#fff", "#8a3a2a", "transparent"] {
        let text = format!(
            r##"{{ "method": "first-hit", "background": "{background}", "compositing": "display",
                "camera": {{ "position": [0, 90, 0], "focus": [0, 180, 0] }} }}"##
        );
        assert!(
            notes(&text).contains("no ray meets a volume"),
            "{background}"
        );
        let seen = format!(r##"{{ "method": "first-hit", "background": "{background}" }}"##);
        assert_eq!(notes(&seen), "");
    }
}

/// On the CPU, more masks than shader programs hold cut as one mask of all that they remove.
#[test]
fn many_masks_cut_as_one() {
    let folder = folder_with_shells();
    let volume = shells();
    let slabs = 6;
    let mask = |removed: &dyn Fn(usize) -> bool| {
        let kept = (0..16 * 12 * 8).map(|i| u8::from(!removed(i % 16)));
        let samples = Samples::U8(kept.collect());
        let made = Volume::new(
            *volume.grid(),
            samples,
            Rescale::IDENTITY,
            Metadata::default(),
        );
        made.unwrap()
    };
    for i in 0..slabs {
        save(&mask(&|x| x == 2 * i), folder.path(), &format!("{i}.nrrd"));
    }
    save(
        &mask(&|x| x % 2 == 0 && x < 2 * slabs),
        folder.path(),
        "all.nrrd",
    );
    let draw = |files: &[String], graph: &str| {
        let clips = files.iter();
        let clips: Vec<_> = clips
            .map(|file| format!(r#"{{ "mask": {{ "path": "{file}" }} }}"#))
            .collect();
        let text = format!(
            r#"{{ "volume": {{ "path": "shells.nrrd" }}, "size": [20, 16], {graph} "clips": [{}] }}"#,
            clips.join(", ")
        );
        let path = folder.path().join("scene.json");
        std::fs::write(&path, text).unwrap();
        let file = strahl::SceneFile::open(&path).unwrap().unwrap();
        Render::scene_file(file).picture()
    };
    let several: Vec<_> = (0..slabs).map(|i| format!("{i}.nrrd")).collect();
    let one = draw(&["all.nrrd".to_owned()], "").unwrap();
    let uncut = draw(&[], "").unwrap();
    assert_eq!(draw(&several, "").unwrap().image, one.image);
    assert_ne!(uncut.image, one.image);
    let graph = r#""graph": { "strahl_graph": 1 },"#;
    assert!(draw(&several[..4], graph).is_ok());
    let message = draw(&several, graph).unwrap_err().to_string();
    assert!(
        message.contains("4 masks, and the scene has 6"),
        "{message}"
    );
}

#[test]
fn what_is_built_is_drawn() {
    let volume = shells();
    let red = Color([1.0, 0.0, 0.0]);
    let picture = Render::volume(&volume)
        .transfer_function(TransferFunction {
            points: Some(vec![
                TransferPoint::new(0.1, 0.0, red),
                TransferPoint::new(0.3, 1.0, red),
            ]),
            ..TransferFunction::default()
        })
        .clip(Clip::Plane(PlaneClip {
            normal: [1.0, 0.0, 0.0],
            ..PlaneClip::default()
        }))
        .view(strahl::View::Front)
        .background(Background::Transparent)
        .size(40, 40)
        .picture()
        .unwrap();
    // Seen from the front, the patient's right (+x) is on the left of the picture; the plane keeps it.
    let half = |from: u32, to: u32| {
        (from..to)
            .flat_map(|x| (0..40).map(move |y| (x, y)))
            .map(|(x, y)| picture.image.pixel(x, y))
            .fold([0.0f32; 4], |sum, p| std::array::from_fn(|c| sum[c] + p[c]))
    };
    let (left, right) = (half(0, 20), half(21, 40));
    assert!(left[0] > 20.0 && left[3] > 100.0, "{left:?}");
    assert!(left[0] > left[1] * 2.0, "{left:?}");
    assert!(right[3] < 0.1 * left[3], "{left:?} {right:?}");
}

#[test]
fn mistakes_come_all_at_once() {
    let volume = shells();
    let nan = TransferPoint {
        value: f64::NAN,
        opacity: Some(0.5),
        color: None,
    };
    let error = Render::volume(&volume)
        .size(0, 10)
        .preset("ct-bonne")
        .transfer_function(TransferFunction {
            points: Some(vec![nan]),
            ..TransferFunction::default()
        })
        .with(|scene| scene.step_mm = Some(-1.0))
        .picture()
        .unwrap_err();
    let Error::Problems {
        file: None,
        problems,
    } = &error
    else {
        panic!("{error}")
    };
    let paths: Vec<&str> = problems.iter().map(|p| p.path.as_str()).collect();
    for path in [
        "preset",
        "size[0]",
        "transfer_function.points[0].value",
        "step_mm",
    ] {
        assert!(paths.contains(&path), "{path} not in {paths:?}");
    }
}

#[test]
fn progress_reaches_its_end() {
    let folder = folder_with_shells();
    let told = Arc::new(Mutex::new(Vec::new()));
    let of_control = told.clone();
    let control = Control::listening(move |work, share| {
        of_control.lock().unwrap().push((work, share));
        ControlFlow::Continue(())
    });
    Render::file(folder.path().join("shells.nrrd"))
        .size(64, 64)
        .control(&control)
        .picture()
        .unwrap();
    let told = told.lock().unwrap();
    for work in [Work::Reading, Work::Preparing, Work::Drawing] {
        assert!(told.contains(&(work, 1.0)), "{work:?}: {told:?}");
    }
}
