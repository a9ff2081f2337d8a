//! A graphics driver for the tests: the software one, if there is none at all.

use crate::command::succeeds;
use anyhow::Result;
use std::path::Path;
use std::process::Command;

/// Where Vulkan looks for drivers on Linux.
const FOLDERS: [&str; 3] = [
    "/etc/vulkan/icd.d",
    "/usr/local/share/vulkan/icd.d",
    "/usr/share/vulkan/icd.d",
];

/// The driver that needs no graphics card, in Debian and Ubuntu.
const PACKAGE: &str = "mesa-vulkan-drivers";

/// Installs the software driver where Linux has no Vulkan driver, as far as that is possible
/// without a question; says what it does, or what to type.
///
/// # Errors
/// A program that is there cannot be started.
pub fn prepare() -> Result<()> {
    if !cfg!(target_os = "linux") || has_driver() {
        return Ok(());
    }
    if !is_program("apt-get") {
        println!(
            "there is no Vulkan driver; tests that need one are skipped. Mesa's lavapipe needs no graphics card."
        );
        return Ok(());
    }
    let Some(apt) = apt_as_root() else {
        println!(
            "there is no Vulkan driver; tests that need one are skipped. To install one that needs no graphics card:\n    sudo apt-get install {PACKAGE}"
        );
        return Ok(());
    };
    println!("there is no Vulkan driver; installing {PACKAGE}, which needs no graphics card");
    let run = |arguments: &[&str]| -> Result<bool> {
        let mut command = Command::new(apt[0]);
        command.args(&apt[1..]).args(arguments);
        succeeds(command.env("DEBIAN_FRONTEND", "noninteractive"))
    };
    let install = ["install", "-y", "-qq", "--no-install-recommends", PACKAGE];
    // A machine that was never updated does not know the package.
    if !(run(&install)? || (run(&["update", "-qq"])? && run(&install)?)) {
        println!("{PACKAGE} could not be installed; tests that need a graphics driver are skipped");
    }
    Ok(())
}

fn has_driver() -> bool {
    let named = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES", "VK_ADD_DRIVER_FILES"];
    named.iter().any(|name| std::env::var_os(name).is_some())
        || FOLDERS.iter().any(|folder| {
            let files = Path::new(folder).read_dir();
            files.is_ok_and(|mut files| files.next().is_some())
        })
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
