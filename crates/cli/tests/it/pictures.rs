//! Picture files: made again from themselves, the same at any number of threads.

use super::*;
use std::fs;

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    fs::read(folder.join(name)).unwrap()
}

/// Kind of pixels, width and height, and the pixels of a PNG.
fn decoded(path: &Path) -> (png::ColorType, [u32; 2], Vec<u8>) {
    let file = fs::File::open(path).unwrap();
    let mut reader = png::Decoder::new(std::io::BufReader::new(file))
        .read_info()
        .unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    (info.color_type, [info.width, info.height], pixels)
}

#[test]
fn a_picture_can_be_made_again_from_itself() {
    let folder = folder_with_shells();
    let here = folder.path();
    let look = ["--size", "40x30", "--preset", "mip", "--color-map", "magma"];
    for name in ["a.png", "a.exr"] {
        run_well(
            here,
            &[&["render", "shells.nrrd", "-o", name], &look[..]].concat(),
        );
        let again = format!("again-{name}");
        run_well(here, &["render", name, "-o", &again]);
        assert!(bytes(here, name) == bytes(here, &again), "{name}");
    }
    // From one kind to the other, too.
    run_well(here, &["render", "a.exr", "-o", "from-exr.png"]);
    assert!(bytes(here, "a.png") == bytes(here, "from-exr.png"));
    // And with its data in another place, called from elsewhere.
    let moved = here.join("moved");
    fs::create_dir(&moved).unwrap();
    for name in ["a.png", "shells.nrrd"] {
        fs::rename(here.join(name), moved.join(name)).unwrap();
    }
    run_well(here, &["render", "moved/a.png", "-o", "moved/again.png"]);
    assert!(bytes(&moved, "a.png") == bytes(&moved, "again.png"));
}

#[test]
fn flags_change_a_picture_that_is_made_again() {
    let folder = folder_with_shells();
    let here = folder.path();
    run_well(
        here,
        &["render", "shells.nrrd", "-o", "a.png", "--size", "24x24"],
    );
    run_well(here, &["render", "a.png", "-o", "b.png", "--view", "back"]);
    run_well(
        here,
        &[
            "render",
            "shells.nrrd",
            "-o",
            "c.png",
            "--size",
            "24x24",
            "--view",
            "back",
        ],
    );
    assert!(bytes(here, "a.png") != bytes(here, "b.png"));
    assert!(bytes(here, "b.png") == bytes(here, "c.png"));
}

/// Labels are a mask without a file of its own.
#[test]
fn labels_clip_as_the_mask_of_them_does() {
    let folder = folder_with_shells();
    let here = folder.path();
    let shells = shells();
    let [nx, ny, nz] = shells.grid().dims();
    let ids: Vec<u8> = (0..nx * ny * nz).map(|i| (i % nx / 5) as u8).collect();
    let of = |samples| {
        Volume::new(
            *shells.grid(),
            strahl::volume::Samples::U8(samples),
            strahl::volume::Rescale::IDENTITY,
            strahl::volume::Metadata::default(),
        )
        .unwrap()
    };
    let inside = ids.iter().map(|id| u8::from([0, 2].contains(id))).collect();
    save(&of(inside), here, "mask.nrrd");
    save(&of(ids), here, "labels.nrrd");
    let draw = |name: &str, mask: &str| {
        let scene = format!(
            r#"{{ "volume": {{ "path": "shells.nrrd" }}, "size": [40, 30], "clips": [{{ "mask": {mask} }}] }}"#
        );
        fs::write(here.join("scene.json"), scene).unwrap();
        run_well(here, &["render", "scene.json", "-o", name]);
        decoded(&here.join(name))
    };
    let labels = draw("a.png", r#"{ "path": "labels.nrrd", "labels": [0, 2] }"#);
    assert!(labels == draw("b.png", r#"{ "path": "mask.nrrd" }"#));
    assert!(labels != draw("c.png", r#"{ "path": "labels.nrrd", "labels": [1] }"#));
    // The picture knows them.
    run_well(here, &["render", "a.png", "-o", "again.png"]);
    assert!(bytes(here, "a.png") == bytes(here, "again.png"));
}

/// Layers of values, masks of the same voxels and a label file of them draw the same picture, also by the names of groups.
#[test]
fn segments_need_no_label_file() {
    let folder = folder_with_shells();
    let here = folder.path();
    let shells = shells();
    let values = |from: f64, to: f64| {
        let count = shells.grid().voxel_count();
        let inside = (0..count).map(|i| {
            let value = shells.rescale().value(shells.samples().get(i));
            u8::from((from..to).contains(&value))
        });
        let samples = strahl::volume::Samples::U8(inside.collect());
        let metadata = strahl::volume::Metadata::default();
        let rescale = strahl::volume::Rescale::IDENTITY;
        Volume::new(*shells.grid(), samples, rescale, metadata).unwrap()
    };
    let [low, high] = shells.statistics().range;
    let [first, second] = [1.0, 2.0].map(|i| low + (high - low) * i / 3.0);
    save(&values(first, second), here, "outer.nrrd");
    save(&values(second, f64::INFINITY), here, "inner.nrrd");
    let draw = |name: &str, labels: &str, of: &str| {
        let text = format!(
            r##"{{ "volume": {{ "path": "shells.nrrd" }}, "size": [40, 30], "labels": {{ {labels} }},
                "segments": [{{ "of": {of}, "opacity": 0.3 }}] }}"##
        );
        fs::write(here.join("labels.json"), text).unwrap();
        let run = run(here, &["render", "labels.json", "-o", name]);
        assert_eq!(run.code, Some(0), "{}", run.err);
        (decoded(&here.join(name)), run.err)
    };
    let (equal, said) = draw("equal.png", r#""layers": 3"#, r#""layer 1""#);
    assert!(!said.contains("no segment"), "{said}");
    let from = format!(r#""layers": [{first}, {{ "from": {second}, "name": "core" }}]"#);
    assert!(equal == draw("from.png", &from, r#""layer 1""#).0);
    let masks = r#""masks": [{ "path": "outer.nrrd", "name": "rim" }, { "path": "inner.nrrd" }]"#;
    assert!(equal == draw("masks.png", masks, r#""rim""#).0);
    let groups = format!(r#"{masks}, "groups": {{ "Outside": ["rim", 9] }}"#);
    let (grouped, said) = draw("groups.png", &groups, r#"{ "group": "outside" }"#);
    assert!(equal == grouped);
    assert!(said.contains("no segment has the id 9"), "{said}");
    let (other, said) = draw("other.png", masks, r#"{ "group": "outside" }"#);
    assert!(equal != other);
    assert!(
        said.contains(r#"no segment has the group "outside"; the labels have no groups"#),
        "{said}"
    );
    // The picture knows its masks; as layers it is drawn by flags, too.
    run_well(here, &["render", "masks.png", "-o", "again.png"]);
    assert!(bytes(here, "masks.png") == bytes(here, "again.png"));
    let by_flags = ["--layers", "3", "--only", "layer 2"];
    let args = ["render", "shells.nrrd", "--size", "40x30"];
    run_well(here, &[&args[..], &by_flags, &["-o", "flags.png"]].concat());
    fs::write(
        here.join("only.json"),
        r#"{ "volume": { "path": "shells.nrrd" }, "size": [40, 30], "labels": { "layers": 3 },
             "segments": [{ "of": 1, "show": false }] }"#,
    )
    .unwrap();
    run_well(here, &["render", "only.json", "-o", "only.png"]);
    assert!(decoded(&here.join("flags.png")) == decoded(&here.join("only.png")));
    let wrong = run(
        here,
        &[&args[..], &["--layers", "a", "-o", "x.png"]].concat(),
    );
    assert!(
        wrong.err.contains("--layers is \"a\"; allowed"),
        "{}",
        wrong.err
    );
}

/// What flags say of segments is what a scene says, and what there is nothing of is said.
#[test]
fn flags_say_which_segments_are_drawn() {
    let folder = folder_with_shells();
    let here = folder.path();
    let shells = shells();
    let [nx, ny, nz] = shells.grid().dims();
    let ids: Vec<u8> = (0..nx * ny * nz).map(|i| (i % nx / 5) as u8).collect();
    let ids = Volume::new(
        *shells.grid(),
        strahl::volume::Samples::U8(ids),
        strahl::volume::Rescale::IDENTITY,
        strahl::volume::Metadata::default(),
    );
    save(&ids.unwrap(), here, "labels.nrrd");
    let draw = |name: &str, flags: &[&str]| {
        let args = [
            "render",
            "shells.nrrd",
            "--labels",
            "labels.nrrd",
            "-o",
            name,
            "--size",
            "40x30",
        ];
        let run = run(here, &[&args, flags].concat());
        assert_eq!(run.code, Some(0), "{}", run.err);
        (decoded(&here.join(name)), run.err)
    };
    let (all, _) = draw("all.png", &[]);
    let (hidden, _) = draw("hidden.png", &["--hide", "1", "--hide", "3"]);
    let (only, _) = draw("only.png", &["--only", "2"]);
    assert!(all != hidden);
    assert!(hidden == only);
    let (highlighted, _) = draw("highlighted.png", &["--highlight", "2"]);
    assert!(highlighted != only && highlighted != all);
    let (_, said) = draw("none.png", &["--only", "9"]);
    assert!(said.contains("no segment has the id 9"), "{said}");
    assert!(
        said.contains("every segment is hidden: the picture is empty"),
        "{said}"
    );
    assert_eq!(said.matches("note").count(), 2, "{said}");
    let without = run(
        here,
        &[
            "render",
            "shells.nrrd",
            "-o",
            "w.png",
            "--size",
            "8x8",
            "--hide",
            "1",
        ],
    );
    assert!(
        without
            .err
            .contains("--hide is 1, and the volume has no labels; give them with --labels FILE"),
        "{}",
        without.err
    );
    assert!(without.code == Some(1) && !here.join("w.png").exists());
    let of_preset = [
        "render",
        "shells.nrrd",
        "-o",
        "w.png",
        "--preset",
        "anatomy",
    ];
    let err = run(here, &[&of_preset[..], &["--size", "8x8"]].concat()).err;
    assert!(err.contains("the preset anatomy draws segments"), "{err}");
    // The picture knows what was typed.
    run_well(here, &["render", "only.png", "-o", "again.png"]);
    assert!(bytes(here, "only.png") == bytes(here, "again.png"));
}

/// A picture of several files does not know them; the message says what to do.
#[test]
fn a_picture_of_several_files_asks_for_them() {
    let Some(head) = shared_data("head-mr-dicom") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let slices: Vec<String> = names(&head)
        .iter()
        .take(4)
        .map(|name| head.join(name).display().to_string())
        .collect();
    let slices: Vec<&str> = slices.iter().map(String::as_str).collect();
    let render = |first: &[&str], name: &str| {
        let args = [first, &slices, &["-o", name, "--size", "32x32"]].concat();
        run_well(folder.path(), &args);
    };
    render(&["render"], "a.png");
    let again = run(folder.path(), &["render", "a.png", "-o", "b.png"]);
    assert_eq!(again.code, Some(1));
    assert!(
        again.err.contains("a.png: volume is missing"),
        "{}",
        again.err
    );
    render(&["render", "a.png"], "b.png");
    assert!(bytes(folder.path(), "a.png") == bytes(folder.path(), "b.png"));
}

#[test]
fn threads_change_nothing() {
    let folder = folder_with_shells();
    let mut pictures = ["1", "2", "7"].map(|threads| {
        let name = format!("{threads}.exr");
        let args = [
            "render",
            "shells.nrrd",
            "-o",
            &name,
            "--size",
            "70x50",
            "--threads",
            threads,
        ];
        run_well(folder.path(), &args);
        bytes(folder.path(), &name)
    });
    pictures.sort();
    assert!(pictures[0] == pictures[2]);
}

#[test]
fn bits_are_as_asked() {
    let folder = folder_with_shells();
    for (name, bits, depth) in [("a.png", "8", 8), ("b.png", "16", 16)] {
        let args = [
            "render",
            "shells.nrrd",
            "-o",
            name,
            "--size",
            "8x8",
            "--bits",
            bits,
        ];
        run_well(folder.path(), &args);
        // Byte 24 of a PNG is the bit depth of its header chunk.
        assert_eq!(bytes(folder.path(), name)[24], depth);
    }
}

#[test]
fn transparent_pictures_have_alpha() {
    let folder = folder_with_shells();
    let args = [
        "render",
        "shells.nrrd",
        "-o",
        "a.png",
        "--size",
        "40x20",
        "--transparent",
    ];
    run_well(folder.path(), &args);
    let (color_type, _, pixels) = decoded(&folder.path().join("a.png"));
    assert_eq!(color_type, png::ColorType::Rgba);
    assert_eq!(pixels[..4], [0; 4]);
    assert!(pixels.chunks(4).any(|pixel| pixel[3] > 200));
}

#[test]
fn stages_end_with_the_picture() {
    let folder = folder_with_shells();
    let size = ["--size", "50x34"];
    let render = |more: &[&str]| {
        let args = [&["render", "shells.nrrd"], more, &size].concat();
        run(folder.path(), &args)
    };
    let drawn = render(&["-o", "staged.png", "--stages", "stages/of"]);
    assert_eq!(drawn.code, Some(0), "{}", drawn.err);
    assert_eq!(render(&["-o", "plain.png"]).code, Some(0));
    let decoded = |name: &str| decoded(&folder.path().join(name));
    let plain = decoded("plain.png");
    assert!(decoded("staged.png") == plain);
    assert_eq!(
        names(&folder.path().join("stages/of")),
        ["stage-1.png", "stage-2.png", "stage-3.png"]
    );
    let stages = [1, 2, 3].map(|n| decoded(&format!("stages/of/stage-{n}.png")));
    assert!(stages[2] == plain);
    assert!(stages[0] != stages[1] && stages[1] != plain);
    assert!(stages.iter().all(|stage| stage.1 == [50, 34]));

    let refused = render(&["-o", "no.png", "--stages", "shells.nrrd"]);
    assert_eq!(refused.code, Some(1));
    assert!(
        refused.err.contains("--stages is shells.nrrd"),
        "{}",
        refused.err
    );
    let refused = render(&["-o", "no.png", "--stages", "s", "--backend", "auto"]);
    assert_eq!(refused.code, Some(1));
    assert!(refused.err.contains("--backend cpu"), "{}", refused.err);
    assert!(!folder.path().join("no.png").exists());
}
