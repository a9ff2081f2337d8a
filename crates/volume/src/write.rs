//! Volumes out: NIfTI, NRRD, MetaImage, npy and raw. `docs/formats.md` says what each one keeps.
//!
//! ```
//! use strahl_volume::{Grid, Metadata, Rescale, Samples, Volume, write};
//! let grid = Grid::centered([2, 1, 1], glam::DVec3::ONE)?;
//! let volume = Volume::new(grid, Samples::U8(vec![1, 2]), Rescale::IDENTITY, Metadata::default())?;
//! let mut folder = write::NewMemoryFiles::default();
//! write::write("two.nrrd", &volume, &write::WriteOptions::default(), &mut folder)?;
//! assert!(folder.0["two.nrrd"].starts_with(b"NRRD0004"));
//! # Ok::<(), strahl_volume::Error>(())
//! ```

mod format;
mod metaimage;
mod nifti;
mod npy;
mod nrrd;
mod options;
mod raw;
mod voxels;

use crate::Volume;
use crate::error::{Error, ErrorKind, Remedy};
use crate::read::MemoryFiles;
use std::io::{self, Write};

pub use format::Format;
pub use options::WriteOptions;
pub use raw::value_type;
use voxels::Voxels;

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
    let volumes = std::slice::from_ref(volume);
    write_components(name, volumes, options, files)
}

/// As [`write()`] of a volume with several numbers per voxel: one volume for each, which differ in nothing but their
/// samples, as [`read_components`](crate::read::read_components) gives them. They are colors if their metadata says
/// so. NIfTI and MetaImage have colors of 8 bits only; other ones become vectors.
///
/// # Errors
/// As [`write()`]; volumes of different grids or types; several of them for a format with one number per voxel.
pub fn write_components(
    name: &str,
    volumes: &[Volume],
    options: &WriteOptions,
    files: &mut dyn NewFiles,
) -> Result<(), Error> {
    let in_file = |error: Error| error.in_file(name);
    let voxels = Voxels::new(volumes).map_err(in_file)?;
    let voxels = &voxels;
    let create = |files: &mut dyn NewFiles, name: &str, body: &mut Body| {
        let mut out = files
            .create(name)
            .map_err(|e| Error::from(e).in_file(name))?;
        body(&mut *out).map_err(|error| error.in_file(name))?;
        out.flush().map_err(|e| Error::from(e).in_file(name))
    };
    let format = Format::of_name(name).map_err(in_file)?;
    if volumes.len() > 1 && !format.keeps_components() {
        return Err(in_file(no_components(volumes.len())));
    }
    match format {
        Format::Nifti => create(files, name, &mut |out| {
            nifti::write(voxels, options, false, out)
        }),
        Format::NiftiGz => create(files, name, &mut |out| {
            nifti::write(voxels, options, true, out)
        }),
        Format::Nrrd => create(files, name, &mut |out| nrrd::write(voxels, options, out)),
        Format::Mha => create(files, name, &mut |out| {
            metaimage::write(voxels, options, out)
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
                metaimage::write_samples(voxels, options, out)
            })?;
            create(files, name, &mut |out| {
                Ok(out.write_all(metaimage::header(voxels, options, &data, None).as_bytes())?)
            })
        }
        Format::Npy => create(files, name, &mut |out| npy::write(voxels, out)),
        Format::Raw => create(files, name, &mut |out| {
            raw::write_values(voxels, raw::Packing::None, out)
        }),
    }
}

fn no_components(count: usize) -> Error {
    Error::from(ErrorKind::Unsupported {
        feature: format!("a file of this format with {count} numbers per voxel"),
        instead: "write .nrrd, .nii, .mha or .mhd, or one of the components".into(),
    })
    .with_remedy(Remedy::Component)
}

type Body<'a> = dyn FnMut(&mut dyn Write) -> Result<(), Error> + 'a;
