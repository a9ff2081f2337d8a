//! Ctrl-C, and a request to end.

use super::*;
use std::fs;
use std::io::{BufRead, BufReader};

#[test]
fn an_interrupt_leaves_no_half_written_file() {
    stopped_by("-INT");
}

/// As batch systems and `docker stop` do it.
#[test]
fn a_request_to_end_leaves_no_half_written_file() {
    stopped_by("-TERM");
}

/// Draws something long until the first line of progress, then sends the signal.
fn stopped_by(signal: &str) {
    let folder = folder_with_shells();
    fs::write(folder.path().join("out.png"), "the old picture").unwrap();
    let args = [
        "render",
        "shells.nrrd",
        "-o",
        "out.png",
        "--size",
        "3000x3000",
        "--step",
        "0.001",
        "--force",
        "--threads",
        "1",
        "--method",
        "average",
    ];
    let mut child = program(folder.path(), &args)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    let line = lines.next().unwrap().unwrap();
    assert!(line.starts_with("drawing"), "{line}");
    let unfinished = |names: Vec<String>| names.iter().any(|name| name.ends_with(".part"));
    assert!(unfinished(names(folder.path())), "nothing was begun");
    let kill = Command::new("kill")
        .args([signal, &child.id().to_string()])
        .status()
        .unwrap();
    assert!(kill.success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(names(folder.path()), ["out.png", "shells.nrrd"]);
    let old = fs::read_to_string(folder.path().join("out.png")).unwrap();
    assert_eq!(old, "the old picture");
}
