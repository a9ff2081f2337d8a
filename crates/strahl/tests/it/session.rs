//! Pictures that follow one another in one session.

use super::*;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use strahl::volume::Store;
use strahl::{Backend, Camera, Control, Error, Image, Render, Scene, Session, Work};

fn scene(text: &str) -> Scene {
    let source = r#""size": [48, 40], "volume": { "phantom": "shells", "dims": [40, 36, 44] }"#;
    Scene::parse("scene", &format!("{{ {source}, {text} }}")).unwrap()
}

fn draw(session: &Session, scene: &Scene) -> Image {
    session.draw(scene, &Control::NONE).unwrap().image
}

/// Pictures of every way in which something is derived from a volume.
const SCENES: [&str; 8] = [
    "",
    r#""method": "mip""#,
    r#""method": "first-hit", "threshold": 0.5"#,
    r#""reconstruct": "b-spline""#,
    r#""reconstruct": "b-spline-interpolating""#,
    r#""sampling": { "rule": "by-opacity", "share": 0.1 }"#,
    r#""sampling": { "rule": "integrated" }"#,
    r#""clips": [{ "box": { "min": [-20, -20, -20], "max": [20, 20, 5] } }]"#,
];

#[test]
fn an_orbit_makes_nothing_anew_after_its_first_picture() {
    for text in SCENES {
        let session = Session::new();
        let mut scene = scene(text);
        let mut after_first = None;
        for frame in 0..60 {
            scene.camera = Some(Camera {
                azimuth_deg: Some(6.0 * f64::from(frame)),
                elevation_deg: Some(if frame % 2 == 0 { 25.0 } else { -25.0 }),
                ..Camera::default()
            });
            draw(&session, &scene);
            let made = session.derived().made;
            assert_eq!(*after_first.get_or_insert(made), made, "{text}: {frame}");
        }
        assert!(after_first > Some(0), "{text}");
        assert_eq!(session.read().made, 1, "{text}");
    }
}

/// The scene with a point of its transfer function at `value`.
fn with_point(text: &str, value: f64) -> Scene {
    let function = format!(
        r##""transfer_function": {{ "points": [
            [0.2, 0, "#000"], [{value}, 0.7, "#c84"], [1.0, 0, "#fff"]
        ] }}"##
    );
    let text = match text {
        "" => function,
        text => format!("{text}, {function}"),
    };
    scene(&text)
}

#[test]
fn a_moved_point_of_the_transfer_function_makes_only_what_hangs_on_it() {
    for (text, hangs) in [
        ("", &["cubes of bricks", "visible bricks"][..]),
        (
            r#""reconstruct": "b-spline-interpolating""#,
            &["cubes of bricks", "visible bricks"],
        ),
        (
            r#""sampling": { "rule": "by-opacity", "share": 0.1 }"#,
            &["cubes of bricks", "sampling of bricks", "visible bricks"],
        ),
        (
            r#""sampling": { "rule": "integrated" }"#,
            &["cubes of bricks", "integrals", "visible bricks"],
        ),
    ] {
        let session = Session::new();
        draw(&session, &with_point(text, 0.5));
        let before = session.derived().made_by_name;
        draw(&session, &with_point(text, 0.6));
        let after = session.derived().made_by_name;
        let made_again: Vec<_> = after
            .iter()
            .filter(|(name, made)| before[**name] < **made)
            .map(|(name, _)| *name)
            .collect();
        assert_eq!(made_again, hangs, "{text}");
    }
}

#[test]
fn two_views_in_turns_do_not_push_one_another_out() {
    let session = Session::new();
    let views = [with_point("", 0.5), with_point(SCENES[4], 0.7)];
    for view in &views {
        draw(&session, view);
    }
    let made = session.derived().made;
    for _ in 0..5 {
        for view in &views {
            draw(&session, view);
        }
    }
    let counts = session.derived();
    assert_eq!((counts.made, counts.evicted), (made, 0));
}

#[test]
fn without_room_pictures_are_the_same() {
    let (roomy, tight) = (Session::new(), Session::with_budget(1 << 10));
    for _ in 0..2 {
        for text in SCENES {
            let scene = scene(text);
            assert_eq!(draw(&roomy, &scene), draw(&tight, &scene), "{text}");
        }
    }
    let (roomy, tight) = (roomy.derived(), tight.derived());
    assert_eq!(roomy.evicted, 0);
    assert!(tight.evicted > 0 && tight.made > roomy.made, "{tight:?}");
}

#[test]
fn renderers_change_without_a_second_reading() {
    let session = Session::new();
    let on = |backend: Backend| {
        let drawn = Render::scene(scene(""))
            .in_session(&session)
            .backend(backend);
        drawn.picture()
    };
    let first = on(Backend::Cpu).unwrap().image;
    let gpu = || on(Backend::Gpu { adapter: None });
    match gpu() {
        Ok(_) => {
            let alone = gpu().unwrap().image;
            // Pictures at the same time do not wait for one another, and share the device.
            std::thread::scope(|scope| {
                let both = [(); 2].map(|()| scope.spawn(|| gpu().unwrap().image));
                for drawn in both {
                    assert_eq!(drawn.join().unwrap(), alone);
                }
            });
            assert_eq!(session.devices_opened(), 1);
        }
        Err(Error::Gpu(strahl::gpu::Error::NoAdapter)) => {
            eprintln!("skipped: there is no graphics adapter");
        }
        Err(error) => panic!("{error}"),
    }
    assert_eq!(on(Backend::Cpu).unwrap().image, first);
    assert_eq!(session.read().made, 1);
}

#[test]
fn a_file_is_read_again_only_if_it_has_changed() {
    let folder = tempfile::tempdir().unwrap();
    let write_to = |volume: &Volume| {
        let options = WriteOptions::default();
        let mut files = NewMemoryFiles::default();
        write("volume.mhd", volume, &options, &mut files).unwrap();
        for (name, bytes) in files.0 {
            let path = folder.path().join(name);
            if std::fs::read(&path).ok().as_ref() != Some(&bytes) {
                std::fs::write(path, bytes).unwrap();
            }
        }
    };
    let session = Session::new();
    let draw = || {
        let path = folder.path().join("volume.mhd");
        let drawn = Render::file(path).size(24, 24).in_session(&session);
        drawn.picture().unwrap().image
    };
    write_to(&shells());
    let first = draw();
    assert_eq!(draw(), first);
    assert_eq!(session.read().made, 1);
    // The header stays as it is, its data file does not.
    let other = Phantom::Tree.volume([16, 12, 8]).unwrap();
    write_to(&other);
    let names = names(folder.path());
    let data = names.iter().find(|name| *name != "volume.mhd").unwrap();
    let data = folder.path().join(data);
    let later = std::time::SystemTime::now() + std::time::Duration::from_secs(5);
    let file = std::fs::File::options().write(true).open(data).unwrap();
    file.set_modified(later).unwrap();
    assert_ne!(draw(), first);
    assert_eq!(session.read().made, 2);
}

/// Draws `text` in `session` and in a session of its own; both have to be the same. What is drawn.
fn as_if_fresh(session: &Session, text: &str) -> Image {
    let scene = Scene::parse("scene", text).unwrap();
    let image = draw(session, &scene);
    assert_eq!(image, draw(&Session::new(), &scene), "{text}");
    image
}

fn write_later(path: &Path, bytes: &[u8], seconds: u64) {
    std::fs::write(path, bytes).unwrap();
    let later = std::time::SystemTime::now() + std::time::Duration::from_secs(seconds);
    let file = std::fs::File::options().write(true).open(path).unwrap();
    file.set_modified(later).unwrap();
}

#[test]
fn a_mask_of_labels_is_made_anew_if_their_data_changes_behind_a_header() {
    let folder = tempfile::tempdir().unwrap();
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 10 10 10\nspace: right-anterior-superior\n\
                  space directions: (3,0,0) (0,3,0) (0,0,3)\nspace origin: (-13.5,-13.5,-13.5)\nencoding: raw\n";
    let halves = |is_first: bool| -> Vec<u8> {
        let is_in = |i: usize| (i % 10 < 5) == is_first;
        (0..1000).map(|i| u8::from(is_in(i))).collect()
    };
    let masks = folder.path().join("masks");
    std::fs::create_dir(&masks).unwrap();
    let detached = folder.path().join("labels.nhdr");
    let with_data = format!("{header}data file: labels.raw\n");
    std::fs::write(&detached, with_data).unwrap();
    for path in [&detached, &masks] {
        let session = Session::new();
        let pictures = [true, false].map(|is_first| {
            let (file, mut bytes) = match path == &masks {
                true => (masks.join("liver.nrrd"), format!("{header}\n").into_bytes()),
                false => (folder.path().join("labels.raw"), Vec::new()),
            };
            bytes.extend(halves(is_first));
            write_later(&file, &bytes, if is_first { 10 } else { 50 });
            as_if_fresh(
                &session,
                &format!(
                    r#"{{ "size": [24, 20], "volume": {{ "phantom": "anatomy", "dims": [16, 16, 16] }},
                        "clips": [{{ "mask": {{ "path": {path:?}, "labels": [1] }} }}] }}"#
                ),
            )
        });
        assert_ne!(pictures[0], pictures[1], "{path:?}");
    }
}

/// A slice of a series of CT, 8 × 8 × 2 mm.
fn slice(number: u32) -> Vec<u8> {
    let mut bytes = vec![0; 128];
    bytes.extend(b"DICM");
    let mut add = |group: u16, element: u16, vr: &str, value: &[u8]| {
        let padding = value.len() % 2;
        bytes.extend(group.to_le_bytes());
        bytes.extend(element.to_le_bytes());
        bytes.extend(vr.as_bytes());
        if vr == "OW" {
            bytes.extend([0, 0]);
            bytes.extend((value.len() as u32).to_le_bytes());
        } else {
            bytes.extend(((value.len() + padding) as u16).to_le_bytes());
        }
        bytes.extend(value);
        bytes.extend(&[if vr == "UI" { 0 } else { b' ' }][..padding]);
    };
    let class = b"1.2.840.10008.5.1.4.1.1.2";
    let instance = format!("1.2.3.4.{number}");
    add(0x02, 0x10, "UI", b"1.2.840.10008.1.2.1");
    add(0x08, 0x16, "UI", class);
    add(0x08, 0x18, "UI", instance.as_bytes());
    add(0x08, 0x60, "CS", b"CT");
    add(0x20, 0x0D, "UI", b"1.2.3.5");
    add(0x20, 0x0E, "UI", b"1.2.3.6");
    add(0x20, 0x13, "IS", number.to_string().as_bytes());
    add(0x20, 0x32, "DS", format!("0\\0\\{}", 2 * number).as_bytes());
    add(0x20, 0x37, "DS", b"1\\0\\0\\0\\1\\0");
    add(0x28, 0x02, "US", &1u16.to_le_bytes());
    add(0x28, 0x04, "CS", b"MONOCHROME2");
    add(0x28, 0x10, "US", &8u16.to_le_bytes());
    add(0x28, 0x11, "US", &8u16.to_le_bytes());
    add(0x28, 0x30, "DS", b"2\\2");
    add(0x28, 0x100, "US", &16u16.to_le_bytes());
    add(0x28, 0x101, "US", &16u16.to_le_bytes());
    add(0x28, 0x102, "US", &15u16.to_le_bytes());
    add(0x28, 0x103, "US", &0u16.to_le_bytes());
    let number_of = |i: u32| (i * 37 * (number + 1) % 1000) as u16;
    let pixels: Vec<u8> = (0..64).flat_map(|i| number_of(i).to_le_bytes()).collect();
    add(0x7FE0, 0x10, "OW", &pixels);
    bytes
}

#[test]
fn a_slice_that_comes_late_is_seen_and_a_picture_beside_the_series_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let series = folder.path().join("series");
    std::fs::create_dir(&series).unwrap();
    let write = |number: u32| {
        let path = series.join(format!("{number:03}.dcm"));
        std::fs::write(path, slice(number)).unwrap();
    };
    (1..5).for_each(write);
    // By a file of it, its folder, and the folder above.
    for (late, path) in (5..).zip([series.join("001.dcm"), series.clone(), folder.path().into()]) {
        let session = Session::new();
        let text =
            format!(r#"{{ "size": [24, 20], "volume": {{ "path": {path:?} }}, "method": "mip" }}"#);
        let before = as_if_fresh(&session, &text);
        if path.is_file() {
            // In a folder, a reader looks at every file.
            std::fs::write(series.join(format!("{late}.png")), "a picture").unwrap();
            assert_eq!(as_if_fresh(&session, &text), before);
            assert_eq!(session.read().made, 1, "{path:?}");
        }
        write(late);
        assert_ne!(as_if_fresh(&session, &text), before, "{path:?}");
        assert_eq!(session.read().made, 2, "{path:?}");
    }
}

/// What a control has heard.
type Heard = Arc<Mutex<Vec<(Work, f64)>>>;

/// Control that ends work of this kind at once, and counts what it hears of each kind.
fn ending(kind: Work) -> (Control, Heard) {
    let heard = Arc::new(Mutex::new(Vec::new()));
    let of_control = heard.clone();
    let control = Control::listening(move |work, share| {
        of_control.lock().unwrap().push((work, share));
        match work == kind {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    });
    (control, heard)
}

#[test]
fn whatever_is_cancelled_ends_early_and_can_be_drawn_later() {
    let expected = draw(&Session::new(), &scene(SCENES[4]));
    for kind in [Work::Reading, Work::Preparing, Work::Drawing] {
        let session = Session::new();
        let (control, heard) = ending(kind);
        let error = session.draw(&scene(SCENES[4]), &control).unwrap_err();
        assert!(matches!(error, Error::Cancelled), "{kind:?}: {error}");
        let heard = heard.lock().unwrap();
        let of_kind = heard.iter().filter(|(work, _)| *work == kind).count();
        // Other threads may have been told at the same time.
        assert!((1..=16).contains(&of_kind), "{kind:?}: {heard:?}");
        assert!(
            heard
                .iter()
                .all(|(work, share)| *work != kind || *share < 1.0)
        );
        assert_eq!(draw(&session, &scene(SCENES[4])), expected, "{kind:?}");
    }
}

#[test]
fn a_reader_that_is_cancelled_reads_no_further() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("large_160x160x160_u16.raw");
    std::fs::write(&path, vec![0; 2 * 160 * 160 * 160]).unwrap();
    let (control, heard) = ending(Work::Reading);
    let error = strahl::load_under(&[path], &Default::default(), &control).unwrap_err();
    assert!(error.to_string() == "cancelled", "{error}");
    let heard = heard.lock().unwrap();
    assert!(heard.len() == 1 && heard[0].1 < 0.2, "{heard:?}");
}

#[test]
fn threads_that_draw_at_once_make_everything_once() {
    let session = Session::new();
    let different = AtomicUsize::new(0);
    let expected = draw(&Session::new(), &scene(""));
    std::thread::scope(|scope| {
        for _ in 0..6 {
            scope.spawn(|| {
                if draw(&session, &scene("")) != expected {
                    different.fetch_add(1, Ordering::Relaxed);
                }
            });
        }
    });
    assert_eq!(different.into_inner(), 0);
    assert_eq!(session.read().made, 1);
    assert!(
        session
            .derived()
            .made_by_name
            .values()
            .all(|made| *made == 1)
    );
}

#[test]
fn what_is_forgotten_is_read_again() {
    let session = Session::with_budget(Store::USUAL_BUDGET_BYTES);
    draw(&session, &scene(""));
    session.forget();
    draw(&session, &scene(""));
    assert_eq!(session.read().made, 2);
}

/// Whoever waits for a pool draws another picture meanwhile: nothing may be held that this one waits for.
#[test]
fn pictures_of_graphs_are_drawn_from_within_a_pool() {
    use rayon::prelude::*;
    let session = Session::new();
    let scene = scene(r#""graph": { "edits": [] }"#);
    let draw = |_| {
        let render = Render::scene(scene.clone()).threads(2);
        render.in_session(&session).picture().unwrap().image
    };
    let images: Vec<Image> = (0..12).into_par_iter().map(draw).collect();
    assert!(images.iter().all(|image| *image == images[0]));
}
