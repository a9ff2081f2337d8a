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
