//! `cargo xtask bench-threads`: what more threads gain, beside what the machine has to give.

use super::cases::{CaseFilter, title};
use super::{Table, milliseconds, numbers, only_line, publish};
use crate::older_commit::built_example;
use anyhow::{Context, Result, anyhow};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;

/// What is to be measured.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    asked: CaseFilter,
    /// Pictures of one orbit.
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Beside one.
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u32).range(2..))]
    threads: u32,
    /// How often each has its turn.
    #[arg(long, default_value_t = 24, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// Keeps the table as docs/performance/threads.md.
    #[arg(long)]
    write: bool,
}

/// Of each frame of the orbit, the shortest time of all rounds.
#[derive(Default)]
struct Shortest(Vec<f64>);

impl Shortest {
    fn add(&mut self, line: &Value) -> Result<()> {
        let frames = numbers(line, "seconds")?;
        self.0.resize(frames.len(), f64::INFINITY);
        for (shortest, seconds) in self.0.iter_mut().zip(frames) {
            *shortest = shortest.min(seconds);
        }
        Ok(())
    }

    fn mean(&self) -> f64 {
        self.0.iter().sum::<f64>() / self.0.len() as f64
    }
}

/// Times one process with one thread, as many such processes at once as threads are asked for, and one process with
/// these threads, in turns; whether all was there.
///
/// # Errors
/// The example cannot be built or run, or the file cannot be written.
pub fn run(root: &Path, arguments: &Arguments) -> Result<bool> {
    let Arguments {
        frames,
        threads,
        rounds,
        ..
    } = *arguments;
    let names = arguments.asked.cases(root)?;
    if names.is_empty() {
        return Ok(true);
    }
    let program = built_example(root, "strahl-cpu", "time_frames")?;
    let processes = format!("{threads} processes, of each");
    let of_threads = format!("{threads} threads");
    let mut table = Table::new(&[
        "case",
        "1 thread",
        &processes,
        &of_threads,
        "processes",
        "threads",
    ]);
    let mut gains = Vec::new();
    for case in &names {
        for mode in arguments.asked.modes() {
            let draw = Draw {
                program: &program,
                case,
                mode,
                frames,
            };
            let [mut alone, mut beside, mut together] = [(); 3].map(|()| Shortest::default());
            for _ in 0..rounds {
                alone.add(&draw.with_threads(1)?)?;
                for line in draw.in_processes(threads)? {
                    beside.add(&line)?;
                }
                together.add(&draw.with_threads(threads)?)?;
            }
            let times = [&alone, &beside, &together].map(Shortest::mean);
            let [alone, beside, together] = times;
            let gain = [f64::from(threads) * alone / beside, alone / together];
            gains.push(gain);
            let mut row = vec![format!("{case}, {}", title(mode))];
            row.extend(times.map(milliseconds));
            row.extend(gain.map(|gain| format!("{gain:.2} ×")));
            eprintln!("{}", row.join(", "));
            table.row(&row);
        }
    }
    let mean =
        |which: usize| gains.iter().map(|gain| gain[which]).sum::<f64>() / gains.len() as f64;
    let [by_processes, by_threads] = [0, 1].map(|which| format!("{:.2} ×", mean(which)));
    table.row(&["mean", "", "", "", &by_processes, &by_threads]);
    let body = format!(
        "    cargo xtask bench-threads\n\n\
         Frame times are means over {frames} frames of an orbit, each the shortest of {rounds} rounds. In a round, one thread, {threads} processes \
         with one thread each at the same time, and {threads} threads alternate. The last columns are the throughput relative to \
         one thread: of separate processes, which share only the machine, and of threads.\n\n{}",
        table.text
    );
    println!("{body}");
    publish(root, "threads", "Thread scaling", &body, arguments.write)?;
    Ok(true)
}

/// An orbit to be drawn.
#[derive(Clone, Copy)]
struct Draw<'a> {
    program: &'a PathBuf,
    case: &'a str,
    mode: &'a str,
    frames: u32,
}

impl Draw<'_> {
    fn with_threads(self, threads: u32) -> Result<Value> {
        let mut command = Command::new(self.program);
        command.arg(format!("case={}", self.case));
        command.arg(format!("mode={}", self.mode));
        command.arg(format!("frames={}", self.frames));
        command.arg(format!("threads={threads}"));
        only_line(&mut command)
    }

    /// What `number` processes print that run at once.
    fn in_processes(self, number: u32) -> Result<Vec<Value>> {
        thread::scope(|scope| {
            let running: Vec<_> = (0..number)
                .map(|_| scope.spawn(move || self.with_threads(1)))
                .collect();
            running
                .into_iter()
                .map(|process| {
                    let ended = process.join().map_err(|_| anyhow!("its thread ended"));
                    ended.context("a process could not be waited for")?
                })
                .collect()
        })
    }
}
