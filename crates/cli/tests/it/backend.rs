//! The choice of the renderer.

use super::*;

/// Without an adapter these calls have to fail with advice; with one they have to draw.
#[test]
fn the_graphics_processor_draws_or_says_what_to_install() {
    let folder = folder_with_shells();
    let args = [
        "render",
        "shells.nrrd",
        "-o",
        "gpu.png",
        "--size",
        "40x30",
        "--backend",
        "gpu",
    ];
    let drawn = run(folder.path(), &args);
    if strahl::gpu::adapters().is_empty() {
        assert_eq!(drawn.code, Some(1));
        assert!(drawn.err.contains("mesa-vulkan-drivers"), "{}", drawn.err);
        assert_eq!(names(folder.path()), ["shells.nrrd"]);
        assert!(std::env::var("CI").is_ok_and(|ci| ci != "true") || std::env::var("CI").is_err());
        println!("skipped: no graphics adapter");
        return;
    }
    assert_eq!(drawn.code, Some(0), "{}", drawn.err);
    let stats = run_well(
        folder.path(),
        &[&args[..], &["--stats", "json", "-q"]].concat(),
    );
    let stats: serde_json::Value = serde_json::from_str(&stats).unwrap();
    assert_eq!(stats["backend"], "gpu");
    assert!(stats["seconds"]["upload"].as_f64().is_some());
    let adapter = stats["adapter"].as_str().unwrap();
    let list = run_well(folder.path(), &["info", "--adapters"]);
    assert!(list.contains(adapter), "{list}");
    // A software renderer is not used in silence.
    let note =
        format!("note: {adapter} is a software renderer: it draws on the CPU; --backend cpu");
    let is_software = adapter.ends_with("software)");
    assert_eq!(drawn.err.contains(&note), is_software, "{}", drawn.err);
}

/// Mesa complains about a missing runtime folder on stderr, for every adapter that it looks at.
#[test]
fn drivers_find_a_runtime_folder() {
    let folder = tempfile::tempdir().unwrap();
    let listed = program(folder.path(), &["info", "--adapters"])
        .env_remove("XDG_RUNTIME_DIR")
        .output()
        .unwrap();
    let err = String::from_utf8(listed.stderr).unwrap();
    assert!(!err.contains("XDG_RUNTIME_DIR"), "{err}");
}

/// Without its Vulkan driver, Mesa offers OpenGL only, which cannot draw into the textures that are needed.
#[cfg(target_os = "linux")]
#[test]
fn an_adapter_that_cannot_draw_is_refused_in_plain_words() {
    let folder = folder_with_shells();
    let args = "render shells.nrrd -o gpu.png --size 40x30 --backend gpu";
    let args: Vec<_> = args.split(' ').collect();
    let drawn = program(folder.path(), &args)
        .env("VK_DRIVER_FILES", "/none")
        .env("VK_ICD_FILENAMES", "/none")
        .output()
        .unwrap();
    let err = String::from_utf8(drawn.stderr).unwrap();
    if drawn.status.success() {
        println!("skipped: OpenGL can draw here");
        return;
    }
    assert!(!err.contains("Validation"), "{err}");
    assert!(err.contains("help: draw with --backend cpu"), "{err}");
}

#[test]
fn what_cannot_be_chosen_is_refused() {
    let folder = folder_with_shells();
    let call = |more: &[&str]| {
        let args = [
            &["render", "shells.nrrd", "-o", "out.png", "--size", "8x8"],
            more,
        ]
        .concat();
        run(folder.path(), &args)
    };
    let wrong = call(&["--adapter", "any"]);
    assert_eq!(wrong.code, Some(1));
    assert!(wrong.err.contains("needs --backend gpu"), "{}", wrong.err);
    assert_eq!(call(&["--backend", "vulkan"]).code, Some(2));
    let unknown = call(&["--backend", "gpu", "--adapter", "no such adapter"]);
    assert_eq!(unknown.code, Some(1));
    assert_eq!(names(folder.path()), ["shells.nrrd"]);
    // It always draws, and says so where it is not on a GPU.
    let auto = call(&["--backend", "auto"]);
    assert_eq!(auto.code, Some(0), "{}", auto.err);
}
