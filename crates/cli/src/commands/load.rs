//! Reading a volume.

use crate::args;
use crate::flags::ReadFlags;
use crate::progress::{Progress, shown_by};
use anyhow::Result;
use std::path::PathBuf;
use strahl::volume::read::LoadedVolume;

/// Reads a volume with progress; its notes are left to the caller.
pub fn load(paths: &[PathBuf], flags: &ReadFlags, quiet: bool) -> Result<LoadedVolume> {
    let options = args::read_options(flags)?;
    let progress = Progress::new("reading", quiet);
    Ok(strahl::load_under(paths, &options, &shown_by(&progress))?)
}
