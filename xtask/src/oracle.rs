//! `cargo xtask oracle`: an independent witness for readers and writers.
//!
//! Python libraries that others wrote read the same files, and write files in every variant they
//! know; the scripts in `xtask/oracle` compare. They run in a virtual environment of their own
//! under `target`.

use crate::command::{cargo, succeeds};
use crate::python::{environment, shared_data, target_folder};
use anyhow::{Result, ensure};
use std::path::Path;
use std::process::Command;

/// Runs the comparison, or with `time` the measurement; whether all agrees.
pub fn run(root: &Path, time: bool, only: Option<&str>, verbose: bool) -> Result<bool> {
    let python = environment(root, "oracle-venv", "xtask/oracle/requirements.txt")?;
    ensure!(
        succeeds(cargo(root).args(["build", "--release", "--package", "strahl-cli"]))?,
        "strahl does not build"
    );
    if time {
        let example = [
            "build",
            "--release",
            "--package",
            "strahl",
            "--example",
            "time_reading",
        ];
        ensure!(
            succeeds(cargo(root).args(example))?,
            "time_reading does not build"
        );
    }
    let mut command = Command::new(python);
    command
        .current_dir(root)
        .arg("xtask/oracle/oracle.py")
        .arg("--strahl")
        .arg(target_folder(root)?.join("release/strahl"))
        .arg("--data")
        .arg(shared_data(root))
        .arg("--scratch")
        .arg(target_folder(root)?.join("oracle"));
    if time {
        let program = target_folder(root)?.join("release/examples/time_reading");
        command.arg("--time").arg(program);
    }
    if verbose {
        command.arg("--verbose");
    }
    if let Some(only) = only {
        command.args(["--only", only]);
    }
    succeeds(&mut command)
}
