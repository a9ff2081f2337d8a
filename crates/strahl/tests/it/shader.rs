//! `strahl shader`.

use super::*;
use std::fs;

#[test]
fn the_library_is_listed_and_printed() {
    let folder = tempfile::tempdir().unwrap();
    let list = run_well(folder.path(), &["shader", "list"]);
    assert!(list.contains("fn classify(value: f32, position: vec3f) -> Surface"));
    assert!(list.contains("  blinn_phong "));
    let json = run_well(folder.path(), &["shader", "list", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let slots = json.as_array().unwrap();
    let illuminate = slots.iter().find(|s| s["slot"] == "illuminate").unwrap();
    let phong = illuminate["modules"]
        .as_array()
        .unwrap()
        .iter()
        .find(|m| m["name"] == "phong")
        .unwrap();
    assert_eq!(phong["parameters"][2]["name"], "shininess");
    assert_eq!(phong["parameters"][2]["default"][0], 32.0);

    let text = run_well(folder.path(), &["shader", "show", "classify/table"]);
    assert!(text.contains("fn classify("));
    let wrong = run(folder.path(), &["shader", "show", "blin_phong"]);
    assert_eq!(wrong.code, Some(1));
    assert!(
        wrong.err.contains("did you mean illuminate/blinn_phong?"),
        "{}",
        wrong.err
    );
}

#[test]
fn modules_are_checked_all_of_them() {
    let folder = tempfile::tempdir().unwrap();
    // What the documentation shows is right.
    let page = include_str!("../../../../docs/shader-functions.md");
    let example = page.split("```wgsl\n").nth(1).unwrap();
    let example = example.split("```").next().unwrap();
    fs::write(folder.path().join("fade.wgsl"), example).unwrap();
    let said = run_well(folder.path(), &["shader", "check", "fade.wgsl"]);
    assert_eq!(
        said,
        "fade.wgsl: a function for the slot classify; takes from_mm: f32, over_mm: f32; needs place_mm, table\n"
    );

    let wrong = example.replace("-> Surface", "-> vec4f");
    fs::write(folder.path().join("wrong.wgsl"), wrong).unwrap();
    let both = run(
        folder.path(),
        &["shader", "check", "wrong.wgsl", "fade.wgsl", "gone.wgsl"],
    );
    assert_eq!(both.code, Some(1));
    assert!(both.out.starts_with("fade.wgsl: "), "{}", both.out);
    assert!(both.err.contains("wrong.wgsl:"), "{}", both.err);
    assert!(both.err.contains("gone.wgsl"), "{}", both.err);
    assert!(both.err.contains("2 of 3 modules"), "{}", both.err);
}
