//! The program as its users meet it.

mod backend;
mod bad_input;
mod commands;
mod flags;
mod graph;
#[cfg(unix)]
mod hostile;
mod pictures;
mod shader;
mod sim;
#[cfg(unix)]
mod stopping;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use strahl::volume::write::{NewMemoryFiles, WriteOptions, write};
use strahl::{Phantom, Volume};

/// The program, about to run in `folder`.
fn program(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_strahl"));
    command.args(args).current_dir(folder).stdin(Stdio::null());
    command
}

/// What the program said and how it ended.
struct Run {
    code: Option<i32>,
    out: String,
    err: String,
}

fn run(folder: &Path, args: &[&str]) -> Run {
    let output = program(folder, args).output().unwrap();
    Run {
        code: output.status.code(),
        out: String::from_utf8(output.stdout).unwrap(),
        err: String::from_utf8(output.stderr).unwrap(),
    }
}

/// Runs the program, which has to succeed; what it printed on stdout.
#[track_caller]
fn run_well(folder: &Path, args: &[&str]) -> String {
    let run = run(folder, args);
    assert_eq!(run.code, Some(0), "strahl {args:?}: {}", run.err);
    run.out
}

/// The names in a folder, sorted.
fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

fn shells() -> Volume {
    Phantom::Shells.volume([16, 12, 8]).unwrap()
}

/// A new folder with the volume `shells.nrrd` in it.
fn folder_with_shells() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    save(&shells(), folder.path(), "shells.nrrd");
    folder
}

fn save(volume: &Volume, folder: &Path, name: &str) {
    let mut files = NewMemoryFiles::default();
    write(name, volume, &WriteOptions::default(), &mut files).unwrap();
    for (name, bytes) in files.0 {
        std::fs::write(folder.join(name), bytes).unwrap();
    }
}

/// The data beside the checkout; `None`, and a line that says so, where it is missing.
fn shared_data(name: &str) -> Option<PathBuf> {
    shared("data", name)
}

/// The same for cases that somebody has found.
#[cfg(unix)]
fn shared_cases(name: &str) -> Option<PathBuf> {
    shared("cases", name)
}

fn shared(kind: &str, name: &str) -> Option<PathBuf> {
    let root = std::env::var_os("STRAHL_SHARED").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared"),
        PathBuf::from,
    );
    let path = root.join(kind).join(name);
    if path.exists() {
        return Some(path);
    }
    println!("skipped: no {name} in ../shared/{kind}");
    None
}
