//! Whatever is wrong gives one message that names it and says what would be right, exit code 1, and
//! no file.

use super::*;
use std::fs;

/// Runs a call that has to fail with a message that holds `words`, and leaves the folder as it was.
#[track_caller]
fn fails(folder: &Path, args: &[&str], words: &[&str]) {
    let before = names(folder);
    let run = run(folder, args);
    assert_eq!(run.code, Some(1), "strahl {args:?}: {}{}", run.out, run.err);
    assert_eq!(run.out, "", "strahl {args:?}");
    assert_eq!(run.err.matches("error: ").count(), 1, "{}", run.err);
    assert!(run.err.starts_with("error: "), "{}", run.err);
    for word in words {
        assert!(run.err.contains(word), "no {word:?} in: {}", run.err);
    }
    assert_eq!(names(folder), before, "strahl {args:?} left a file");
}

/// The same for a scene with this text.
#[track_caller]
fn scene_fails(text: &str, words: &[&str]) {
    let folder = folder_with_shells();
    fs::write(folder.path().join("scene.json"), text).unwrap();
    let mut words = words.to_vec();
    words.push("scene.json");
    fails(
        folder.path(),
        &["render", "scene.json", "-o", "out.png"],
        &words,
    );
}

/// The same for `render shells.nrrd` with these flags.
#[track_caller]
fn flags_fail(flags: &[&str], words: &[&str]) {
    let folder = folder_with_shells();
    let mut args = vec!["render", "shells.nrrd", "-o", "out.png"];
    args.extend(flags);
    fails(folder.path(), &args, words);
}

#[test]
fn a_missing_file() {
    let folder = tempfile::tempdir().unwrap();
    for args in [
        &["render", "none.nii", "-o", "out.png"][..],
        &["info", "none.nii"],
        &["convert", "none.nii", "out.nrrd"],
        &["scene", "show", "none.nii"],
    ] {
        fails(folder.path(), args, &["none.nii: no such file or folder"]);
    }
}

#[test]
fn a_folder_without_a_volume() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("notes")).unwrap();
    let args = ["render", "notes", "-o", "out.png"];
    fails(folder.path(), &args, &["notes: the folder is empty"]);
    fs::write(folder.path().join("notes/today.txt"), "nothing new").unwrap();
    let words = ["notes: ", "1 file and no DICOM file or picture"];
    fails(folder.path(), &args, &words);
    let small = Phantom::Shells.volume([4, 4, 4]).unwrap();
    for name in ["a.nii.gz", "b.nrrd"] {
        save(&small, &folder.path().join("notes"), name);
    }
    let words = ["there are 2 volume files: a.nii.gz, b.nrrd; name the one to read"];
    fails(folder.path(), &args, &words);
    // What lies deeper is no better choice than what lies here.
    let below = folder.path().join("notes/slices");
    fs::create_dir(&below).unwrap();
    fs::write(below.join("1.dcm"), [&[0; 128][..], b"DICM"].concat()).unwrap();
    fails(folder.path(), &args, &words);
    let two = ["render", "notes/a.nii.gz", "notes/b.nrrd", "-o", "out.png"];
    fails(folder.path(), &two, &["there are 2 volume files"]);
}

#[test]
fn files_that_are_no_volume() {
    let folder = tempfile::tempdir().unwrap();
    // The size of a NIfTI header and three axes; zeros where the magic has to be.
    let mut wrong_magic = [0; 400];
    wrong_magic[..2].copy_from_slice(&[0x5c, 1]);
    wrong_magic[40] = 3;
    for (name, bytes) in [
        ("empty.nii", &b""[..]),
        ("text.txt", b"Dear diary"),
        ("cut.nrrd", b"NRRD0004\ntype: uint8\n"),
        ("magic.nii", &wrong_magic),
        ("cut.png", b"\x89PNG\r\n\x1a\n\0\0"),
    ] {
        fs::write(folder.path().join(name), bytes).unwrap();
        fails(folder.path(), &["render", name, "-o", "out.png"], &[name]);
    }
    fails(folder.path(), &["info", "magic.nii"], &["magic is", "n+1"]);
}

#[test]
fn what_the_file_says_itself() {
    for (flags, words) in [
        (["--dims", "3,3,3"], ["dims is 3,3,3", "NRRD"]),
        (["--type", "u8"], ["type is u8", "NRRD"]),
        (["--spacing", "2"], ["spacing_mm is 2,2,2", "NRRD"]),
        (["--series", "2"], ["series is 2", "no series"]),
        (["--header-bytes", "7"], ["header_bytes is 7", "NRRD"]),
        (["--endian", "big"], ["endian is big", "NRRD"]),
        (["--time", "1"], ["time point is 1", "single volume"]),
    ] {
        flags_fail(&flags, &words);
    }
}

#[test]
fn labels_that_lie_elsewhere() {
    let folder = folder_with_shells();
    save(
        &Phantom::Shells.volume([16, 12, 9]).unwrap(),
        folder.path(),
        "other.nrrd",
    );
    // The samples of shells are rescaled, which labels are not.
    let elsewhere = strahl::glam::DAffine3::from_translation([90.0, 0.0, 0.0].into());
    let grid = strahl::volume::Grid::new([4; 3], elsewhere).unwrap();
    let ids = Volume::new(
        grid,
        strahl::volume::Samples::U8(vec![1; 64]),
        strahl::volume::Rescale::IDENTITY,
        strahl::volume::Metadata::default(),
    )
    .unwrap();
    save(&ids, folder.path(), "labels.nrrd");
    fs::write(
        folder.path().join("scene.json"),
        r#"{"volume": {"path": "shells.nrrd"}, "labels": {"path": "labels.nrrd"}}"#,
    )
    .unwrap();
    fails(
        folder.path(),
        &["render", "scene.json", "-o", "out.png"],
        &["scene.json: labels is on a grid of 4×4×4 voxels", "16×12×8"],
    );
    // A mask may lie on any grid, but has to have the labels.
    let mask = |mask: &str, words: &[&str]| {
        let scene =
            format!(r#"{{"volume": {{"path": "shells.nrrd"}}, "clips": [{{"mask": {mask}}}]}}"#);
        fs::write(folder.path().join("scene.json"), scene).unwrap();
        let args = ["render", "scene.json", "-o", "out.png"];
        fails(folder.path(), &args, words);
    };
    mask(
        r#"{"path": "labels.nrrd", "labels": [1, "liver"]}"#,
        &[
            r#"scene.json: clips[0].mask.labels[1] is "liver"; allowed: a label of "#,
            "labels.nrrd: 1",
        ],
    );
    mask(
        r#"{"path": "shells.nrrd", "labels": [1]}"#,
        &["shells.nrrd: label id at voxel [", "] is 0.2"],
    );
}

#[test]
fn transfer_functions() {
    let scene = |points: &str| {
        format!(
            r#"{{"volume": {{"path": "shells.nrrd"}}, "transfer_function": {{"points": {points}}}}}"#
        )
    };
    scene_fails(
        &scene(r#"[[0.5, 0], [0.2, 1]]"#),
        &["transfer_function.points[1]", "0.2", "allowed: "],
    );
    for word in ["NaN", "Infinity"] {
        scene_fails(
            &scene(&format!("[[0, 0], [{word}, 1]]")),
            &[
                "scene.json:1:",
                "transfer_function.points[1]",
                &format!("{word} is not allowed; write a finite number"),
            ],
        );
    }
    scene_fails(&scene(r#"[[0, 0], [1e999, 1]]"#), &["scene.json:1:"]);
    scene_fails(
        &scene(r#"[[0, 0], [1, 1.5]]"#),
        &["transfer_function.points[1].opacity", "1.5"],
    );
    flags_fail(&["--opacity", "0.2,7"], &["opacity", "7"]);
    flags_fail(&["--opacity", "much"], &["--opacity is much", "0 to 1"]);
    flags_fail(&["--window", "0"], &["window", "0"]);
    let folder = folder_with_shells();
    let args = "render shells.nrrd -o out.png --preset mr --window -5";
    let args: Vec<_> = args.split(' ').collect();
    let message = run(folder.path(), &args).err;
    assert_eq!(message.lines().count(), 1, "{message}");
    assert!(
        message.contains("transfer_function.window is -5"),
        "{message}"
    );
    flags_fail(&["--level", "nan"], &["level", "NaN"]);
}

#[test]
fn steps() {
    flags_fail(&["--step", "0"], &["--step is 0", "above 0"]);
    flags_fail(&["--step", "-1"], &["--step is -1", "above 0"]);
    flags_fail(
        &["--step-voxels", "nan"],
        &["--step-voxels is NaN", "above 0"],
    );
    flags_fail(&["--step", "1e-9"], &["step_mm", "1e-9", "allowed"]);
    scene_fails(
        r#"{"volume": {"path": "shells.nrrd"}, "step_mm": 0}"#,
        &["step_mm is 0; allowed: "],
    );
}

#[test]
fn sizes() {
    for size in ["0x100", "100x0", "100x65536", "99999999x1"] {
        flags_fail(&["--size", size], &["--size is ", size, "1 to 65535"]);
    }
    for size in ["100", "axb", "10x10x10", "-1x10"] {
        flags_fail(&[&format!("--size={size}")], &["--size is ", "1920x1080"]);
    }
    scene_fails(
        r#"{"volume": {"path": "shells.nrrd"}, "size": [0, 70000]}"#,
        &["size[0] is 0; allowed: 1 to 65535", "size[1] is 70000"],
    );
}

#[test]
fn places_that_cannot_be_written() {
    let folder = folder_with_shells();
    fs::write(folder.path().join("file"), "").unwrap();
    fs::create_dir(folder.path().join("folder.png")).unwrap();
    for (output, word) in [
        ("none/out.png", "there is no folder"),
        ("file/out.png", "file/out.png"),
        ("folder.png", "is a folder"),
        ("out.jpg", ".png or .exr"),
        ("out", ".png or .exr"),
    ] {
        fails(
            folder.path(),
            &["render", "shells.nrrd", "-o", output],
            &[output, word],
        );
    }
    for (output, word) in [
        ("none/out.nrrd", "there is no folder"),
        ("out.stl", "ends in one of"),
    ] {
        fails(folder.path(), &["convert", "shells.nrrd", output], &[word]);
    }
    fails(
        folder.path(),
        &["render", "shells.nrrd", "-o", "out.png", "--bits", "12"],
        &["out.png", "12", "8 and 16"],
    );
}

#[test]
fn scenes() {
    scene_fails("", &["scene.json"]);
    scene_fails("{", &["scene.json:1:", "not JSON"]);
    scene_fails(
        r#"{"volume": {"path": "shells.nrrd"}, "tresholdd": 3}"#,
        &["unknown key \"tresholdd\"", "did you mean \"threshold\"?"],
    );
    scene_fails(
        r#"{"volume": {"path": "shells.nrrd"}, "preset": "ct-bones"}"#,
        &["preset", "did you mean \"ct-bone\"?"],
    );
    scene_fails(r#"{"preset": "mr"}"#, &["volume is missing", "\"path\""]);
    scene_fails(
        r#"{"volume": {"phantom": "anatomie"}}"#,
        &["volume.phantom", "did you mean \"anatomy\"?"],
    );
    scene_fails(
        r#"{"volume": {"path": "shells.nrrd", "phantom": "shells"}}"#,
        &["volume", "one of the two"],
    );
    // Several at once.
    scene_fails(
        r#"{"volume": {"path": "shells.nrrd"}, "step_mm": -1, "camera": {"zoom": 0}, "size": [1, 0]}"#,
        &["step_mm is -1", "camera.zoom is 0", "size[1] is 0"],
    );
    let folder = tempfile::tempdir().unwrap();
    fs::write(
        folder.path().join("scene.json"),
        r#"{"volume": {"path": "none.nrrd"}}"#,
    )
    .unwrap();
    fails(
        folder.path(),
        &["render", "scene.json", "-o", "out.png"],
        &["none.nrrd: no such file"],
    );
}

#[test]
fn cameras_clips_and_colors() {
    flags_fail(&["--elevation", "95"], &["camera.elevation_deg", "95"]);
    flags_fail(&["--zoom", "-2"], &["camera.zoom", "-2"]);
    flags_fail(&["--focus", "1,2"], &["--focus is 1,2", "three numbers"]);
    flags_fail(&["--clip-plane", "0,0,0"], &["clips[0].plane.normal"]);
    flags_fail(&["--clip-plane", "up"], &["--clip-plane is up"]);
    flags_fail(&["--clip-box", "0,0,0,1,1"], &["--clip-box is 0,0,0,1,1"]);
    flags_fail(&["--background", "blue"], &["--background", "\"blue\""]);
    flags_fail(&["--exposure", "0"], &["display.exposure", "0"]);
    flags_fail(&["--depth"], &["PNG holds no depth", ".exr"]);
    flags_fail(&["--gamma", "-2"], &["display.gamma", "0.1 to 10"]);
    flags_fail(
        &["--white-point", "3"],
        &["display.white_point is 3", "reinhard-extended"],
    );
    flags_fail(
        &["--tone-map", "hable", "--white-point", "0"],
        &["display.white_point is 0", "0.001"],
    );
    flags_fail(
        &["--method", "average", "--shade", "blinn-phong"],
        &["shading.model", "unlit"],
    );
}

#[test]
fn reading_flags() {
    flags_fail(&["--time", "3"], &["shells.nrrd", "3"]);
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.raw"), [0; 8]).unwrap();
    let render = |flags: &[&str], words: &[&str]| {
        let mut args = vec!["render", "a.raw", "-o", "out.png"];
        args.extend(flags);
        fails(folder.path(), &args, words);
    };
    render(&[], &["a.raw", "help: give", "--dims", "--type"]);
    render(&["--dims", "2,2,1"], &["fits u16", "help: give", "--type"]);
    render(&["--dims", "3,3,3", "--type", "u8"], &["a.raw", "27", "8"]);
    let short = ["--dims", "3,1,1", "--type", "u8"];
    render(&short, &["a.raw", "help: ", "--header-bytes 5"]);
    render(&["--dims", "0,1,1"], &["--dims is 0,1,1", "at least 1"]);
    render(
        &["--dims", "2,2,2", "--type", "u12"],
        &["--type is u12", "u16"],
    );
    render(&["--spacing", "-1"], &["--spacing is -1", "above 0"]);
}

/// Two series in one folder are listed, and one has to be picked.
#[test]
fn several_dicom_series() {
    let Some(head) = shared_data("head-mr-dicom") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let series = folder.path().join("series");
    fs::create_dir(&series).unwrap();
    for name in names(&head).iter().take(4) {
        let bytes = fs::read(head.join(name)).unwrap();
        fs::write(series.join(name), &bytes).unwrap();
        fs::write(series.join(format!("other-{name}")), other_series(bytes)).unwrap();
    }
    let args = ["render", "series", "-o", "out.png"];
    fails(
        folder.path(),
        &args,
        &["series", "help: pick", "--series N", "1", "2"],
    );
    let args = [&args[..], &["--series", "2", "--size", "32x32"]].concat();
    run_well(folder.path(), &args);
    let args = ["render", "series", "-o", "again.png", "--series", "7"];
    fails(folder.path(), &args, &["series", "7"]);
}

/// The same slice with another SeriesInstanceUID, (0020,000E), in either little-endian syntax.
fn other_series(mut bytes: Vec<u8>) -> Vec<u8> {
    let tag = [0x20, 0x00, 0x0e, 0x00];
    let at = bytes.windows(4).position(|w| w == tag).unwrap() + 4;
    let length_at = if bytes[at..].starts_with(b"UI") {
        at + 2
    } else {
        at
    };
    let length = usize::from(u16::from_le_bytes([bytes[length_at], bytes[length_at + 1]]));
    let value = &mut bytes[at + 4..at + 4 + length];
    let digit = value.iter().rposition(u8::is_ascii_digit).unwrap();
    value[digit] = if value[digit] == b'9' { b'8' } else { b'9' };
    bytes
}
