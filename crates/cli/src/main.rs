//! The `strahl` command line.
//!
//! A call goes through three layers: [`flags`] is the table of everything that can be typed,
//! [`args`] turns what was typed into checked values, and [`commands`] does the work, one file per
//! command. Exit codes: 0 done, 1 failed (one message on stderr), 2 wrong usage, 130 interrupted.

mod args;
mod commands;
mod flags;
mod print;
mod progress;
mod remedy;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    let flags = flags::Flags::parse();
    // An interrupt or a request to end may come at any time, also while a file is read or written. Whatever is
    // unfinished is removed from here, so that nothing else has to check.
    let handler = ctrlc::set_handler(|| {
        if commands::sim::stop() {
            return;
        }
        strahl::abandon_outputs();
        std::process::exit(130);
    });
    if let Err(error) = handler {
        eprintln!("warning: an interrupt may leave a temporary file: {error}");
    }
    match commands::run(flags) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", print::chain(&error));
            if let Some(remedy) = remedy::of(&error) {
                eprintln!("help: {remedy}");
            }
            ExitCode::FAILURE
        }
    }
}
