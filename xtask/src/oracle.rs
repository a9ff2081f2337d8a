//! `cargo xtask oracle`: an independent witness for readers and writers.
//!
//! Python libraries that others wrote read the same files, and write files in every variant they
//! know; the scripts in `xtask/oracle` compare. They run in a virtual environment of their own
//! under `target`.

use crate::command::{cargo, output, succeeds};
use anyhow::{Result, ensure};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs the comparison, or with `time` the measurement; whether all agrees.
pub fn run(root: &Path, time: bool, only: Option<&str>, verbose: bool) -> Result<bool> {
    let python = environment(root)?;
    ensure!(
        succeeds(cargo(root).args(["build", "--release", "--package", "strahl"]))?,
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

/// The Python of the virtual environment, made on the first run and when the list changes.
fn environment(root: &Path) -> Result<PathBuf> {
    let folder = target_folder(root)?.join("oracle-venv");
    let wanted = std::fs::read_to_string(root.join("xtask/oracle/requirements.txt"))?;
    let stamp = folder.join("requirements.txt");
    let python = folder.join(if cfg!(windows) {
        "Scripts/python.exe"
    } else {
        "bin/python"
    });
    if std::fs::read_to_string(&stamp).is_ok_and(|installed| installed == wanted) {
        return Ok(python);
    }
    ensure!(
        succeeds(Command::new("python3").args(["-m", "venv"]).arg(&folder))?,
        "cannot make a Python environment: install Python 3.11 or newer with its venv module \
         (Debian: python3-venv)"
    );
    println!("installing the Python libraries into {}", folder.display());
    ensure!(
        succeeds(
            Command::new(&python)
                .current_dir(root)
                .args(["-m", "pip", "install", "--quiet", "--requirement"])
                .arg("xtask/oracle/requirements.txt"),
        )?,
        "pip could not install xtask/oracle/requirements.txt"
    );
    std::fs::write(stamp, wanted)?;
    Ok(python)
}

fn target_folder(root: &Path) -> Result<PathBuf> {
    let metadata = output(cargo(root).args(["metadata", "--no-deps", "--format-version", "1"]))?;
    let metadata: serde_json::Value = serde_json::from_str(&metadata)?;
    Ok(metadata["target_directory"]
        .as_str()
        .map_or_else(|| root.join("target"), PathBuf::from))
}

/// The scans beside the checkout; the script says so if they are missing.
fn shared_data(root: &Path) -> PathBuf {
    std::env::var_os("STRAHL_SHARED")
        .map_or_else(|| root.join("../shared"), PathBuf::from)
        .join("data")
}
