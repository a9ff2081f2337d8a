//! `cargo xtask fuzz`: the readers against hostile files, and graphs that nobody would write.
//!
//! The targets lie in `fuzz/`, a workspace of its own, because they need a nightly toolchain.
//! Seeds are checked in (`fuzz/seeds/TARGET`); what a run finds on top goes to `fuzz/corpus`, what
//! breaks a reader to `fuzz/artifacts`. A broken reader's input becomes a test: see CONTRIBUTING.md.

use crate::command::{output, succeeds};
use anyhow::{Context, Result, ensure};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

/// Longest input; readers meet everything interesting well below.
const MAX_INPUT_BYTES: usize = 64 << 10;

/// Memory that a reader may take for such an input, and the most seconds for one input.
const MEMORY_LIMIT_MB: usize = 2048;
const SECONDS_PER_INPUT: usize = 20;

/// Runs one target, or all; whether nothing broke. With `sanitize`, under AddressSanitizer: several times slower, but
/// it also sees what unsafe code of the decoders that we depend on does wrong.
pub fn run(root: &Path, target: Option<&str>, seconds: u64, sanitize: bool) -> Result<bool> {
    let targets = targets(root)?;
    if let Some(target) = target {
        ensure!(
            targets.iter().any(|name| name == target),
            "no fuzz target `{target}`; there are: {}",
            targets.join(", ")
        );
    }
    let installed = succeeds(
        Command::new("cargo")
            .args(["+nightly", "fuzz", "--version"])
            .stdout(Stdio::null())
            .stderr(Stdio::null()),
    )?;
    ensure!(
        installed,
        "this needs a nightly toolchain and cargo-fuzz: `rustup toolchain install nightly` and \
         `cargo install cargo-fuzz`"
    );
    let mut rows = Vec::new();
    for name in targets
        .iter()
        .filter(|name| target.is_none_or(|only| only == *name))
    {
        rows.push(run_target(root, name, seconds, sanitize)?);
    }
    println!(
        "\n{:<12} {:>8} {:>12}  result",
        "target", "seconds", "inputs"
    );
    for row in &rows {
        println!(
            "{:<12} {:>8.0} {:>12}  {}",
            row.name,
            row.seconds,
            row.inputs.map_or("?".to_string(), |n| n.to_string()),
            if row.clean { "clean" } else { "BROKE" }
        );
    }
    Ok(rows.iter().all(|row| row.clean))
}

struct Row {
    name: String,
    seconds: f64,
    inputs: Option<u64>,
    clean: bool,
}

fn run_target(root: &Path, name: &str, seconds: u64, sanitize: bool) -> Result<Row> {
    let corpus = root.join("fuzz/corpus").join(name);
    std::fs::create_dir_all(&corpus)?;
    println!("== {name}");
    // Usually without a sanitizer: the readers hold no unsafe code, and it is several times faster. The
    // targets' own allocator catches what a header merely claims. `-O` leaves it to the manifest
    // where debug assertions are on; else cargo-fuzz turns them on everywhere.
    let sanitizer = if sanitize { "address" } else { "none" };
    let build = succeeds(Command::new("cargo").current_dir(root).args([
        "+nightly",
        "fuzz",
        "build",
        "-O",
        "--sanitizer",
        sanitizer,
        name,
    ]))?;
    ensure!(build, "the fuzz target {name} does not compile");
    let start = Instant::now();
    let run = Command::new("cargo")
        .current_dir(root)
        .args([
            "+nightly",
            "fuzz",
            "run",
            "-O",
            "--sanitizer",
            sanitizer,
            name,
        ])
        .arg(&corpus)
        .arg(root.join("fuzz/seeds").join(name))
        .arg("--")
        .arg(format!("-max_total_time={seconds}"))
        .arg(format!("-max_len={MAX_INPUT_BYTES}"))
        .arg(format!("-rss_limit_mb={MEMORY_LIMIT_MB}"))
        .arg(format!("-timeout={SECONDS_PER_INPUT}"))
        .args(["-print_final_stats=1", "-verbosity=0"])
        .output()
        .context("cannot start cargo fuzz")?;
    let said = String::from_utf8_lossy(&run.stderr);
    if !run.status.success() {
        // The last lines tell the panic and where the input was kept.
        let lines: Vec<&str> = said.lines().collect();
        for line in &lines[lines.len().saturating_sub(40)..] {
            println!("{line}");
        }
    }
    Ok(Row {
        name: name.to_string(),
        seconds: start.elapsed().as_secs_f64(),
        inputs: executed(&said),
        clean: run.status.success(),
    })
}

/// The names of the targets: the files in `fuzz/fuzz_targets`.
fn targets(root: &Path) -> Result<Vec<String>> {
    let list = output(Command::new("git").current_dir(root).args([
        "ls-files",
        "--cached",
        "--others",
        "--exclude-standard",
        "fuzz/fuzz_targets/*.rs",
    ]))?;
    Ok(list
        .lines()
        .filter_map(|path| Path::new(path).file_stem())
        .map(|stem| stem.to_string_lossy().into_owned())
        .collect())
}

/// How many inputs were tried, from the statistics that the fuzzer prints at its end.
fn executed(said: &str) -> Option<u64> {
    said.lines()
        .find_map(|line| line.strip_prefix("stat::number_of_executed_units:"))
        .and_then(|count| count.trim().parse().ok())
}

#[cfg(test)]
mod tests {
    #[test]
    fn reads_the_statistics() {
        let said = "Done\nstat::number_of_executed_units: 76123\nstat::peak_rss_mb: 40\n";
        assert_eq!(super::executed(said), Some(76123));
        assert_eq!(super::executed("nothing"), None);
    }
}
