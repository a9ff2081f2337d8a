//! A graphics driver for the tests: the software one, if there is none at all.

use crate::apt;
use anyhow::Result;
use std::path::Path;

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
    println!("there is no Vulkan driver; {PACKAGE} needs no graphics card");
    if !apt::install(&[PACKAGE])? {
        println!("tests that need a graphics driver are skipped");
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
