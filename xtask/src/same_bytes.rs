//! `cargo xtask same-bytes`: random scenes have the pictures of an older commit, byte for byte.

use crate::bench::lines;
use crate::older_commit::OlderCommit;
use crate::python::target_folder;
use anyhow::{Context, Result, ensure};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

const EXAMPLE: &str = "crates/strahl/examples/scene_bytes.rs";

/// What is to be compared.
#[derive(clap::Args)]
pub struct Arguments {
    /// The older commit, any name that git knows it by.
    #[arg(long, default_value = "b7ff363")]
    baseline: String,
    /// A checkout of the older commit that is there already; without, one is made under `target`.
    #[arg(long)]
    checkout: Option<PathBuf>,
    /// Number of random scenes. About one in eight means something that cannot be drawn.
    #[arg(long, default_value_t = 1200)]
    scenes: u32,
    /// Number of the first one.
    #[arg(long, default_value_t = 0)]
    from: u32,
    /// How many differing scenes are printed.
    #[arg(long, default_value_t = 20)]
    show: usize,
}

/// Draws the scenes with both commits; whether all pictures are the same.
///
/// # Errors
/// A commit is not there, cannot be built or run.
pub fn run(root: &Path, arguments: &Arguments) -> Result<bool> {
    let older = OlderCommit::new(root, &arguments.baseline, arguments.checkout.as_deref())?;
    let programs = older.examples("strahl", EXAMPLE)?;
    let folder = target_folder(root)?.join("same-bytes");
    let drawn = |program: &Path| {
        let mut command = Command::new(program);
        command.arg(format!("folder={}", folder.display()));
        command.arg(format!("scenes={}", arguments.scenes));
        lines(command.arg(format!("from={}", arguments.from)))
    };
    let [before, now] = [drawn(&programs[0])?, drawn(&programs[1])?];
    ensure!(
        before.len() == now.len(),
        "the programs drew different numbers of scenes"
    );
    let (mut same, mut plain, mut refused, mut differing) = (0, 0, 0, Vec::new());
    for (before, now) in before.iter().zip(&now) {
        let [a, b] = [hash(before)?, hash(now)?];
        if a != b {
            differing.push(format!(
                "scene {}: {a} before, {b} now {}",
                now["seed"], now["why"]
            ));
        } else if a == "refused" {
            refused += 1;
        } else {
            same += 1;
            plain += usize::from(now["shows_something"] != Value::Bool(true));
        }
    }
    for line in differing.iter().take(arguments.show) {
        println!("{line}");
    }
    println!(
        "{same} pictures have the bytes of {} ({plain} of them are of one color), {refused} scenes are refused \
         by both, {} differ",
        arguments.baseline,
        differing.len()
    );
    Ok(differing.is_empty())
}

fn hash(line: &Value) -> Result<&str> {
    let hash = line["hash"].as_str();
    hash.with_context(|| format!("no hash in {line}"))
}
