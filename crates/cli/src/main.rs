//! The `strahl` command line.
//!
//! A call passes through three layers: [`flags`] declares all commands and flags, [`args`] checks
//! their values, and [`commands`] does the work, one file per command. Exit codes: 0 done, 1 failed
//! (one message on stderr), 2 wrong usage, 130 interrupted.

mod args;
mod commands;
mod flags;
mod print;
mod progress;
mod remedy;

use std::process::ExitCode;

fn main() -> ExitCode {
    set_missing_runtime_folder();
    let flags = flags::Flags::from_command_line();
    // Where the system gives no more threads, the pool would panic at its first use.
    if let Err(error) = rayon::ThreadPoolBuilder::new().build_global() {
        print::message(&format!("error: no threads to work with: {error}"));
        return ExitCode::FAILURE;
    }
    // A signal may arrive at any time, also while a file is read or written. Unfinished files are
    // removed here, so that no other code has to check for signals.
    let handler = ctrlc::set_handler(|| {
        #[cfg(feature = "sim")]
        if commands::sim::stop() {
            return;
        }
        strahl::abandon_outputs();
        std::process::exit(130);
    });
    if let Err(error) = handler {
        print::message(&format!(
            "warning: an interrupt may leave a temporary file: {error}"
        ));
    }
    match commands::run(flags) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            print::message(&format!("error: {}", print::chain(&error)));
            if let Some(remedy) = remedy::of(&error) {
                print::message(&format!("help: {remedy}"));
            }
            ExitCode::FAILURE
        }
    }
}

/// Names a runtime folder if the environment has none, as on servers and in containers. Mesa's Vulkan
/// driver looks for a Wayland display there, and prints an error for every attempt without the name.
fn set_missing_runtime_folder() {
    let name = "XDG_RUNTIME_DIR";
    if cfg!(unix) && std::env::var_os(name).is_none() {
        // SAFETY: this is the first statement of `main`, so no other thread reads the environment.
        unsafe { std::env::set_var(name, std::env::temp_dir()) };
    }
}
