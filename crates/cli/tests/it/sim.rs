//! `strahl sim` as its users meet it.

use crate::{names, run, run_well};

#[test]
fn a_phantom_is_drawn_and_counted() {
    let folder = tempfile::tempdir().unwrap();
    let args = [
        "sim",
        "run",
        "jaw",
        "--voxels",
        "32,32,16",
        "--brute-force",
        "-o",
        "jaw.png",
        "--row-changes",
        "rows.png",
        "--vcd",
        "jaw.vcd",
        "--diagram",
        "jaw.svg",
        "--report",
        "jaw.html",
        "--stats",
        "json",
        "--set",
        "memory.row_rule=thesis",
    ];
    let stats: serde_json::Value = serde_json::from_str(&run_well(folder.path(), &args)).unwrap();
    assert_eq!(stats["counters"]["samples"], 32 * 32 * 16);
    // Four blocks, which all stay open.
    assert_eq!(stats["counters"]["thesis_row_changes"], 4);
    assert_eq!(stats["is_complete"], true);
    assert_eq!(
        names(folder.path()),
        ["jaw.html", "jaw.png", "jaw.svg", "jaw.vcd", "rows.png"]
    );
    let vcd = std::fs::read_to_string(folder.path().join("jaw.vcd")).unwrap();
    assert!(
        vcd.contains("$var wire 10 ") && vcd.contains("sort_key"),
        "{vcd}"
    );
    let page = std::fs::read_to_string(folder.path().join("jaw.html")).unwrap();
    assert!(page.contains("data:image/png;base64,") && !page.contains("http-equiv"));
}

#[test]
fn the_printed_spec_can_be_run() {
    let folder = tempfile::tempdir().unwrap();
    let spec = run_well(folder.path(), &["sim", "spec", "--wide"]);
    std::fs::write(folder.path().join("mine.json"), spec).unwrap();
    let said = run_well(
        folder.path(),
        &[
            "sim",
            "run",
            "jaw",
            "--voxels",
            "16,16,8",
            "--spec",
            "mine.json",
        ],
    );
    assert!(said.contains("frames per second"), "{said}");
    let wires = run_well(folder.path(), &["sim", "spec", "--wires"]);
    assert!(
        wires.contains("address.x") && wires.contains(" 23 bit"),
        "{wires}"
    );
    let schema: serde_json::Value =
        serde_json::from_str(&run_well(folder.path(), &["sim", "spec", "--schema"])).unwrap();
    assert!(schema["properties"]["widths"].is_object());
}

#[test]
fn a_scene_gives_direction_and_opacity() {
    let folder = tempfile::tempdir().unwrap();
    let scene = r#"{ "volume": { "phantom": "shells", "dims": [32, 32, 32] }, "camera": { "view": "left" } }"#;
    std::fs::write(folder.path().join("scene.json"), scene).unwrap();
    let said = run_well(
        folder.path(),
        &["sim", "run", "scene.json", "-o", "shells.png"],
    );
    assert!(said.contains("shells"), "{said}");
}

/// Every extension is a field of the Spec.
#[test]
fn extensions_are_fields() {
    let folder = tempfile::tempdir().unwrap();
    // One triangle before everything, in millimeters: volumes are centered.
    let corners = "v -99 -99 -40\nv 99 -99 -40\nv 0 -99 99\nf 1 2 3\n";
    std::fs::write(folder.path().join("front.obj"), corners).unwrap();
    let perspective = "view.projection={\"perspective\":{\"angle_deg\":60}}";
    for set in [
        vec!["merge.boards=3", "merge.cut=z"],
        vec!["shadow=from-left"],
        vec!["merge.volumes=[{\"path\":\"shells\",\"at\":[40,0,0]}]"],
        vec![perspective, "view.slabs=3"],
        vec!["polygons.shape={\"sphere\":{\"centre\":[16,16,8],\"radius\":7}}"],
        vec![
            "polygons.shape={\"file\":{\"path\":\"front.obj\"}}",
            "polygons.opacity=0.5",
        ],
        vec![
            "bend={\"twist\":{\"deg_per_plane\":2}}",
            "optimisation.leaping=off",
        ],
    ] {
        let mut args = vec![
            "sim", "run", "jaw", "--voxels", "32,32,16", "--stats", "json",
        ];
        args.extend(set.iter().flat_map(|change| ["--set", change]));
        let stats: serde_json::Value =
            serde_json::from_str(&run_well(folder.path(), &args)).unwrap();
        assert_eq!(stats["is_complete"], true, "{set:?}");
        assert!(stats["counters"]["clocks"].as_u64() > Some(1000), "{set:?}");
    }
}

#[test]
fn a_tile_is_drawn_over_the_bus() {
    let folder = tempfile::tempdir().unwrap();
    let args = [
        "sim",
        "run",
        "jaw",
        "--voxels",
        "16,16,16",
        "--host-script",
        "tile.txt",
        "--tile",
        "1",
    ];
    run_well(folder.path(), &args);
    let read = run_well(folder.path(), &["sim", "script", "tile.txt"]);
    let first = read.lines().next().unwrap();
    assert!(
        first.starts_with("1 0x20000 ") && first.split(' ').count() == 68,
        "{read}"
    );
    assert!(read.contains("pipeline clocks"), "{read}");
    run_well(
        folder.path(),
        &["sim", "script", "tile.txt", "-o", "read.txt"],
    );
    let kept = std::fs::read_to_string(folder.path().join("read.txt")).unwrap();
    assert_eq!(kept, read);
    std::fs::write(folder.path().join("bad.txt"), "LB_CLK 10\nSWR 3\n").unwrap();
    let bad = run(folder.path(), &["sim", "script", "bad.txt"]);
    assert_eq!(bad.code, Some(1));
    assert!(
        bad.err.contains("bad.txt, line 2") && bad.err.contains("SWR_ACC"),
        "{}",
        bad.err
    );
}

#[test]
fn what_cannot_be_built_is_refused_with_the_bound() {
    let folder = tempfile::tempdir().unwrap();
    for (args, words) in [
        (
            vec!["sim", "run", "jaw", "--set", "queue.bundle=[0,8]"],
            ["queue.bundle", "1 to 64"],
        ),
        (
            vec!["sim", "run", "jaw", "--set", "widths.lenght=3"],
            ["lenght", "length"],
        ),
        (
            vec!["sim", "run", "jaw", "--set", "memory.rows=4"],
            ["memory.rows is 4", "32 rows"],
        ),
        (
            vec!["sim", "run", "jaw", "--set", "widths.length=6"],
            ["widths.length is 6", "8 bits"],
        ),
        (
            vec!["sim", "run", "jaw", "--set", "view.pixel=0.0001"],
            ["view.pixel", "pixels"],
        ),
        (
            vec!["sim", "run", "jaw", "--window", "9..3"],
            ["--window", "300..400"],
        ),
        (vec!["sim", "run", "nothing.nii"], ["nothing.nii", ""]),
        (
            vec!["sim", "run", "jaw", "--set", "view.slabs=3"],
            ["view.slabs is 3", "perspective"],
        ),
        (
            vec![
                "sim",
                "run",
                "jaw",
                "--set",
                "polygons.shape={\"file\":{\"path\":\"no.stl\"}}",
            ],
            ["cannot read no.stl", ""],
        ),
        (
            vec!["sim", "study", "bundel", "-o", "out"],
            ["bundel", "bundle"],
        ),
    ] {
        let run = run(folder.path(), &args);
        assert_eq!(run.code, Some(1), "{args:?}: {}", run.err);
        for word in words {
            assert!(run.err.contains(word), "{args:?}: {}", run.err);
        }
    }
}

#[test]
fn a_study_leaves_its_tables() {
    let folder = tempfile::tempdir().unwrap();
    run_well(folder.path(), &["sim", "study", "transfer", "-o", "out"]);
    assert_eq!(
        names(&folder.path().join("out")),
        [
            "report.html",
            "transfer-images.csv",
            "transfer-words.csv",
            "transfer.json"
        ]
    );
    assert!(run_well(folder.path(), &["sim", "study", "--list"]).contains("row-changes"));
}
