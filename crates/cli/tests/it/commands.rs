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
        assert!(lines <= 56, "{lines} lines: {short}");
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
fn a_picture_behind_a_volume_is_no_slice_of_it() {
    let folder = folder_with_shells();
    let path = folder.path();
    run_well(
        path,
        &["render", "shells.nrrd", "-o", "pic.png", "--size", "16x16"],
    );
    let drawn = std::fs::read(path.join("pic.png")).unwrap();
    let run_both = |more: &[&str]| {
        let run = run(
            path,
            &[&["render", "shells.nrrd", "pic.png"], more].concat(),
        );
        assert_eq!(std::fs::read(path.join("pic.png")).unwrap(), drawn);
        run
    };
    let without = run_both(&[]);
    assert_eq!(without.code, Some(2));
    for part in ["did you mean '-o pic.png'?", "'pic.png shells.nrrd -o …'"] {
        assert!(without.err.contains(part), "{}", without.err);
    }
    let with = run_both(&["-o", "out.png"]);
    assert_eq!(with.code, Some(1));
    for part in [
        "a picture with a scene",
        "`pic.png shells.nrrd`",
        "`-o pic.png`",
    ] {
        assert!(with.err.contains(part), "{}", with.err);
    }
    // Without a scene it is a picture all the same.
    let args = ["render", "pic.png", "-o", "plain.png", "--no-recipe"];
    run_well(path, &args);
    let plain = run(
        path,
        &["render", "shells.nrrd", "plain.png", "-o", "out.png"],
    );
    assert!(
        plain.err.contains("shells.nrrd is no picture"),
        "{}",
        plain.err
    );
    assert!(!path.join("out.png").exists());
}

#[test]
fn a_preset_is_found_by_a_part_of_its_name() {
    let folder = folder_with_shells();
    let path = folder.path();
    for args in [
        &["render", "shells.nrrd", "-o", "a.png", "--preset", "bone"][..],
        &["presets", "bone"],
    ] {
        let run = run(path, args);
        assert_eq!(run.code, Some(2));
        let tip = "a similar value exists: 'ct-bone'";
        assert!(run.err.contains(tip), "{}", run.err);
    }
    // Both spellings of gray are one look. (The scene in the picture has the word that was typed.)
    let pixels = |name: &str, flags: [&str; 2]| {
        let args = ["render", "shells.nrrd", "--size", "16x16", "-o", name];
        run_well(path, &[&args[..], &flags].concat());
        let bytes = std::fs::read(path.join(name)).unwrap();
        let at = bytes.windows(4).position(|kind| kind == b"IDAT").unwrap();
        bytes[at..].to_vec()
    };
    for (flag, gray, grey) in [
        ("--preset", "gray", "grey"),
        ("--color-map", "inverted-gray", "inverted-grey"),
    ] {
        assert!(pixels("a.png", [flag, gray]) == pixels("b.png", [flag, grey]));
    }
    std::fs::write(
        path.join("gray.json"),
        r#"{ "volume": { "path": "shells.nrrd" }, "preset": "gray", "size": [8, 8] }"#,
    )
    .unwrap();
    let shown = run_well(path, &["scene", "show", "gray.json"]);
    assert_eq!(json(&shown)["preset"], "grey");
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

/// Half of the voxels are 0, in one bin of the histogram with other small numbers: no value between is invented.
#[test]
fn info_invents_no_quantiles_of_floats() {
    let folder = tempfile::tempdir().unwrap();
    let header = "NRRD0004\ntype: float\ndimension: 3\nsizes: 10 1 1\nencoding: ascii\n\n0 0 0 0 0 0 0.5 2.5 2.5 ";
    for (last, expected) in [
        ("563.25", "1%: 0   25%: 0   50%: 0   75%: 2.5   99%: 563.25"),
        ("nan", "1%: 0   25%: 0   50%: 0   75%: 0.5   99%: 2.5"),
    ] {
        fs::write(folder.path().join("plain.nrrd"), format!("{header}{last}")).unwrap();
        let plain = run_well(folder.path(), &["info", "plain.nrrd"]);
        assert!(plain.contains(expected), "{plain}");
    }
}

#[test]
fn names_of_labels_that_a_format_loses_are_told() {
    let folder = folder_with_labels();
    let said = |to: &str| run(folder.path(), &["convert", "organs.seg.nrrd", to]).err;
    let names = "the names and colors of 2 labels are not in the file";
    for (to, expected) in [
        (
            "o.nii.gz",
            "note: the names and colors of 2 labels are not in the file; .nrrd keeps them",
        ),
        (
            "o.mha",
            "are not in the file, nor does it say that its numbers are object ids",
        ),
    ] {
        assert!(said(to).contains(expected), "{}", said(to));
    }
    assert!(!said("o.nrrd").contains(names), "{}", said("o.nrrd"));
}

/// A label volume of 4 voxels of 0.5 × 2 × 3 mm: ids 0, 7, 7, 300.
fn folder_with_labels() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let header = "NRRD0004\ntype: ushort\ndimension: 3\nsizes: 4 1 1\nencoding: ascii\nspace: RAS\n\
        space directions: (0.5,0,0) (0,2,0) (0,0,3)\n";
    let keys = "Segment0_Name:=liver\nSegment0_LabelValue:=7\nSegment0_Color:=1 0.5 0\n\
        Segment1_Name:=spleen\nSegment1_LabelValue:=9\n";
    for (name, keys) in [("organs.seg.nrrd", keys), ("plain.nrrd", "")] {
        let text = format!("{header}{keys}\n0 7 7 300\n");
        fs::write(folder.path().join(name), text).unwrap();
    }
    let table = "id,name,color\n300,heart,#0000ff\n";
    fs::write(folder.path().join("heart.csv"), table).unwrap();
    folder
}

#[test]
fn info_lists_labels_with_their_sizes() {
    let folder = folder_with_labels();
    let info = |args: &[&str]| run_well(folder.path(), &[&["info"], args].concat());
    let text = info(&["organs.seg.nrrd"]);
    // 3 mm³ a voxel.
    let expected = "
    label        voxels          ml  color    name
        0             1       0.003
        7             2       0.006  #ff8000  liver
        9             0           0           spleen
      300             1       0.003
";
    assert!(text.ends_with(expected), "{text}");
    assert!(
        text.contains("values       3 ids from 0 to 300\n"),
        "{text}"
    );
    assert!(
        !text.contains("quantiles") && !text.contains("histogram"),
        "{text}"
    );
    let json = json(&info(&["organs.seg.nrrd", "--json"]));
    assert_eq!(json["quantiles"], Value::Null);
    assert_eq!(json["labels"].as_array().unwrap().len(), 4);
    let liver = &json["labels"][1];
    assert_eq!((&liver["id"], &liver["name"]), (&7.into(), &"liver".into()));
    assert_eq!(
        (&liver["color"], &liver["voxels"]),
        (&"#ff8000".into(), &2.into())
    );
    assert!((liver["ml"].as_f64().unwrap() - 0.006).abs() < 1e-12);

    // The file itself does not say that its numbers are ids.
    assert!(info(&["plain.nrrd"]).contains("quantiles"));
    assert!(info(&["plain.nrrd", "--as-labels"]).contains("3 ids from 0 to 300"));
    let text = info(&["plain.nrrd", "--label-table", "heart.csv"]);
    assert!(text.contains("0.003  #0000ff  heart\n"), "{text}");
    fs::rename(
        folder.path().join("heart.csv"),
        folder.path().join("plain.csv"),
    )
    .unwrap();
    let text = info(&["plain.nrrd", "--as-labels"]);
    assert!(text.contains("#0000ff  heart\n"), "{text}");
    assert!(
        text.contains("note: names and colors of labels are those of plain.csv"),
        "{text}"
    );
    let run = run(
        folder.path(),
        &["info", "plain.nrrd", "--label-table", "plain.nrrd"],
    );
    assert_eq!(run.code, Some(1));
    assert!(
        run.err
            .contains("plain.nrrd: the label table is of no known format"),
        "{}",
        run.err
    );
}

#[test]
fn info_of_real_labels_counts_what_numpy_counts() {
    let Some(path) = shared_data("abdomen-labels.nii.gz") else {
        return;
    };
    let out = run_well(Path::new("."), &["info", path.to_str().unwrap(), "--json"]);
    let json = json(&out);
    let liver = &json["labels"][5];
    assert_eq!(
        (&liver["name"], &liver["color"]),
        (&"liver".into(), &"#00ffff".into())
    );
    assert_eq!(liver["voxels"], 38_634);
    // 27 mm³ a voxel.
    assert!((liver["ml"].as_f64().unwrap() - 1043.118).abs() < 1e-6);
    assert_eq!(json["labels"][0]["voxels"], 259_435);
}

#[test]
fn notes_go_to_stderr_and_can_be_turned_off() {
    let folder = folder_with_shells();
    let args = ["render", "shells.nrrd", "-o", "out.png", "--size", "20x10"];
    let loud = run(folder.path(), &args);
    assert_eq!(loud.out, "");
    assert!(
        loud.err.starts_with("wrote out.png: 20 × 10 pixels"),
        "{}",
        loud.err
    );
    let quiet = run(folder.path(), &[&args[..], &["--quiet"]].concat());
    assert_eq!((quiet.out.as_str(), quiet.err.as_str()), ("", ""));
}

#[test]
fn stats_add_up() {
    let folder = folder_with_shells();
    let out = run_well(
        folder.path(),
        &[
            "render",
            "shells.nrrd",
            "-o",
            "out.png",
            "--size",
            "40x30",
            "--stats",
            "json",
            "--threads",
            "2",
            "-q",
        ],
    );
    let stats = json(&out);
    let count = |key: &str| stats[key].as_u64().unwrap_or_else(|| panic!("{key}"));
    assert_eq!((count("width"), count("height")), (40, 30));
    assert_eq!(count("rays"), 1200);
    assert_eq!(count("threads"), 2);
    assert_eq!(stats["picture"], "out.png");
    assert_eq!(stats["method"], "emission-absorption");
    assert!(count("rays_in_volume") > 100 && count("rays_in_volume") <= 1200);
    assert!(count("samples_visible") > 0);
    assert!(count("samples_visible") <= count("samples"));
    assert!(count("samples") + count("points_skipped") <= count("lattice_points"));
    let seconds = stats["seconds"].as_object().unwrap();
    let total = seconds["total"].as_f64().unwrap();
    let parts = ["read", "bricks", "prepare", "draw", "write"];
    let sum: f64 = parts
        .iter()
        .map(|part| seconds[*part].as_f64().unwrap())
        .sum();
    assert!(sum > 0.0 && sum <= total, "{sum} of {total} s");
}

#[test]
fn demo_needs_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let args = ["demo", "--dims", "48,60,76", "--size", "64x64"];
    let run = run(folder.path(), &args);
    assert_eq!(run.code, Some(0), "{}", run.err);
    assert!(run.err.contains("wrote strahl-demo.png"), "{}", run.err);
    assert_eq!(names(folder.path()), ["strahl-demo.png"]);
}

#[test]
fn volumes_keep_their_values_in_every_format() {
    let folder = folder_with_shells();
    let original = shells();
    for name in ["a.nii", "a.nii.gz", "a.nrrd", "a.mha", "a.mhd", "a.npy"] {
        run_well(folder.path(), &["convert", "shells.nrrd", name, "-q"]);
        let read = strahl::load(folder.path().join(name), &Default::default()).unwrap();
        assert_eq!(read.volume.grid().dims(), [16, 12, 8], "{name}");
        for (x, y, z) in [(0, 0, 0), (8, 6, 4), (11, 3, 7)] {
            let error = read.volume.value(x, y, z) - original.value(x, y, z);
            assert!(error.abs() < 1e-6, "{name}: {error}");
        }
    }
    assert!(names(folder.path()).contains(&"a.zraw".to_owned()));
    run_well(
        folder.path(),
        &["convert", "shells.nrrd", "b.mhd", "--uncompressed"],
    );
    assert_eq!(
        fs::metadata(folder.path().join("b.raw")).unwrap().len(),
        16 * 12 * 8 * 4
    );
}

#[test]
fn all_components_are_converted() {
    let folder = tempfile::tempdir().unwrap();
    // Two voxels of red, green and blue.
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
    write(
        "odd.json",
        r#"{"volume": {"path": "shells.nrrd"}, "threshold": 3}"#,
    );
    let odd = self::run(folder.path(), &["scene", "check", "odd.json"]);
    let note = "note: odd.json: threshold changes nothing: the method is emission-absorption";
    assert!(odd.err.contains(note), "{}", odd.err);
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

#[test]
fn presets_that_do_not_fit_are_noted() {
    let folder = folder_with_shells();
    let said = |flags: &[&str]| {
        let args = ["render", "shells.nrrd", "-o", "p.png", "--size", "8x8"];
        run(folder.path(), &[&args[..], flags].concat()).err
    };
    let in_hounsfield =
        "the preset ct-bone counts in HU, and the values, 0 to 1, do not look like HU";
    let replaced = "the window replaces the points of the preset ct-bone";
    let unnamed = "no segment has a name that the preset anatomy looks for";
    let bone = said(&["--preset", "ct-bone"]);
    assert!(
        bone.contains(in_hounsfield) && !bone.contains(replaced),
        "{bone}"
    );
    let windowed = said(&["--preset", "ct-bone", "--window", "0.5"]);
    assert!(
        windowed.contains(replaced) && !windowed.contains(in_hounsfield),
        "{windowed}"
    );
    let anatomy = said(&["--preset", "anatomy", "--layers", "2"]);
    assert!(anatomy.contains(unnamed), "{anatomy}");
    for flags in [
        &["--preset", "solid"][..],
        &["--preset", "atlas", "--layers", "2"],
        &[],
    ] {
        let other = said(flags);
        for note in [in_hounsfield, replaced, unnamed] {
            assert!(!other.contains(note), "{other}");
        }
    }
    let last = bone.lines().last().unwrap_or_default();
    assert!(
        last.starts_with("wrote p.png") && last.ends_with(", preset ct-bone"),
        "{last}"
    );
}
