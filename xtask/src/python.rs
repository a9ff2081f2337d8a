//! Virtual environments of Python, for libraries that others wrote.

use crate::command::{cargo, output, succeeds};
use anyhow::{Result, ensure};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The Python of the virtual environment `target/NAME`, made on the first run and when the list `requirements`
/// (a file, as seen from `root`) changes.
///
/// # Errors
/// There is no Python with venv, or a library cannot be installed.
pub fn environment(root: &Path, name: &str, requirements: &str) -> Result<PathBuf> {
    let folder = target_folder(root)?.join(name);
    let wanted = std::fs::read_to_string(root.join(requirements))?;
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
                .arg(requirements),
        )?,
        "pip could not install {requirements}"
    );
    std::fs::write(stamp, wanted)?;
    Ok(python)
}

/// Where cargo builds.
///
/// # Errors
/// cargo fails.
pub fn target_folder(root: &Path) -> Result<PathBuf> {
    let metadata = output(cargo(root).args(["metadata", "--no-deps", "--format-version", "1"]))?;
    let metadata: serde_json::Value = serde_json::from_str(&metadata)?;
    Ok(metadata["target_directory"]
        .as_str()
        .map_or_else(|| root.join("target"), PathBuf::from))
}

/// The folder beside the checkout that has scans, or the one in `STRAHL_SHARED`.
pub fn shared_data(root: &Path) -> PathBuf {
    std::env::var_os("STRAHL_SHARED")
        .map_or_else(|| root.join("../shared"), PathBuf::from)
        .join("data")
}
