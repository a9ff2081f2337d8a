//! `cargo xtask bench-scenes`: what nobody else is compared with must not have become slower than in an older
//! commit.

use super::{Table, lines, median, milliseconds, number, numbers, publish};
use crate::older_commit::OlderCommit;
use anyhow::{Context, Result, ensure};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

const EXAMPLE: &str = "crates/cpu/examples/time_scenes.rs";

/// The share of the older speed that is allowed.
const ALLOWED: f64 = 0.97;

/// What is to be compared.
#[derive(clap::Args)]
pub struct Arguments {
    /// The older commit, any name that git knows it by.
    #[arg(long, default_value = "3a2849e")]
    baseline: String,
    /// A checkout of the older commit that is there already; without, one is made under `target`.
    #[arg(long)]
    checkout: Option<PathBuf>,
    /// Only this scene.
    #[arg(long)]
    scene: Option<String>,
    /// Pictures of each scene in a turn.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Threads of both.
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..))]
    threads: u32,
    /// How often each commit has its turn.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// Keeps the table as docs/performance/scenes.md.
    #[arg(long)]
    write: bool,
}

/// Times both commits in turns and prints a table; whether no scene is slower than allowed.
///
/// # Errors
/// A commit is not there, cannot be built or run.
pub fn run(root: &Path, arguments: &Arguments) -> Result<bool> {
    let older = OlderCommit::new(root, &arguments.baseline, arguments.checkout.as_deref())?;
    let programs = older.examples("strahl-cpu", EXAMPLE)?;
    let mut order: Vec<String> = Vec::new();
    let mut seconds: [BTreeMap<String, Vec<f64>>; 2] = Default::default();
    let mut samples: [BTreeMap<String, f64>; 2] = Default::default();
    for round in 0..arguments.rounds as usize {
        for turn in [round % 2, 1 - round % 2] {
            let mut command = Command::new(&programs[turn]);
            command.arg(format!("frames={}", arguments.frames));
            command.arg(format!("threads={}", arguments.threads));
            if let Some(scene) = &arguments.scene {
                command.arg(format!("scene={scene}"));
            }
            for line in lines(&mut command)? {
                let name = name(&line)?;
                if !order.contains(&name) {
                    order.push(name.clone());
                }
                samples[turn].insert(name.clone(), number(&line, "samples")?);
                let all = seconds[turn].entry(name).or_default();
                all.extend(numbers(&line, "seconds")?);
            }
        }
        eprintln!("round {} of {}", round + 1, arguments.rounds);
    }
    ensure!(!order.is_empty(), "there is no such scene in {EXAMPLE}");
    let mut table = Table::new(&[
        "scene",
        "before",
        "now",
        "times as fast",
        "samples, now/before",
    ]);
    let mut slower = Vec::new();
    for name in &order {
        let of = |turn: usize| seconds[turn].get(name).map_or(f64::NAN, |all| median(all));
        let count = |turn: usize| samples[turn].get(name).copied().unwrap_or(f64::NAN);
        let ratio = of(0) / of(1);
        if ratio.is_nan() || ratio < ALLOWED {
            slower.push(name.as_str());
        }
        table.row(&[
            name.clone(),
            milliseconds(of(0)),
            milliseconds(of(1)),
            format!("{ratio:.2} ×"),
            format!("{:.2}", count(1) / count(0)),
        ]);
    }
    let body = format!(
        "    cargo xtask bench-scenes --baseline {}\n\n\
         The scenes of `{EXAMPLE}`: phantoms with up to 128 voxels along an edge, 256² pixels, {} threads. Medians of {} \
         rounds of {} frames, with both commits alternating. The goal is at least {ALLOWED} ×.\n\n{}",
        arguments.baseline, arguments.threads, arguments.rounds, arguments.frames, table.text
    );
    println!("{body}");
    publish(
        root,
        "scenes",
        "Scenes compared with an older commit",
        &body,
        arguments.write,
    )?;
    if !slower.is_empty() {
        println!("slower than {ALLOWED} ×: {}", slower.join(", "));
    }
    Ok(slower.is_empty())
}

fn name(line: &Value) -> Result<String> {
    let name = line["scene"].as_str();
    Ok(name
        .with_context(|| format!("no scene in {line}"))?
        .to_owned())
}
