//! Bytes from anyone: every run ends within its memory and time, in a picture or a message, and reads nothing that it may
//! not. What the libraries refuse is tested there; this is what only the whole program can show.

use super::*;
use std::fs;

/// Runs the program in 4 GiB of address space; how it ended.
fn run_limited(folder: &Path, args: &[&str]) -> Run {
    let output = Command::new("sh")
        .args(["-c", "ulimit -v 4194304; exec \"$0\" \"$@\""])
        .arg(env!("CARGO_BIN_EXE_strahl"))
        .args(args)
        .current_dir(folder)
        .stdin(Stdio::null())
        .output()
        .unwrap();
    Run {
        code: output.status.code(),
        out: String::from_utf8_lossy(&output.stdout).into_owned(),
        err: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

/// A run that has to end in a message with `words`.
#[track_caller]
fn refused(folder: &Path, args: &[&str], words: &[&str]) -> Run {
    let run = run_limited(folder, args);
    assert_eq!(run.code, Some(1), "strahl {args:?}: {}{}", run.out, run.err);
    for word in words {
        assert!(run.err.contains(word), "no {word:?} in: {}", run.err);
    }
    run
}

/// A PNG of one pixel with texts, packed or not.
fn picture(texts: &[(&str, &str, bool)]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().unwrap();
    for (keyword, text, is_packed) in texts {
        let mut chunk = png::text_metadata::ITXtChunk::new(*keyword, *text);
        if *is_packed {
            chunk.compressed = true;
            chunk.compress_text().unwrap();
        }
        writer.write_text_chunk(&chunk).unwrap();
    }
    writer.write_image_data(&[1, 2, 3]).unwrap();
    writer.finish().unwrap();
    bytes
}

fn scene_in_picture(scene: &str) -> Vec<u8> {
    picture(&[
        ("Software", "Strahl 0.0.1", false),
        ("strahl:scene", scene, false),
    ])
}

#[test]
fn a_scene_in_a_picture_is_unpacked_no_further_than_a_scene_is_long() {
    let folder = tempfile::tempdir().unwrap();
    let long = " ".repeat(40 << 20);
    fs::write(
        folder.path().join("long.png"),
        picture(&[("strahl:scene", &long, true)]),
    )
    .unwrap();
    let words = ["long.png", "longer than 16777216 bytes"];
    refused(
        folder.path(),
        &["render", "long.png", "-o", "out.png"],
        &words,
    );
}

#[test]
fn what_commands_a_terminal_does_not_reach_it() {
    let folder = tempfile::tempdir().unwrap();
    let scene = r#"{ "volume": { "path": "\u001b]0;owned\u0007\u009b2Jx" } }"#;
    let bytes = picture(&[
        ("Software", "a\x1b[31mb", false),
        ("strahl:scene", scene, false),
    ]);
    fs::write(folder.path().join("a.png"), bytes).unwrap();
    let run = refused(
        folder.path(),
        &["render", "a.png", "-o", "out.png"],
        &[r"\u{1b}]0;owned\u{7}"],
    );
    let is_harmless = |c: char| !c.is_control() || matches!(c, '\n' | '\t');
    assert!(run.err.chars().all(is_harmless), "{:?}", run.err);
    assert!(run.err.contains(r"a\u{1b}[31mb"), "{}", run.err);
}

/// What unpacks to more than it may is refused by every command that reads.
#[test]
fn files_that_unpack_to_more_than_the_memory_are_refused() {
    let folder = folder_with_shells();
    for args in [
        &["info", "shells.nrrd"][..],
        &["convert", "shells.nrrd", "out.nii"],
        &["render", "shells.nrrd", "-o", "out.png", "--size", "8x8"],
    ] {
        let words = [
            "shells.nrrd: reading takes 6144 bytes of memory or more; the limit is 4096 bytes",
            "help: --max-memory BYTES allows more",
        ];
        refused(
            folder.path(),
            &[args, &["--max-memory", "4k"]].concat(),
            &words,
        );
    }
    assert_eq!(names(folder.path()), ["shells.nrrd"]);
    run_well(
        folder.path(),
        &["info", "shells.nrrd", "--max-memory", "7k"],
    );
}

#[test]
fn pictures_beyond_all_memory_are_refused_with_the_number() {
    let folder = tempfile::tempdir().unwrap();
    let scene = r#"{ "volume": { "phantom": "tree", "dims": [8, 8, 8] }, "size": [65535, 65535] }"#;
    fs::write(folder.path().join("a.json"), scene).unwrap();
    let args = ["render", "a.json", "-o", "out.png"];
    refused(
        folder.path(),
        &args,
        &["128.0 GiB", "65535 × 65535", "help: --max-memory"],
    );
    let force = [&args[..], &["--force"]].concat();
    refused(
        folder.path(),
        &force,
        &["no memory for the 137434759200 bytes"],
    );
}

#[test]
fn what_would_take_hours_is_refused_with_what_to_change() {
    let folder = folder_with_shells();
    let slow = [
        "render",
        "shells.nrrd",
        "-o",
        "out.png",
        "--step",
        "0.00005",
        "--size",
        "4000x4000",
    ];
    refused(
        folder.path(),
        &slow,
        &[
            "about",
            "the limit is 30 minutes",
            "a longer step",
            "--force",
        ],
    );
    let args = [&slow[..], &["--max-time", "80"]].concat();
    refused(folder.path(), &args, &["the limit is 80 seconds"]);
    let args = [
        "render",
        "shells.nrrd",
        "-o",
        "out.png",
        "--max-memory",
        "1k",
    ];
    refused(
        folder.path(),
        &args,
        &["the limit is 1024 bytes", "--max-memory"],
    );
    for (flag, value, words) in [
        ("--max-memory", "much", "such as 500M"),
        ("--max-time", "-3", "above 0"),
    ] {
        let flag = format!("{flag}={value}");
        let args = ["render", "shells.nrrd", "-o", "out.png", &flag];
        refused(folder.path(), &args, &[words]);
    }
    assert_eq!(names(folder.path()), ["shells.nrrd"]);
    let args = [
        "render",
        "shells.nrrd",
        "-o",
        "out.png",
        "--size",
        "16x12",
        "--max-memory",
        "1G",
        "--max-time",
        "1e3",
    ];
    run_well(folder.path(), &args);
}

#[test]
fn a_run_ends_at_its_limit_wherever_it_is() {
    let folder = folder_with_shells();
    // A loop whose turns no estimate knows.
    let module = "fn classify(value: f32, position: vec3f) -> Surface {
        var x = value;
        for (var i = 0; i < 1000000; i++) { x = sin(x); }
        return table(x);
    }";
    fs::write(folder.path().join("slow.wgsl"), module).unwrap();
    let scene = r#"{ "volume": { "path": "shells.nrrd" }, "functions": { "classify": { "module": "slow.wgsl" } } }"#;
    fs::write(folder.path().join("slow.json"), scene).unwrap();
    let args = [
        "render",
        "slow.json",
        "-o",
        "out.png",
        "--size",
        "400x400",
        "--max-time",
        "1.5",
    ];
    refused(folder.path(), &args, &["not finished after 1.5 seconds"]);
    assert_eq!(
        names(folder.path()),
        ["shells.nrrd", "slow.json", "slow.wgsl"]
    );
}

/// Labels on the grid of the shells: 1 in one half, 2 in the other.
fn halves() -> strahl::Volume {
    let shells = shells();
    let [nx, ny, nz] = shells.grid().dims();
    let id = |i: usize| if i % nx < nx / 2 { 1 } else { 2 };
    let ids = strahl::volume::Samples::U8((0..nx * ny * nz).map(id).collect());
    let rescale = strahl::volume::Rescale::IDENTITY;
    let metadata = strahl::volume::Metadata::default();
    strahl::Volume::new(*shells.grid(), ids, rescale, metadata).unwrap()
}

#[test]
fn a_picture_that_is_cut_off_is_said_to_be() {
    let folder = folder_with_shells();
    let path = folder.path();
    run_well(
        path,
        &[
            "render",
            "shells.nrrd",
            "-o",
            "whole.png",
            "--size",
            "200x200",
        ],
    );
    let whole = fs::read(path.join("whole.png")).unwrap();
    let pixels = whole.windows(4).position(|kind| kind == b"IDAT").unwrap();
    fs::write(path.join("cut.png"), &whole[..pixels + 100]).unwrap();
    let again = |name: &str| {
        let run = run(path, &["render", name, "-o", "again.png"]);
        assert_eq!(run.code, Some(0), "{}", run.err);
        assert!(fs::read(path.join("again.png")).unwrap() == whole);
        run.err
    };
    let note = "cut.png is cut off: its last pixels are missing; its scene is whole";
    assert_eq!(again("cut.png").matches(note).count(), 1);
    assert!(!again("whole.png").contains("cut off"));
    let check = run(path, &["scene", "check", "cut.png"]);
    assert!(
        check.err.contains(note) && check.out.contains("can be drawn"),
        "{}",
        check.err
    );
    // Cut within the scene, it is no scene.
    fs::write(path.join("cut.png"), &whole[..200]).unwrap();
    refused(
        path,
        &["render", "cut.png", "-o", "again.png"],
        &["cut.png", "cut off"],
    );
}

#[test]
fn the_scene_of_a_picture_reads_beside_it_and_nowhere_else() {
    let folder = folder_with_shells();
    let path = folder.path();
    fs::create_dir(path.join("pictures")).unwrap();
    let above = r#"{ "volume": { "path": "../shells.nrrd" }, "size": [16, 12] }"#;
    fs::write(path.join("pictures/above.png"), scene_in_picture(above)).unwrap();
    let args = ["render", "pictures/above.png", "-o", "out.png"];
    let words = ["../shells.nrrd: lies outside of", "help: --confine"];
    refused(path, &args, &words);
    run_well(path, &[&args[..], &["--confine", "."]].concat());

    let beside = r#"{ "volume": { "path": "shells.nrrd" }, "size": [16, 12] }"#;
    fs::write(path.join("beside.png"), scene_in_picture(beside)).unwrap();
    run_well(path, &["render", "beside.png", "-o", "out.png"]);
    // Whatever is named beside the picture may lie anywhere.
    run_well(
        path,
        &[
            "render",
            "pictures/above.png",
            "shells.nrrd",
            "-o",
            "out.png",
        ],
    );

    // Also labels, with the table beside them; what else lies there is not read.
    let elsewhere = tempfile::tempdir().unwrap();
    let labels = elsewhere.path().join("labels.nrrd");
    save(&halves(), elsewhere.path(), "labels.nrrd");
    fs::write(
        elsewhere.path().join("labels.csv"),
        "id,name\n1,west\n2,east\n",
    )
    .unwrap();
    save(&halves(), elsewhere.path(), "other.nrrd");
    let labels = labels.to_str().unwrap();
    let named = ["--labels", labels, "--only", "east"];
    let run = run(
        path,
        &[&["render", "beside.png", "-o", "out.png"], &named[..]].concat(),
    );
    assert_eq!(run.code, Some(0), "{}", run.err);
    assert!(!run.err.contains("no segment"), "{}", run.err);
    let other = elsewhere.path().join("other.nrrd");
    let mask = format!(
        r#"{{ "volume": {{ "path": "shells.nrrd" }}, "clips": [{{ "mask": {{ "path": {other:?} }} }}] }}"#
    );
    fs::write(path.join("mask.png"), scene_in_picture(&mask)).unwrap();
    let args = [&["render", "mask.png", "-o", "out.png"], &named[..2]].concat();
    refused(path, &args, &["other.nrrd: lies outside of"]);
    let table = format!(
        r#"{{ "volume": {{ "path": "shells.nrrd" }}, "labels": {{ "table": {other:?} }} }}"#
    );
    fs::write(path.join("table.png"), scene_in_picture(&table)).unwrap();
    refused(
        path,
        &["render", "table.png", "-o", "out.png"],
        &["lies outside of"],
    );

    // Of what lies elsewhere nothing is told, whether it is there or not.
    fs::write(path.join("secret"), "the secret").unwrap();
    let graph = |key: &str| format!(r#""graph": {{ "strahl_graph": 1, {key} }}"#);
    for scene in [
        r#"{ "volume": { "path": "/etc/passwd" } }"#.to_owned(),
        r#"{ "volume": { "path": "../none" } }"#.to_owned(),
        r#"{ "volume": { "phantom": "tree" }, "objects": [{ "mesh": "../secret" }] }"#.to_owned(),
        r#"{ "volume": { "phantom": "tree" }, "labels": { "path": "../secret" } }"#.to_owned(),
        r#"{ "volume": { "phantom": "tree" }, "functions": { "classify": { "module": "../secret.wgsl" } } }"#.to_owned(),
        format!(r#"{{ "volume": {{ "phantom": "tree" }}, {} }}"#, graph(r#""file": "../secret""#)),
        format!(r#"{{ "volume": {{ "phantom": "tree" }}, {} }}"#, graph(r#""patterns": ["../"]"#)),
        format!(
            r#"{{ "volume": {{ "phantom": "tree" }}, {} }}"#,
            graph(r#""nodes": { "t": { "texture": { "file": "../secret" } } }, "roots": { "color": "t" }"#)
        ),
    ] {
        fs::write(path.join("pictures/reads.png"), scene_in_picture(&scene)).unwrap();
        let args = ["render", "pictures/reads.png", "-o", "out.png"];
        let run = refused(path, &args, &["lies outside of"]);
        assert!(!run.err.contains("the secret"), "{}", run.err);
    }
    // Scenes may be confined, too.
    fs::write(
        path.join("scene.json"),
        r#"{ "volume": { "path": "/etc/passwd" } }"#,
    )
    .unwrap();
    let args = ["render", "scene.json", "-o", "out.png", "--confine", "."];
    refused(path, &args, &["/etc/passwd: lies outside of"]);
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_are_refused_at_once() {
    let folder = folder_with_shells();
    let path = folder.path();
    let made = Command::new("mkfifo").arg(path.join("pipe")).status();
    assert!(made.unwrap().success());
    fs::write(
        path.join("scene.json"),
        r#"{ "volume": { "path": "pipe" } }"#,
    )
    .unwrap();
    for args in [
        &["info", "pipe"][..],
        &["render", "pipe", "-o", "out.png"],
        &["render", "scene.json", "-o", "out.png"],
        &["render", "shells.nrrd", "--graph", "pipe", "-o", "out.png"],
        &["shader", "check", "pipe"],
        &["info", "/dev/zero"],
        &["scene", "check", "/dev/zero"],
    ] {
        refused(path, args, &["only regular files are read"]);
    }
}

#[cfg(unix)]
#[test]
fn names_that_are_no_text_are_read() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let folder = folder_with_shells();
    let name = OsStr::from_bytes(b"sch\xe4del.nrrd");
    fs::rename(folder.path().join("shells.nrrd"), folder.path().join(name)).unwrap();
    for args in [
        &["info"][..],
        &["render", "-o", "out.png", "--size", "16x12"],
    ] {
        let run = program(folder.path(), args).arg(name).output().unwrap();
        let said = String::from_utf8_lossy(&run.stderr);
        assert_eq!(run.status.code(), Some(0), "{said}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_or_closed_stderr_ends_nothing() {
    let folder = folder_with_shells();
    for redirected in ["2>/dev/full", "2>&-", ">&- 2>&-"] {
        let call = format!(
            "\"$0\" render shells.nrrd -o out.png --size 16x12 {redirected}; code=$?; rm -f out.png; exit $code"
        );
        let status = Command::new("sh")
            .args(["-c", &call, env!("CARGO_BIN_EXE_strahl")])
            .current_dir(folder.path())
            .status()
            .unwrap();
        assert_eq!(status.code(), Some(0), "{redirected}");
    }
}

#[test]
fn more_threads_than_there_can_be_are_refused() {
    let folder = folder_with_shells();
    let args = [
        "render",
        "shells.nrrd",
        "-o",
        "out.png",
        "--threads",
        "10000",
    ];
    refused(folder.path(), &args, &["10000", "at most 1024"]);
}

/// The scene in a picture.
fn recipe(path: &Path) -> Option<String> {
    strahl::Recipe::of_file(path)
        .unwrap()
        .map(|recipe| recipe.scene)
}

#[test]
fn pictures_tell_no_whole_paths_and_as_little_as_is_wanted() {
    let folder = folder_with_shells();
    let path = folder.path();
    fs::create_dir(path.join("doe-jane")).unwrap();
    fs::copy(path.join("shells.nrrd"), path.join("doe-jane/scan.nrrd")).unwrap();
    let out = path.join("out.png");
    let render = |volume: &str, flags: &[&str]| {
        run_well(
            path,
            &[
                &["render", volume, "-o", "out.png", "--size", "16x12"][..],
                flags,
            ]
            .concat(),
        );
        recipe(&out)
    };
    let told = render("doe-jane/scan.nrrd", &[]).unwrap();
    assert!(told.contains("\"doe-jane/scan.nrrd\""), "{told}");
    let told = render("doe-jane/scan.nrrd", &["--anonymous"]).unwrap();
    assert!(
        told.contains("\"data-1.nrrd\"") && !told.contains("doe") && !told.contains("scan"),
        "{told}"
    );
    assert_eq!(render("doe-jane/scan.nrrd", &["--no-recipe"]), None);
    // From another branch of the file system: as in /tmp and /dev/shm.
    if let Ok(elsewhere) = tempfile::tempdir_in("/dev/shm") {
        fs::copy(path.join("shells.nrrd"), elsewhere.path().join("far.nrrd")).unwrap();
        let told = render(elsewhere.path().join("far.nrrd").to_str().unwrap(), &[]).unwrap();
        assert!(
            told.contains("\"far.nrrd\"") && !told.contains("/dev"),
            "{told}"
        );
        // What is not told is said, unless nothing was to be told.
        let far = elsewhere.path().join("far.nrrd");
        let args = [
            "render",
            far.to_str().unwrap(),
            "-o",
            "out.png",
            "--size",
            "16x12",
        ];
        let said = |more: &[&str]| run(path, &[&args[..], more].concat()).err;
        let note = "the picture keeps only the name of far.nrrd";
        assert_eq!(said(&[]).matches(note).count(), 1, "{}", said(&[]));
        assert!(said(&[]).contains("name the volume after the picture"));
        for more in [&["--anonymous"][..], &["--no-recipe"]] {
            assert!(
                !said(more).contains("keeps only the name"),
                "{}",
                said(more)
            );
        }
        run_well(path, &args);
        let lost = run(path, &["render", "out.png", "-o", "again.png"]);
        assert_eq!(lost.code, Some(1), "{}", lost.err);
        let why =
            "out.png carries a scene, not the data: it names far.nrrd, and there is no such file";
        assert!(lost.err.contains(why), "{}", lost.err);
        assert!(
            lost.err.contains("`out.png FOLDER/far.nrrd`"),
            "{}",
            lost.err
        );
        let again = [
            "render",
            "out.png",
            far.to_str().unwrap(),
            "-o",
            "again.png",
        ];
        run_well(path, &again);
        let bytes = |name: &str| fs::read(path.join(name)).unwrap();
        assert!(bytes("out.png") == bytes("again.png"));
    }
}

#[test]
fn names_and_dates_leave_with_anonymous() {
    let folder = folder_with_shells();
    let path = folder.path();
    let mut bytes = b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nspace: RAS\nspace directions: (1,0,0) (0,1,0) (0,0,1)\ncontent: Doe, Jane\nstudy date:=20260101\n\n".to_vec();
    bytes.extend([1, 2, 3, 4, 5, 6, 7, 8]);
    fs::write(path.join("a.nrrd"), bytes).unwrap();
    assert!(run_well(path, &["info", "a.nrrd"]).contains("Doe"));
    for json in [&[][..], &["--json"]] {
        let out = run_well(
            path,
            &[&["info", "a.nrrd", "--anonymous"][..], json].concat(),
        );
        assert!(!out.contains("Doe") && !out.contains("20260101"), "{out}");
    }
    for name in ["b.nrrd", "b.nii", "b.mha"] {
        run_well(path, &["convert", "a.nrrd", name, "--anonymous", "--quiet"]);
        let text = String::from_utf8_lossy(&fs::read(path.join(name)).unwrap()).into_owned();
        assert!(
            !text.contains("Doe") && !text.contains("20260101"),
            "{text}"
        );
    }
}

#[test]
fn a_header_never_names_samples_that_are_not_its_own() {
    let folder = folder_with_shells();
    let path = folder.path();
    fs::write(path.join("a.mhd"), "an old header").unwrap();
    fs::write(path.join("a.raw"), "old samples").unwrap();
    run_well(path, &["convert", "shells.nrrd", "a.mhd", "--uncompressed"]);
    assert!(run_well(path, &["info", "a.mhd"]).contains("16 × 12 × 8"));
}

/// The collection of hostile files beside the checkout, as its README wants each to end.
#[test]
fn hostile_files_end_in_a_message_or_a_picture() {
    let Some(path) = shared_cases("hostile") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| path.join(name).to_str().unwrap().to_owned();
    for (args, words) in [
        (
            &["info", "dicom-jp2-false-siz-1Mx1M.dcm"][..],
            "1000000×1000000",
        ),
        (&["info", "bzip2-10GiB.raw.bz2"], "unpack the file first"),
        (
            &["render", "picture-itxt-60MiB.png"],
            "longer than 16777216 bytes",
        ),
        (&["info", "npy-first-samples-DICM.npy"], ""),
        (&["render", "scene-65535.json"], "GiB"),
        (&["render", "picture-65535.png"], "GiB"),
        (&["render", "scene-1000-volumes.json"], "at most 8 volumes"),
        (&["render", "scene-parent-chain-1600.json"], ""),
        (
            &["graph", "check", "graph-includes/g_chain0.graph.json"],
            "more than 1000 files",
        ),
        (
            &["shader", "check", "wgsl-stack-not.wgsl"],
            "wgsl-stack-not.wgsl:2:",
        ),
        (&["render", "picture-graph-stack-overflow.png"], "nests"),
        (
            &["shader", "check", "wgsl-call-tree.wgsl"],
            "calls of functions",
        ),
        (
            &["shader", "check", "wgsl-barrier.wgsl"],
            "workgroupBarrier",
        ),
        (&["render", "scene-for-obj.json"], ""),
        (
            &["render", "picture-terminal-escape.png"],
            r"\u{1b}]0;owned",
        ),
    ] {
        let (before, name) = args.split_at(args.len() - 1);
        let file = at(name[0]);
        let mut call: Vec<&str> = before.to_vec();
        call.push(&file);
        if before == ["render"] {
            call.extend(["-o", "out.png"]);
        }
        let run = run_limited(folder.path(), &call);
        let code = if words.is_empty() { 0 } else { 1 };
        assert_eq!(run.code, Some(code), "strahl {args:?}: {}", run.err);
        assert!(run.err.contains(words), "no {words:?} in: {}", run.err);
    }
}

/// Two bytes of JSON become a thousand of memory.
#[test]
fn a_small_picture_with_millions_of_objects_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (key, element) in [
        ("objects", "{}"),
        ("segments", r#"{"of":1}"#),
        ("lights", r#"{"type":"head"}"#),
    ] {
        let text = format!(
            r#"{{"{key}":[{}{element}]}}"#,
            format!("{element},").repeat(1_000_000)
        );
        let bytes = picture(&[
            ("Software", "Strahl 0.0.1", false),
            ("strahl:scene", &text, true),
        ]);
        fs::write(folder.path().join("many.png"), bytes).unwrap();
        fs::write(folder.path().join("many.json"), &text).unwrap();
        for name in ["many.png", "many.json"] {
            let words = [name, "objects and lists; at most 100000 can be read"];
            refused(folder.path(), &["render", name, "-o", "out.png"], &words);
        }
    }
    let nodes: Vec<String> = (0..200_000)
        .map(|n| format!(r#""n{n}":{{"wgsl":""}}"#))
        .collect();
    let text = format!(r#"{{"strahl_graph":1,"nodes":{{{}}}}}"#, nodes.join(","));
    fs::write(folder.path().join("many.graph.json"), text).unwrap();
    let args = ["graph", "check", "many.graph.json"];
    refused(
        folder.path(),
        &args,
        &["objects and lists; at most 100000 can be read"],
    );
}

#[cfg(unix)]
#[test]
fn nothing_is_written_over_what_is_read() {
    let folder = folder_with_shells();
    let path = folder.path();
    let before = fs::read(path.join("shells.nrrd")).unwrap();
    for link in ["link.png", "link.npy"] {
        std::os::unix::fs::symlink("shells.nrrd", path.join(link)).unwrap();
    }
    fs::write(path.join("slice.png"), picture(&[])).unwrap();
    for args in [
        &["render", "shells.nrrd", "-o", "link.png", "--size", "8x8"][..],
        &[
            "render",
            "slice.png",
            "--labels",
            "shells.nrrd",
            "-o",
            "link.png",
        ],
        &["render", "slice.png", "-o", "slice.png"],
        &["convert", "shells.nrrd", "link.npy"],
        &["convert", "shells.nrrd", "shells.nrrd"],
    ] {
        refused(path, args, &["which is read: it would be lost"]);
    }
    assert!(fs::read(path.join("shells.nrrd")).unwrap() == before);
    // A picture with its scene may be drawn again in its place.
    run_well(
        path,
        &["render", "shells.nrrd", "-o", "a.png", "--size", "8x8"],
    );
    run_well(path, &["render", "a.png", "-o", "a.png", "--azimuth", "30"]);
}

#[cfg(unix)]
#[test]
fn a_pipe_is_no_place_for_a_picture() {
    let folder = folder_with_shells();
    let made = Command::new("mkfifo")
        .arg(folder.path().join("out.png"))
        .status();
    assert!(made.unwrap().success());
    let args = ["render", "shells.nrrd", "-o", "out.png", "--size", "8x8"];
    refused(folder.path(), &args, &["out.png", "is a pipe"]);
}

#[test]
fn phantoms_beyond_the_memory_are_not_computed() {
    let folder = tempfile::tempdir().unwrap();
    let text = r#"{ "volume": { "phantom": "ramp", "dims": [900, 900, 900] } }"#;
    fs::write(folder.path().join("scene.json"), text).unwrap();
    let args = [
        "render",
        "scene.json",
        "-o",
        "out.png",
        "--max-memory",
        "100M",
    ];
    refused(
        folder.path(),
        &args,
        &["2916000000 bytes", "--max-memory BYTES allows more"],
    );
}

/// The sum of a million steps is not what it has got to after the last one that is allowed.
#[test]
fn colors_that_are_no_light_are_noted() {
    let folder = folder_with_shells();
    let draw = |wgsl: &str| {
        let text = format!(
            r##"{{ "volume": {{ "path": "shells.nrrd" }}, "size": [8, 8], "background": "#336699", "graph": {{
                "nodes": {{ "c": {{ "wgsl": "fn f() -> vec4f {{ var x = -1.0; {wgsl} }}" }} }}, "roots": {{ "color": "c" }} }} }}"##
        );
        fs::write(folder.path().join("scene.json"), text).unwrap();
        run(folder.path(), &["render", "scene.json", "-o", "out.png"]).err
    };
    let note = "64 pixels are no light";
    for wgsl in ["return vec4f(sqrt(x));", "return vec4f(x, x, x, 1.0);"] {
        assert!(draw(wgsl).contains(note), "{}", draw(wgsl));
    }
    assert!(!draw("return vec4f(-x);").contains(note));
}
