//! Exit codes, help, and what each command prints.

use super::*;
use serde_json::Value;
use std::fs;

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn wrong_usage_is_exit_code_2() {
    let folder = folder_with_shells();
    for args in [
        &[][..],
        &["draw"],
        &["render", "shells.nrrd"],
        &["render", "-o", "out.png"],
        &["render", "shells.nrrd", "-o", "out.png", "--sise", "3x3"],
        &["render", "shells.nrrd", "-o", "out.png", "--method", "mop"],
        &["render", "shells.nrrd", "-o", "out.png", "--zoom", "near"],
        &["render", "shells.nrrd", "-o", "out.png", "--preset", "none"],
        &["convert", "shells.nrrd"],
        &["scene"],
        &["demo", "skull"],
    ] {
        let run = run(folder.path(), args);
        assert_eq!(run.code, Some(2), "strahl {args:?}: {}", run.err);
        assert!(run.err.contains("--help"), "{}", run.err);
        assert_eq!(names(folder.path()), ["shells.nrrd"]);
    }
}

/// Every command has examples, and every example is a call that the flags know.
#[test]
fn help_has_examples_that_are_right() {
    let folder = tempfile::tempdir().unwrap();
    let mut examples = 0;
    for command in [
        "render",
        "demo",
        "info",
        "convert",
        "presets",
        "completions",
        "man",
        "scene schema",
        "scene check",
        "scene show",
        "shader list",
        "shader show",
        "shader check",
        "shader wgsl",
        "shader cost",
    ] {
        let mut args: Vec<&str> = command.split(' ').collect();
        args.push("--help");
        let help = run_well(folder.path(), &args);
        let (_, list) = help.split_once("\nExamples:\n").expect(command);
        let lines = list.lines().take_while(|line| !line.is_empty());
        for line in lines {
            assert!(
                line.trim().starts_with(&format!("strahl {command}")),
                "{line}"
            );
            let words = line.split_whitespace().skip(1);
            // Nothing of it exists here: it fails, but not as wrong usage.
            let call: Vec<&str> = words.take_while(|word| *word != ">").collect();
            if call[0] != "demo" {
                let run = run(folder.path(), &call);
                assert_ne!(run.code, Some(2), "{line}: {}", run.err);
            }
            examples += 1;
        }
    }
    assert!(examples > 20, "{examples}");
    let help = run_well(folder.path(), &["scene", "--help"]);
    assert!(help.contains("schema") && help.contains("check"), "{help}");
}

/// The usual flags fit on a screen; `--help` has all of them.
#[test]
fn short_help_fits_on_a_screen() {
    let folder = tempfile::tempdir().unwrap();
    for command in ["render", "demo"] {
        let short = run_well(folder.path(), &[command, "-h"]);
        let lines = short.lines().count();
        assert!(lines <= 48, "{lines} lines: {short}");
        assert!(!short.contains("--white-point"), "{short}");
        let long = run_well(folder.path(), &[command, "--help"]);
        assert!(long.contains("--white-point"), "{long}");
    }
}

#[test]
fn a_picture_without_o_is_suggested_as_output() {
    let folder = folder_with_shells();
    let suggestion = "did you mean '-o out.png'?";
    let with = run(folder.path(), &["render", "shells.nrrd", "out.png"]);
    assert_eq!(with.code, Some(2));
    assert!(with.err.contains(suggestion), "{}", with.err);
    // A picture alone is an input.
    let alone = run(folder.path(), &["render", "out.png"]);
    assert_eq!(alone.code, Some(2));
    assert!(!alone.err.contains("did you mean"), "{}", alone.err);
}

#[test]
fn manual_pages_are_written_for_every_command() {
    let folder = tempfile::tempdir().unwrap();
    run_well(folder.path(), &["man", "pages"]);
    let page = |name: &str| fs::read_to_string(folder.path().join("pages").join(name)).unwrap();
    assert!(
        page("strahl.1").contains("strahl\\-render(1)"),
        "{}",
        page("strahl.1")
    );
    let render = page("strahl-render.1");
    assert!(
        render.starts_with(".ie") || render.contains(".TH"),
        "{render}"
    );
    assert!(render.contains("white\\-point"), "{render}");
    assert!(page("strahl-scene-show.1").contains(".SH SYNOPSIS"));
}

/// Quantiles of whole numbers are whole.
#[test]
fn info_knows_whole_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let text =
        "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 5 2 1\nencoding: ascii\n\n0 0 0 0 0 3 3 3 3 7";
    fs::write(folder.path().join("plain.nrrd"), text).unwrap();
    let plain = run_well(folder.path(), &["info", "plain.nrrd"]);
    let expected = "1%: 0   25%: 0   50%: 0   75%: 3   99%: 7";
    assert!(plain.contains(expected), "{plain}");
}

/// A label volume of 4 voxels of 0.5 × 2 × 3 mm: ids 0, 7, 7, 300.
fn folder_with_labels() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let header = "NRRD0004\ntype: uint8\ndimension: 4\nspace: right-anterior-superior\n\
        sizes: 3 2 1 1\nkinds: RGB-color domain domain domain\n\
        space directions: none (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n\n";
    let file = [header.as_bytes(), &[255, 10, 20, 0, 40, 50]].concat();
    fs::write(folder.path().join("rgb.nrrd"), file).unwrap();
    for name in ["a.nii", "a.mha"] {
        let converted = run(folder.path(), &["convert", "rgb.nrrd", name]);
        assert_eq!(converted.code, Some(0), "{}", converted.err);
        assert!(
            converted.err.contains("of 3 components"),
            "{}",
            converted.err
        );
        assert!(!converted.err.contains("note"), "{}", converted.err);
        for (component, values) in [(0, [255.0, 0.0]), (1, [10.0, 40.0]), (2, [20.0, 50.0])] {
            let options = strahl::volume::read::ReadOptions {
                component: Some(component),
                ..Default::default()
            };
            let read = strahl::load(folder.path().join(name), &options)
                .unwrap()
                .volume;
            assert_eq!([read.value(0, 0, 0), read.value(1, 0, 0)], values, "{name}");
        }
    }
    let refused = run(folder.path(), &["convert", "rgb.nrrd", "a.npy"]);
    assert_eq!(refused.code, Some(1));
    let said = "write .nrrd, .nii, .mha or .mhd, or one of the components";
    assert!(refused.err.contains(said), "{}", refused.err);
    assert!(refused.err.contains("--component K"), "{}", refused.err);
    for (choice, value) in [("2", 20.0), ("luminance", 63.0)] {
        let args = ["convert", "rgb.nrrd", "a.npy", "--component", choice];
        run_well(folder.path(), &args);
        let read = strahl::load(folder.path().join("a.npy"), &Default::default()).unwrap();
        assert_eq!(read.volume.value(0, 0, 0), value, "{choice}");
    }
}

#[test]
fn what_a_file_without_header_loses_is_told() {
    let folder = folder_with_shells();
    let raw = run(folder.path(), &["convert", "shells.nrrd", "a.raw"]);
    let (_, flags) = raw.err.split_once("read it with ").unwrap();
    let flags = flags.lines().next().unwrap();
    assert!(
        flags.starts_with("--dims 16,12,8 --type f32 --spacing "),
        "{flags}"
    );
    let mut args = vec!["convert", "a.raw", "b.nrrd"];
    args.extend(flags.split(' '));
    run_well(folder.path(), &args);
    let npy = run(folder.path(), &["convert", "shells.nrrd", "a.npy"]);
    assert!(npy.err.contains("read it with --spacing "), "{}", npy.err);
    let nifti = run(folder.path(), &["convert", "shells.nrrd", "a.nii"]);
    assert!(!nifti.err.contains("note"), "{}", nifti.err);
}

#[test]
fn presets_are_listed_and_printed() {
    let folder = folder_with_shells();
    let list = run_well(folder.path(), &["presets"]);
    let parsed = json(&run_well(folder.path(), &["presets", "--json"]));
    assert_eq!(parsed.as_array().unwrap().len(), list.lines().count());
    for (line, entry) in list.lines().zip(parsed.as_array().unwrap()) {
        let name = entry["name"].as_str().unwrap();
        assert!(line.starts_with(name), "{line}");
        // What is printed is a scene that can be drawn with a volume.
        let text = run_well(folder.path(), &["presets", name]);
        fs::write(folder.path().join("preset.json"), text).unwrap();
        let args = [
            "render",
            "preset.json",
            "shells.nrrd",
            "-o",
            "out.png",
            "--size",
            "8x8",
        ];
        run_well(folder.path(), &args);
    }
}

#[test]
fn completions_name_the_commands() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = run_well(folder.path(), &["completions", shell]);
        assert!(
            script.contains("--color-map") || script.contains("color-map"),
            "{shell}"
        );
    }
}

#[test]
fn scenes_are_checked_all_of_them() {
    let folder = folder_with_shells();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("good.json", r#"{"volume": {"path": "shells.nrrd"}}"#);
    write("bare.json", r#"{"preset": "mr"}"#);
    write(
        "bad.json",
        r#"{"volume": {"path": "shells.nrrd"}, "step_mm": 0, "size": [0, 1]}"#,
    );
    let out = run_well(folder.path(), &["scene", "check", "good.json", "bare.json"]);
    assert!(out.contains("good.json: can be drawn"), "{out}");
    assert!(out.contains("bare.json: every key is known"), "{out}");
    let run = run(
        folder.path(),
        &["scene", "check", "bad.json", "good.json", "shells.nrrd"],
    );
    assert_eq!(run.code, Some(1));
    assert!(run.out.contains("good.json: can be drawn"));
    for word in [
        "bad.json: ",
        "size[0] is 0",
        "step_mm is 0",
        "shells.nrrd: not a scene",
    ] {
        assert!(run.err.contains(word), "no {word:?} in {}", run.err);
    }
}

#[test]
fn the_schema_is_the_one_checked_in() {
    let folder = tempfile::tempdir().unwrap();
    let printed = run_well(folder.path(), &["scene", "schema"]);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/scene.schema.json");
    assert!(
        printed == fs::read_to_string(path).unwrap(),
        "print it again: CONTRIBUTING.md"
    );
}
