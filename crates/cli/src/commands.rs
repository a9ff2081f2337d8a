//! The work behind each command.

mod convert;
mod draw;
#[cfg(feature = "graph")]
mod graph;
mod info;
mod load;
mod presets;
mod scene;
#[cfg(feature = "graph")]
mod shader;
#[cfg(feature = "sim")]
pub mod sim;

use crate::flags::{Command, CompletionsFlags, Flags, ManFlags};
use crate::print;
use anyhow::{Context, Result};
use clap::CommandFactory;

/// Runs the command.
pub fn run(flags: Flags) -> Result<()> {
    let quiet = flags.quiet;
    match flags.command {
        Command::Render(flags) => draw::render(&flags, quiet),
        Command::Demo(flags) => draw::demo(&flags, quiet),
        Command::Info(flags) => info::run(&flags, quiet),
        Command::Convert(flags) => convert::run(&flags, quiet),
        Command::Scene(command) => scene::run(&command, quiet),
        #[cfg(feature = "graph")]
        Command::Shader(command) => shader::run(&command),
        #[cfg(feature = "graph")]
        Command::Graph(command) => graph::run(&command, quiet),
        Command::Presets(flags) => presets::run(&flags),
        #[cfg(feature = "sim")]
        Command::Sim(command) => sim::run(&command, quiet),
        Command::Completions(flags) => completions(&flags),
        Command::Man(flags) => manual(&flags),
    }
}

fn manual(flags: &ManFlags) -> Result<()> {
    let folder = &flags.folder;
    std::fs::create_dir_all(folder)
        .and_then(|()| clap_mangen::generate_to(Flags::command(), folder))
        .with_context(|| format!("{}: the manual pages cannot be written", folder.display()))
}

fn completions(flags: &CompletionsFlags) -> Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(flags.shell, &mut Flags::command(), "strahl", &mut script);
    print::out(&String::from_utf8_lossy(&script))
}
