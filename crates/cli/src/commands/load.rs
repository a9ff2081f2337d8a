//! Reading a volume.

use crate::args;
use crate::flags::{LabelFlags, MemoryFlags, ReadFlags};
use crate::progress::{Progress, shown_by};
use anyhow::Result;
use std::path::PathBuf;
use strahl::volume::read::{LoadedComponents, LoadedVolume, ReadOptions};

/// Reads a volume with progress; its notes are left to the caller.
#[cfg(feature = "sim")]
pub fn load(paths: &[PathBuf], flags: &ReadFlags, quiet: bool) -> Result<LoadedVolume> {
    let (labels, memory) = (LabelFlags::default(), MemoryFlags::default());
    load_labels(paths, flags, &labels, &memory, quiet)
}

/// The same of a volume whose numbers may be object ids.
pub fn load_labels(
    paths: &[PathBuf],
    flags: &ReadFlags,
    labels: &LabelFlags,
    memory: &MemoryFlags,
    quiet: bool,
) -> Result<LoadedVolume> {
    let options = options(flags, labels)?;
    let progress = Progress::new("reading", quiet);
    let control = shown_by(&progress).with_memory(args::memory(memory)?);
    Ok(strahl::load_under(paths, &options, &control)?)
}

/// The same with all numbers of each voxel, unless the flags pick one of them. Object ids are one number.
pub fn load_components(
    paths: &[PathBuf],
    flags: &ReadFlags,
    labels: &LabelFlags,
    memory: &MemoryFlags,
    quiet: bool,
) -> Result<LoadedComponents> {
    let options = options(flags, labels)?;
    if flags.component.is_some() || options.as_labels || options.label_table.is_some() {
        let loaded = load_labels(paths, flags, labels, memory, quiet)?;
        return Ok(LoadedComponents {
            volumes: vec![loaded.volume],
            labels: loaded.labels,
            notes: loaded.notes,
        });
    }
    let progress = Progress::new("reading", quiet);
    let control = shown_by(&progress).with_memory(args::memory(memory)?);
    Ok(strahl::load_components_under(paths, &options, &control)?)
}

fn options(flags: &ReadFlags, labels: &LabelFlags) -> Result<ReadOptions> {
    let mut options = args::read_options(flags)?;
    options.as_labels = labels.as_labels;
    if let Some(table) = &labels.label_table {
        options.label_table = Some(strahl::load_label_table(table)?);
    }
    Ok(options)
}
