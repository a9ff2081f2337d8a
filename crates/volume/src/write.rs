//! Volumes out: NIfTI, NRRD, MetaImage, npy and raw. `docs/formats.md` says what each one keeps.
//!
//! ```
//! use strahl_volume::{Grid, Metadata, Rescale, Samples, Volume, write};
//! let grid = Grid::centred([2, 1, 1], glam::DVec3::ONE)?;
//! let volume = Volume::new(grid, Samples::U8(vec![1, 2]), Rescale::IDENTITY, Metadata::default())?;
//! let mut folder = write::NewMemoryFiles::default();
//! write::write("two.nrrd", &volume, &write::WriteOptions::default(), &mut folder)?;
//! assert!(folder.0["two.nrrd"].starts_with(b"NRRD0004"));
//! # Ok::<(), strahl_volume::Error>(())
//! ```

mod metaimage;
mod nifti;
mod npy;
mod nrrd;
mod options;
mod raw;

use crate::Volume;
use crate::error::{Error, ErrorKind};
use crate::read::MemoryFiles;
use std::io::{self, Write};

pub use options::WriteOptions;
pub use raw::value_type;

/// The kinds of file that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// NIfTI-1 in one file; NIfTI-2 where NIfTI-1 has no room (an axis above 32767).
    Nifti,
    /// NIfTI packed with gzip.
    NiftiGz,
    /// NRRD, header and samples in one file.
    Nrrd,
    /// MetaImage, header and samples in one file.
    Mha,
    /// MetaImage, a header and a file of samples beside it (`.raw`, packed: `.zraw`).
    Mhd,
    /// A NumPy array of shape (z, y, x).
    Npy,
    /// The samples alone, x fastest, little endian.
    Raw,
}

impl Format {
    /// The format that the end of a file's name stands for, in any case.
    ///
    /// # Errors
    /// Names the endings that are known.
    pub fn of_name(name: &str) -> Result<Format, Error> {
        const ENDINGS: [(&str, Format); 7] = [
            (".nii.gz", Format::NiftiGz),
            (".nii", Format::Nifti),
            (".nrrd", Format::Nrrd),
            (".mha", Format::Mha),
            (".mhd", Format::Mhd),
            (".npy", Format::Npy),
            (".raw", Format::Raw),
        ];
        let lower = name.to_ascii_lowercase();
        ENDINGS
            .iter()
            .find(|(ending, _)| lower.ends_with(ending))
            .map(|&(_, format)| format)
            .ok_or_else(|| {
                let known: Vec<&str> = ENDINGS.iter().map(|(ending, _)| *ending).collect();
                Error::field(
                    "the file's name",
                    format!("`{name}`"),
                    format!("a name that ends in one of {}", known.join(", ")),
                )
            })
    }

    /// Whether files of this format say where their voxels lie in the world.
    pub fn keeps_place(self) -> bool {
        !matches!(self, Format::Npy | Format::Raw)
    }
}

/// Where new files go; names are without folders.
pub trait NewFiles {
    /// Begins a file. It is complete once [`write()`] has returned without an error: whoever
    /// implements this keeps it apart (under another name) until then.
    ///
    /// # Errors
    /// What the system says.
    fn create(&mut self, name: &str) -> io::Result<Box<dyn Write + '_>>;
}

/// New files in memory.
#[derive(Debug, Default)]
pub struct NewMemoryFiles(pub MemoryFiles);

impl NewFiles for NewMemoryFiles {
    fn create(&mut self, name: &str) -> io::Result<Box<dyn Write + '_>> {
        let bytes = self.0.entry(name.to_owned()).or_default();
        bytes.clear();
        Ok(Box::new(bytes))
    }
}

/// Writes `volume` as the file `name`, in the format that the name's ending stands for. Creates one
/// file; for `.mhd` a second one beside it.
///
/// Samples are written as they are stored. A rescale that is not identity is kept by NIfTI; the
/// other formats get the values: as the narrowest whole-number type that holds them if stored
/// numbers, slope and intercept are whole (HU of a CT stay 16 bit), else as f32, or f64 if the
/// samples have more than 24 bits.
///
/// # Errors
/// A name with an unknown ending, or what the system says.
pub fn write(
    name: &str,
    volume: &Volume,
    options: &WriteOptions,
    files: &mut dyn NewFiles,
) -> Result<(), Error> {
    let in_file = |error: Error| error.in_file(name);
    let create = |files: &mut dyn NewFiles, name: &str, body: &mut Body| {
        let mut out = files
            .create(name)
            .map_err(|e| Error::from(e).in_file(name))?;
        body(&mut *out).map_err(|error| error.in_file(name))?;
        out.flush().map_err(|e| Error::from(e).in_file(name))
    };
    match Format::of_name(name).map_err(in_file)? {
        Format::Nifti => create(files, name, &mut |out| {
            nifti::write(volume, options, false, out)
        }),
        Format::NiftiGz => create(files, name, &mut |out| {
            nifti::write(volume, options, true, out)
        }),
        Format::Nrrd => create(files, name, &mut |out| nrrd::write(volume, options, out)),
        Format::Mha => create(files, name, &mut |out| {
            metaimage::write(volume, options, out)
        }),
        Format::Mhd => {
            let stem = &name[..name.len() - ".mhd".len()];
            let data = format!("{stem}{}", if options.compress { ".zraw" } else { ".raw" });
            if data.contains('%') || data.trim() != data || data.eq_ignore_ascii_case("LOCAL.raw") {
                return Err(in_file(
                    ErrorKind::Unsupported {
                        feature: format!("a .mhd whose samples lie in `{data}`"),
                        instead: "choose a name without `%` and without blanks at its ends".into(),
                    }
                    .into(),
                ));
            }
            create(files, &data, &mut |out| {
                metaimage::write_samples(volume, options, out)
            })?;
            create(files, name, &mut |out| {
                Ok(out.write_all(metaimage::header(volume, options, &data, None).as_bytes())?)
            })
        }
        Format::Npy => create(files, name, &mut |out| npy::write(volume, out)),
        Format::Raw => create(files, name, &mut |out| {
            raw::write_values(volume, raw::Packing::None, out)
        }),
    }
}

type Body<'a> = dyn FnMut(&mut dyn Write) -> Result<(), Error> + 'a;
