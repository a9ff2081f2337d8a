//! Reading a volume.

use crate::args;
use crate::flags::{LabelFlags, ReadFlags};
use crate::progress::{Progress, shown_by};
use anyhow::Result;
use std::path::PathBuf;
use strahl::volume::read::LoadedVolume;

/// Reads a volume with progress; its notes are left to the caller.
#[cfg(feature = "sim")]
pub fn load(paths: &[PathBuf], flags: &ReadFlags, quiet: bool) -> Result<LoadedVolume> {
    load_labels(paths, flags, &LabelFlags::default(), quiet)
}

/// The same of a volume whose numbers may be object ids.
pub fn load_labels(
    paths: &[PathBuf],
    flags: &ReadFlags,
    labels: &LabelFlags,
    quiet: bool,
) -> Result<LoadedVolume> {
    let mut options = args::read_options(flags)?;
    options.as_labels = labels.as_labels;
    if let Some(table) = &labels.label_table {
        options.label_table = Some(strahl::load_label_table(table)?);
    }
    let progress = Progress::new("reading", quiet);
    Ok(strahl::load_under(paths, &options, &shown_by(&progress))?)
}
