//! The project's own commands: `cargo xtask test | tidy | ci | gallery | oracle | fuzz | mutate-runs | same-bytes | third-party |
//! bench-…`.

mod apt;
mod bench;
mod ci;
mod command;
mod driver;
mod fuzz;
mod mutate_runs;
mod older_commit;
mod oracle;
mod python;
mod same_bytes;
mod suite;
mod third_party;
mod tidy;

use anyhow::Result;
use clap::{Parser, Subcommand};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The project's own commands.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Runs every test of the workspace, doc tests included, and says which were skipped and why.
    Test {
        /// Only tests whose name contains this.
        filter: Option<String>,
    },
    /// Checks the rules that no compiler checks: dependencies, names, coverage, glossary, links.
    Tidy,
    /// All that a submission must pass: tests, formatting, clippy, documentation, tidy.
    Ci,
    /// Draws a small picture per variant into docs/gallery, on both renderers, which have to agree.
    Gallery,
    /// Compares what Strahl reads and writes with independent Python libraries.
    Oracle {
        /// Measures time and memory of reading beside those libraries instead of comparing.
        #[arg(long)]
        time: bool,
        /// Only cases whose name contains this.
        #[arg(long)]
        only: Option<String>,
        /// Prints every case, not only the mismatches and a table.
        #[arg(long)]
        verbose: bool,
    },
    /// Times frames beside VTK, in turns, and how far each is from its own converged picture.
    BenchPeers(bench::peers::Arguments),
    /// Times frames with one thread, with more, and by separate processes, in turns.
    BenchThreads(bench::threads::Arguments),
    /// Measures how time and memory grow with the volume, the picture, the step, the opacity.
    BenchCurves(bench::curves::Arguments),
    /// Times scenes that are not in the comparison with others beside an older commit, in turns.
    BenchScenes(bench::scenes::Arguments),
    /// Draws random scenes with an older commit and with this one: every picture has to have the same bytes.
    SameBytes(same_bytes::Arguments),
    /// Runs the command line with files that were damaged at random, each in little memory and time.
    MutateRuns(mutate_runs::Arguments),
    /// Checks the licenses of the crates that the programs contain, and the page that lists them.
    ThirdParty(third_party::Arguments),
    /// Throws hostile files at the readers (needs a nightly toolchain and cargo-fuzz).
    Fuzz {
        /// The reader, such as `nrrd`; all one after another if not said.
        target: Option<String>,
        /// How long each target runs.
        #[arg(long, default_value_t = 60)]
        seconds: u64,
        /// Under AddressSanitizer, for the decoders of others that hold unsafe code.
        #[arg(long)]
        sanitize: bool,
    },
}

fn main() -> Result<ExitCode> {
    let arguments = Arguments::parse();
    let root = root();
    let passed = match arguments.task {
        Task::Test { filter } => suite::run(&root, filter.as_deref())?.print(),
        Task::Tidy => tidy::run(&root)?,
        Task::Ci => ci::run(&root)?,
        Task::Gallery => {
            let example = ["run", "--release", "-p", "strahl-conformance"];
            command::succeeds(
                command::cargo(&root)
                    .args(example)
                    .args(["--example", "gallery"]),
            )?
        }
        Task::Oracle {
            time,
            only,
            verbose,
        } => oracle::run(&root, time, only.as_deref(), verbose)?,
        Task::BenchPeers(arguments) => bench::peers::run(&root, &arguments)?,
        Task::BenchThreads(arguments) => bench::threads::run(&root, &arguments)?,
        Task::BenchCurves(arguments) => bench::curves::run(&root, &arguments)?,
        Task::BenchScenes(arguments) => bench::scenes::run(&root, &arguments)?,
        Task::SameBytes(arguments) => same_bytes::run(&root, &arguments)?,
        Task::MutateRuns(arguments) => mutate_runs::run(&root, &arguments)?,
        Task::ThirdParty(arguments) => third_party::run(&root, &arguments)?,
        Task::Fuzz {
            target,
            seconds,
            sanitize,
        } => fuzz::run(&root, target.as_deref(), seconds, sanitize)?,
    };
    Ok(if passed {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// The root of the checkout.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("xtask lies in the workspace")
        .to_path_buf()
}
