//! Every example runs and leaves the pictures that it promises.

use super::*;

/// The program of an example; cargo builds it with the tests unless it is told to build one test only.
fn example(name: &str) -> Option<PathBuf> {
    let tests = std::env::current_exe().unwrap();
    let path = tests
        .parent()?
        .parent()?
        .join("examples")
        .join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    if path.exists() {
        return Some(path);
    }
    println!("skipped: the examples are not built (cargo test -p strahl builds them)");
    None
}

#[test]
fn examples_make_their_pictures() {
    let ladder = names(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples"));
    assert!(ladder.len() >= 7, "{ladder:?}");
    // Beside them lie graphs, which have tests of their own.
    for name in ladder.iter().filter_map(|file| file.strip_suffix(".rs")) {
        let Some(path) = example(name) else { return };
        let folder = folder_with_shells();
        let args: &[&str] = match name {
            "02_file_to_picture" => &["shells.nrrd", "02_file_to_picture.png"],
            "07_orbit" => &["2"],
            _ => &[],
        };
        let output = Command::new(path)
            .args(args)
            .current_dir(folder.path())
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{name}: {said}");
        let pictures = names(folder.path());
        let pictures = pictures.iter().filter(|made| made.ends_with(".png"));
        let expected = match name {
            "01_slice_in_the_terminal" => {
                assert!(output.stdout.len() > 1000);
                0
            }
            "07_orbit" => 2,
            _ => 1,
        };
        assert_eq!(pictures.count(), expected, "{name}");
    }
}

/// The scan that a scene in `examples/scenes` names first.
fn scan_of(text: &str) -> Option<&str> {
    text.split_whitespace()
        .find(|word| word.ends_with(".nii.gz"))
}

#[test]
fn example_scenes_draw_their_scans_without_a_note() {
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folder = project.join("examples/scenes");
    let scenes = names(&folder);
    assert!(scenes.len() >= 6, "{scenes:?}");
    for name in scenes {
        let path = folder.join(&name);
        let text = std::fs::read_to_string(&path).unwrap();
        let scan = scan_of(&text).unwrap_or_else(|| panic!("{name} names no scan"));
        let shared = std::env::var_os("STRAHL_SHARED");
        let shared = shared.map_or_else(|| project.join("../shared"), PathBuf::from);
        let scan = shared.join("data").join(scan);
        if !scan.exists() {
            println!("skipped: {} is not there", scan.display());
            continue;
        }
        let file = strahl::SceneFile::open(&path).unwrap().unwrap();
        let picture = strahl::Render::scene_file(file)
            .with_files(vec![scan])
            .size(64, 64)
            .picture()
            .unwrap();
        assert!(picture.notes.is_empty(), "{name}: {:?}", picture.notes);
        // The background is dark: what is drawn is lighter.
        let is_light = |pixel: &&[f32; 4]| pixel[0] + pixel[1] + pixel[2] > 0.1;
        let drawn = picture.image.pixels().iter().filter(is_light).count();
        assert!(drawn > 400, "{name}: {drawn} pixels");
    }
}
