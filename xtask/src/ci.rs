//! `cargo xtask ci`: all that a submission must pass. Every step runs, even after one failed.

use crate::command::{cargo, succeeds};
use crate::{suite, third_party, tidy};
use anyhow::Result;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

/// Runs every step; whether all passed.
pub fn run(root: &Path) -> Result<bool> {
    let mut steps = Steps::default();
    steps.run("formatting", || {
        succeeds(cargo(root).args(["fmt", "--all", "--check"]))
    })?;
    steps.run("formatting of twins", || {
        // Macros declare their modules, which `cargo fmt` does not follow.
        let check = ["--check", "--edition", "2024"];
        succeeds(Command::new("rustfmt").args(check).args(twins(root)?))
    })?;
    steps.run("tidy", || tidy::run(root))?;
    let mut report = suite::Report::default();
    steps.run("tests", || {
        report = suite::run(root, None)?;
        Ok(report.print())
    })?;
    steps.run("clippy", || {
        succeeds(
            cargo(root)
                .args(["clippy", "--workspace", "--all-targets", "--quiet"])
                .args(["--features", "strahl-cpu/bench-kernels"])
                .args(["--", "-D", "warnings"]),
        )
    })?;
    steps.run("volume without its optional features", || {
        succeeds(cargo(root).args([
            "check",
            "--quiet",
            "--package",
            "strahl-volume",
            "--no-default-features",
        ]))
    })?;
    steps.run("the library without its optional features", || {
        let check = ["check", "--quiet", "--package", "strahl"];
        succeeds(cargo(root).args(check).arg("--no-default-features"))
    })?;
    steps.run("the program without its optional features", || {
        let check = ["check", "--quiet", "--package", "strahl-cli"];
        succeeds(cargo(root).args(check).arg("--no-default-features"))
    })?;
    steps.run("what a browser needs", || for_browsers(root))?;
    steps.run("licenses", || {
        third_party::run(root, &third_party::Arguments::default())
    })?;
    steps.run("documentation", || {
        succeeds(
            cargo(root)
                .args(["doc", "--workspace", "--no-deps", "--quiet"])
                .env("RUSTDOCFLAGS", "-D warnings"),
        )
    })?;
    let passed = steps.print();
    println!("{}", report.closing_line());
    Ok(passed)
}

/// The crates that a page in a browser draws with.
const OF_BROWSERS: [&str; 7] = [
    "volume", "scene", "shader", "program", "graph", "evaluate", "cpu",
];

/// Checks them for a machine without clock, threads and C library.
fn for_browsers(root: &Path) -> Result<bool> {
    const TARGET: &str = "wasm32-unknown-unknown";
    let folder = Command::new("rustc")
        .args(["--print", "target-libdir", "--target", TARGET])
        .output()?;
    if !Path::new(String::from_utf8_lossy(&folder.stdout).trim()).is_dir() {
        println!("skipped: {TARGET} is not there; `rustup target add {TARGET}` adds it");
        return Ok(true);
    }
    let mut check = cargo(root);
    check.args([
        "check",
        "--quiet",
        "--no-default-features",
        "--target",
        TARGET,
    ]);
    for package in OF_BROWSERS {
        check.arg(format!("--package=strahl-{package}"));
    }
    succeeds(&mut check)
}

/// The files `crates/cpu/src/library/SLOT/NAME.rs`.
fn twins(root: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for slot in fs::read_dir(root.join("crates/cpu/src/library"))? {
        let slot = slot?.path();
        if slot.is_dir() {
            for file in fs::read_dir(slot)? {
                files.push(file?.path());
            }
        }
    }
    Ok(files)
}

#[derive(Default)]
struct Steps(Vec<(&'static str, bool, f64)>);

impl Steps {
    fn run(&mut self, name: &'static str, step: impl FnOnce() -> Result<bool>) -> Result<()> {
        println!("== {name}");
        let start = Instant::now();
        let passed = step()?;
        self.0.push((name, passed, start.elapsed().as_secs_f64()));
        Ok(())
    }

    fn print(&self) -> bool {
        println!();
        for (name, passed, seconds) in &self.0 {
            let word = if *passed { "ok" } else { "FAILED" };
            println!("{word:<7} {seconds:>7.1} s  {name}");
        }
        self.0.iter().all(|(_, passed, _)| *passed)
    }
}
