//! Bytes in, volumes out. No reader touches the file system: what it needs comes through [`Files`].

mod bit_fields;
mod block;
mod dat;
mod data_files;
#[cfg(feature = "dicom")]
pub mod dicom;
mod header_lines;
pub mod mesh;
mod metaimage;
mod nifti;
mod npy;
mod nrrd;
mod options;
mod png;
mod pvm;
mod raw;
mod slices;
mod sniff;
#[cfg(feature = "tiff")]
mod tiff;
mod unoriented;
mod unpacked;

use crate::{Error, ErrorKind, Label, Volume};
use options::Open;
use sniff::Kind;
use std::collections::BTreeMap;
use std::io;

pub use options::{RawLayout, ReadOptions};

/// The bytes of one file, read by position, so that samples go straight to where they stay.
pub trait Bytes: Send + Sync {
    /// Number of bytes.
    fn len(&self) -> u64;

    /// Whether there is no byte.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Fills `into` from `offset` on.
    ///
    /// # Errors
    /// `UnexpectedEof` if the file ends before, or what the system says.
    fn read_at(&self, offset: u64, into: &mut [u8]) -> io::Result<()>;
}

impl Bytes for [u8] {
    fn len(&self) -> u64 {
        self.len() as u64
    }

    fn read_at(&self, offset: u64, into: &mut [u8]) -> io::Result<()> {
        let source = usize::try_from(offset)
            .ok()
            .and_then(|start| self.get(start..start.checked_add(into.len())?))
            .ok_or(io::ErrorKind::UnexpectedEof)?;
        into.copy_from_slice(source);
        Ok(())
    }
}

impl<B: Bytes + ?Sized> Bytes for &B {
    fn len(&self) -> u64 {
        (**self).len()
    }

    fn read_at(&self, offset: u64, into: &mut [u8]) -> io::Result<()> {
        (**self).read_at(offset, into)
    }
}

impl Bytes for Vec<u8> {
    fn len(&self) -> u64 {
        self.as_slice().len() as u64
    }

    fn read_at(&self, offset: u64, into: &mut [u8]) -> io::Result<()> {
        self.as_slice().read_at(offset, into)
    }
}

/// A folder, or a list of files, as a reader sees it: names without folders, and their bytes.
pub trait Files: Sync {
    /// The names, sorted.
    fn names(&self) -> Vec<String>;

    /// Opens a file by name.
    ///
    /// # Errors
    /// `NotFound` for an unknown name, or what the system says.
    fn open(&self, name: &str) -> io::Result<Box<dyn Bytes + '_>>;
}

/// Files that are already in memory.
pub type MemoryFiles = BTreeMap<String, Vec<u8>>;

impl Files for MemoryFiles {
    fn names(&self) -> Vec<String> {
        self.keys().cloned().collect()
    }

    fn open(&self, name: &str) -> io::Result<Box<dyn Bytes + '_>> {
        match self.get(name) {
            Some(bytes) => Ok(Box::new(bytes.as_slice())),
            None => Err(io::ErrorKind::NotFound.into()),
        }
    }
}

/// What a file held.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The grid.
    pub volume: Volume,
    /// Names and colours of the objects, if the file says that its numbers are object ids.
    pub labels: Option<Vec<Label>>,
    /// What the user should know: slices left out, fields that were put right.
    pub notes: Vec<String>,
}

/// Reads the volume that starts with the file `name` of `files` (a header may name siblings).
/// The kind of file is found from its bytes, and from its name only where the bytes say nothing.
/// A whole file packed with gzip or bzip2 is unpacked on the way.
///
/// # Errors
/// Whatever is wrong with the file, with its name in front.
pub fn read_file(name: &str, files: &dyn Files, options: &ReadOptions) -> Result<Loaded, Error> {
    let in_file = |error: Error| error.in_file(name);
    let bytes = files.open(name).map_err(|error| in_file(error.into()))?;
    let input = Input {
        name,
        bytes: &*bytes,
        files,
    };
    read_input(&input, options).map_err(in_file)
}

/// Reads the one volume that all of `files` make together: a DICOM series, or numbered slices.
/// `name` is what the folder is called in messages.
///
/// # Errors
/// Whatever is wrong with the files; no volume in them; several, none picked by `options.series`.
pub fn read_folder(name: &str, files: &dyn Files, options: &ReadOptions) -> Result<Loaded, Error> {
    folder(name, files, options).map_err(|error| error.in_file(name))
}

/// What every reader gets: the file, and its siblings for headers that name other files.
pub(crate) struct Input<'a> {
    /// The file's name, without folders.
    pub(crate) name: &'a str,
    /// Its bytes (unpacked, if the whole file was packed).
    pub(crate) bytes: &'a dyn Bytes,
    /// The files beside it.
    pub(crate) files: &'a dyn Files,
}

fn read_input(input: &Input, options: &ReadOptions) -> Result<Loaded, Error> {
    let kind = sniff::kind(input.bytes)?;
    match kind {
        Some(Kind::Packed(encoding)) => {
            // NIfTI unpacks its own samples in one go, because it is usually packed.
            let start = block::head(input.bytes, 0, encoding, sniff::HEAD_BYTES)?;
            if encoding == block::Encoding::Gzip
                && sniff::kind(&start)?.is_some_and(|kind| kind == Kind::Nifti)
            {
                return read_kind(Kind::Nifti, input, options);
            }
            unpacked::read(input, encoding, options)
        }
        Some(kind) => read_kind(kind, input, options),
        None => read_unknown(input, options),
    }
}

fn read_kind(kind: Kind, input: &Input, options: &ReadOptions) -> Result<Loaded, Error> {
    if let Some((format, open)) = left_open(kind) {
        options.check(format, open)?;
    }
    match kind {
        Kind::Nifti => nifti::read(input, options),
        Kind::Nrrd => nrrd::read(input, options),
        Kind::MetaImage => metaimage::read(input, options),
        Kind::Dat => dat::read(input, options),
        Kind::Pvm => pvm::read(input, options),
        Kind::Npy => npy::read(input, options),
        #[cfg(feature = "tiff")]
        Kind::Tiff => tiff::read(input, options),
        #[cfg(not(feature = "tiff"))]
        Kind::Tiff => Err(not_built_in("TIFF", "tiff")),
        Kind::Png => slices::read_one(input, options),
        #[cfg(feature = "dicom")]
        Kind::Dicom => dicom::read_file(input, options),
        #[cfg(not(feature = "dicom"))]
        Kind::Dicom => Err(not_built_in("DICOM", "dicom")),
        Kind::MaybeDicom | Kind::MaybeAnalyze => read_unknown(input, options),
        Kind::Packed(encoding) => Err(ErrorKind::Unsupported {
            feature: format!("{encoding:?} inside {encoding:?}"),
            instead: "unpack the file first".into(),
        }
        .into()),
        Kind::Foreign { what, instead } => Err(ErrorKind::Unsupported {
            feature: what.into(),
            instead: instead.into(),
        }
        .into()),
    }
}

/// What a kind is called, and what its files leave for the user to say. The other kinds are not
/// read, or looked at more closely first.
fn left_open(kind: Kind) -> Option<(&'static str, &'static [Open])> {
    Some(match kind {
        Kind::Nifti => ("NIfTI", &[Open::Time]),
        Kind::Nrrd => ("NRRD", &[Open::Time]),
        Kind::MetaImage => ("MetaImage", &[Open::Time]),
        Kind::Npy => ("npy", &[Open::Time, Open::Spacing]),
        Kind::Tiff => ("TIFF", &[Open::Time, Open::Spacing]),
        Kind::Png => ("PNG", &[Open::Spacing]),
        Kind::Dat => (".dat", &[Open::Endian, Open::Spacing]),
        Kind::Pvm => ("PVM", &[Open::Spacing]),
        Kind::Dicom => ("DICOM", DICOM_LEAVES_OPEN),
        Kind::MaybeDicom | Kind::MaybeAnalyze | Kind::Packed(_) | Kind::Foreign { .. } => {
            return None;
        }
    })
}

const DICOM_LEAVES_OPEN: &[Open] = &[Open::Time, Open::Series, Open::Spacing];

/// The bytes say nothing, or not enough: the name decides.
fn read_unknown(input: &Input, options: &ReadOptions) -> Result<Loaded, Error> {
    let name = input.name.to_ascii_lowercase();
    let is_raw = options.raw.dims.is_some()
        || name.ends_with(".raw")
        || name.ends_with(".bin")
        || raw::layout_of_name(input.name).is_some();
    // The samples of a pair: the header beside them says what they are.
    if let Some(stem) = name.strip_suffix(".img")
        && let Some(header) = nifti::sibling(input, &input.name[..stem.len()], ".hdr")
    {
        return read_file(&header, input.files, options);
    }
    match sniff::kind(input.bytes)? {
        Some(Kind::MaybeAnalyze) if !is_raw => read_kind(Kind::Nifti, input, options),
        Some(Kind::MaybeDicom) if !is_raw => read_kind(Kind::Dicom, input, options),
        _ if is_raw => {
            options.check("raw", &[Open::Layout, Open::Endian, Open::Spacing])?;
            raw::read(input, options)
        }
        _ => Err(ErrorKind::Unknown {
            why: sniff::describe(input.bytes)?,
        }
        .into()),
    }
}

fn folder(name: &str, files: &dyn Files, options: &ReadOptions) -> Result<Loaded, Error> {
    let (mut has_dicom, mut pictures, mut others) = (false, Vec::new(), Vec::new());
    for file in files.names() {
        let bytes = files
            .open(&file)
            .map_err(|e| Error::from(e).in_file(&file))?;
        match sniff::kind(&*bytes).map_err(|e| e.in_file(&file))? {
            Some(Kind::Dicom | Kind::MaybeDicom) => has_dicom = true,
            Some(Kind::Tiff | Kind::Png) => pictures.push(file),
            _ => others.push(file),
        }
    }
    if has_dicom {
        options.check("DICOM", DICOM_LEAVES_OPEN)?;
        #[cfg(feature = "dicom")]
        return dicom::read_folder(name, files, options);
        #[cfg(not(feature = "dicom"))]
        return Err(not_built_in("DICOM", "dicom"));
    }
    if !pictures.is_empty() {
        options.check("TIFF or PNG", &[Open::Time, Open::Spacing])?;
        return slices::read_pictures(name, files, pictures, &others, options);
    }
    Err(ErrorKind::Unknown {
        why: format!(
            "the folder holds {} files, none of them DICOM, TIFF or PNG; name a single file to read another format",
            others.len()
        ),
    }
    .into())
}

#[cfg(not(all(feature = "tiff", feature = "dicom")))]
fn not_built_in(format: &str, feature: &str) -> Error {
    ErrorKind::Unsupported {
        feature: format!("{format} in this build"),
        instead: format!("build with the feature `{feature}`"),
    }
    .into()
}
