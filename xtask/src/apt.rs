//! Packages of Debian and Ubuntu, installed as far as that is possible without a question.

use crate::command::succeeds;
use anyhow::Result;
use std::process::Command;

/// Installs `packages`; whether they are there now. Says what it does, or what to type.
///
/// # Errors
/// A program that is there cannot be started.
pub fn install(packages: &[&str]) -> Result<bool> {
    let names = packages.join(" ");
    if !is_program("apt-get") {
        println!("there is no apt-get; install what this system calls {names}");
        return Ok(false);
    }
    let Some(apt) = apt_as_root() else {
        println!("to install it:\n    sudo apt-get install {names}");
        return Ok(false);
    };
    println!("installing {names}");
    let run = |arguments: &[&str]| -> Result<bool> {
        let mut command = Command::new(apt[0]);
        command.args(&apt[1..]).args(arguments);
        succeeds(command.env("DEBIAN_FRONTEND", "noninteractive"))
    };
    let install = ["install", "-y", "-qq", "--no-install-recommends"];
    let install: Vec<&str> = install.iter().chain(packages).copied().collect();
    // A machine that was never updated does not know the packages.
    let is_installed = run(&install)? || (run(&["update", "-qq"])? && run(&install)?);
    if !is_installed {
        println!("{names} could not be installed");
    }
    Ok(is_installed)
}

/// How `apt-get` is called with the rights to install, if that needs no password.
fn apt_as_root() -> Option<&'static [&'static str]> {
    let id = Command::new("id").arg("-u").output().ok()?;
    if id.stdout.trim_ascii() == b"0" {
        return Some(&["apt-get"]);
    }
    let mut sudo = Command::new("sudo");
    let asks_nothing = is_program("sudo") && succeeds(sudo.args(["-n", "true"])).ok()?;
    asks_nothing.then_some(&["sudo", "-n", "apt-get"])
}

fn is_program(name: &str) -> bool {
    std::env::var_os("PATH")
        .is_some_and(|path| std::env::split_paths(&path).any(|folder| folder.join(name).is_file()))
}
