//! An older commit beside this one: examples that both build.

use crate::command::{cargo, output, succeeds};
use crate::python::target_folder;
use anyhow::{Context, Result, ensure};
use std::path::{Path, PathBuf};
use std::process::Command;

/// An older commit that is checked out beside the project.
pub struct OlderCommit<'r> {
    root: &'r Path,
    checkout: PathBuf,
}

impl<'r> OlderCommit<'r> {
    /// `commit` of the project at `root`, in `checkout` if there is one already, else under `target`.
    ///
    /// # Errors
    /// Git does not know the commit, or cannot check it out.
    pub fn new(root: &'r Path, commit: &str, checkout: Option<&Path>) -> Result<OlderCommit<'r>> {
        let checkout = match checkout {
            Some(folder) => folder.to_owned(),
            None => checked_out(root, commit)?,
        };
        Ok(OlderCommit { root, checkout })
    }

    /// The file `example` of `package` as it is now, built in the older commit and in this one: the two programs.
    ///
    /// # Errors
    /// It does not build in one of them.
    pub fn examples(&self, package: &str, example: &str) -> Result<[PathBuf; 2]> {
        let copy = self.checkout.join(example);
        if let Some(folder) = copy.parent() {
            std::fs::create_dir_all(folder)?;
        }
        let text = std::fs::read_to_string(self.root.join(example))
            .with_context(|| format!("cannot read {example}"))?;
        std::fs::write(&copy, as_before(&self.checkout, text)?)
            .with_context(|| format!("cannot write {}", copy.display()))?;
        let name = Path::new(example)
            .file_stem()
            .and_then(|name| name.to_str());
        let name = name.with_context(|| format!("{example} has no name"))?;
        let before = built_example(&self.checkout, package, name)?;
        Ok([before, built_example(self.root, package, name)?])
    }
}

/// `text` with what commits before `Control` have instead, if the one in `checkout` is such.
fn as_before(checkout: &Path, text: String) -> Result<String> {
    let root = std::fs::read_to_string(checkout.join("crates/cpu/src/lib.rs"))?;
    if !root.contains("no_progress") {
        return Ok(text);
    }
    let text = text.replace("&strahl_volume::Control::NONE", "&strahl_cpu::no_progress");
    Ok(text.replace(".stats.counts.unwrap()", ".stats"))
}

/// Builds the example `name` of `package` in the checkout `root`; the program.
///
/// # Errors
/// It does not build.
pub fn built_example(root: &Path, package: &str, name: &str) -> Result<PathBuf> {
    let example = ["build", "--release", "--package", package, "--example"];
    ensure!(
        succeeds(cargo(root).args(example).arg(name))?,
        "the example {name} does not build in {}",
        root.display()
    );
    let file = format!("{name}{}", std::env::consts::EXE_SUFFIX);
    Ok(target_folder(root)?.join("release/examples").join(file))
}

/// A checkout of `commit` under `target`, made if it is not there.
fn checked_out(root: &Path, commit: &str) -> Result<PathBuf> {
    let git = || {
        let mut command = Command::new("git");
        command.current_dir(root);
        command
    };
    let name = format!("{commit}^{{commit}}");
    let id = output(git().args(["rev-parse", "--verify", &name]))
        .with_context(|| format!("git knows no commit {commit:?}"))?;
    let folder = target_folder(root)?.join("baseline").join(id.trim());
    if !folder.join("Cargo.toml").is_file() {
        let mut add = git();
        add.args(["worktree", "add", "--force", "--detach"]);
        ensure!(
            succeeds(add.arg(&folder).arg(id.trim()))?,
            "git cannot check {commit} out into {}",
            folder.display()
        );
    }
    Ok(folder)
}
