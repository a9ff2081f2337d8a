//! `strahl convert`: a volume in another format.

use super::load::load_components;
use crate::flags::ConvertFlags;
use crate::print;
use crate::progress::Progress;
use anyhow::{Context, Result};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use strahl::Output;
use strahl::volume::write::{Format, NewFiles, WriteOptions, value_type, write_components};
use strahl::volume::{Label, Volume};

pub fn run(flags: &ConvertFlags, quiet: bool) -> Result<()> {
    let path = &flags.output;
    let name = path
        .file_name()
        .and_then(|name| name.to_str())
        .with_context(|| format!("{}: not the name of a file", path.display()))?;
    // All of it before the long work.
    super::draw::refuse_to_replace(path, flags.inputs.iter().chain(&flags.labels.label_table))?;
    let format = Format::of_name(name)?;
    drop(Output::create(path)?);
    let mut loaded = load_components(
        &flags.inputs,
        &flags.read,
        &flags.labels,
        &flags.memory,
        quiet,
    )?;
    if flags.anonymous {
        let volumes = loaded.volumes.into_iter();
        loaded.volumes = volumes.map(Volume::anonymous).collect();
    }
    for note in &loaded.notes {
        print::note(note, quiet);
    }
    let options = WriteOptions {
        compress: !flags.uncompressed,
        labels: loaded.labels,
    };
    let progress = Progress::new("writing", quiet);
    let mut files = Outputs {
        folder: path.parent().unwrap_or(Path::new("")).to_owned(),
        outputs: Vec::new(),
    };
    write_components(name, &loaded.volumes, &options, &mut files)?;
    // The header, which names the others, goes first and comes last.
    if let [header, _, ..] = files.outputs.as_slice() {
        header.remove_old()?;
    }
    for output in files.outputs.into_iter().rev() {
        output.finish()?;
    }
    drop(progress);
    let volume = &loaded.volumes[0];
    if !format.keeps_place() {
        print::note(&what_is_lost(format, volume), quiet);
    }
    let count = loaded.volumes.len();
    let are_colors = count > 1 && volume.metadata().components.are_colors;
    if are_colors && !format.keeps_colors(&loaded.volumes) {
        print::note("the file holds the colors as vectors", quiet);
    }
    if let Some(lost) = lost_labels(format, options.labels.as_deref()) {
        print::note(&lost, quiet);
    }
    if !quiet {
        let [x, y, z] = volume.grid().dims();
        let numbers = match count {
            1 => String::new(),
            n => format!(" of {n} components"),
        };
        print::message(&format!(
            "wrote {}: {x} × {y} × {z} voxels{numbers}",
            path.display()
        ));
    }
    Ok(())
}

/// What a format loses of these labels, if anything.
fn lost_labels(format: Format, labels: Option<&[Label]>) -> Option<String> {
    let names = match labels?.len() {
        0 => None,
        1 => Some("the name and color of 1 label are".to_owned()),
        n => Some(format!("the names and colors of {n} labels are")),
    };
    match (names, format.marks_labels()) {
        _ if format.keeps_label_names() => None,
        (None, true) => None,
        (None, false) => Some(
            "the file does not say that its numbers are object ids; .nrrd and .nii do".to_owned(),
        ),
        (Some(names), true) => Some(format!("{names} not in the file; .nrrd keeps them")),
        (Some(names), false) => Some(format!(
            "{names} not in the file, nor does it say that its numbers are object ids; .nrrd keeps both"
        )),
    }
}

/// What a format without a header leaves behind, and the flags that make up for it.
fn what_is_lost(format: Format, volume: &Volume) -> String {
    let [x, y, z] = volume.grid().dims();
    let [sx, sy, sz] = volume.grid().spacing_mm().to_array();
    let layout = match format {
        Format::Raw => format!("--dims {x},{y},{z} --type {} ", value_type(volume)),
        _ => String::new(),
    };
    format!(
        "the file holds numbers alone, not where they lie; read it with {layout}--spacing {sx},{sy},{sz}"
    )
}

/// New files that get their names when all of them are complete.
struct Outputs {
    folder: PathBuf,
    outputs: Vec<Output>,
}

impl NewFiles for Outputs {
    fn create(&mut self, name: &str) -> io::Result<Box<dyn Write + '_>> {
        let output = Output::create(&self.folder.join(name)).map_err(io::Error::other)?;
        self.outputs.push(output);
        match self.outputs.last_mut() {
            Some(output) => Ok(Box::new(output)),
            None => Err(io::ErrorKind::NotFound.into()),
        }
    }
}
