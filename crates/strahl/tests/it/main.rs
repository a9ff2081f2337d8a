//! The library as its users meet it.

mod examples;
mod graph;
mod graph_formulas;
mod library;
mod made_again;
mod session;
mod slicing;

use std::path::{Path, PathBuf};
use std::process::Command;
use strahl::volume::write::{NewMemoryFiles, WriteOptions, write};
use strahl::{Phantom, Volume};

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
