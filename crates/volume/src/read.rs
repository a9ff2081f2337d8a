//! Bytes in, volumes out. No reader touches the file system: what it needs comes through [`Files`].

mod base64;
mod bit_fields;
mod block;
mod bmp;
mod components;
mod dat;
mod data_files;
#[cfg(feature = "dicom")]
pub mod dicom;
mod foreign;
mod header_lines;
mod input;
#[cfg(feature = "dicom")]
mod jpeg;
mod label_tables;
mod loaded;
mod masks;
pub mod mesh;
mod metaimage;
mod mgh;
mod mrc;
mod nifti;
mod npy;
mod npz;
mod nrrd;
mod options;
mod png;
mod pvm;
mod raw;
mod slices;
mod sniff;
mod stored;
#[cfg(feature = "tiff")]
mod tiff;
mod unoriented;
mod unpacked;
mod vti;
mod vtk;
mod watched;
mod xml;

use crate::{Control, Error, ErrorKind};
use foreign::Foreign;
use options::Open;
use sniff::Kind;
use watched::{Watched, uncancelled};

pub use components::read_components;
pub(crate) use input::Input;
pub use input::{Bytes, Files, MemoryFiles};
pub use label_tables::{read_label_table, stem_of};
pub use loaded::{LoadedComponents, LoadedVolume};
pub use options::{RawLayout, ReadOptions};

/// Reads the volume that starts with the file `name` of `files` (a header may name siblings).
/// The kind of file is found from its bytes, and from its name only where the bytes say nothing.
/// A whole file packed with gzip or bzip2 is unpacked on the way.
///
/// Labels get names and colors from a table beside the file, if there is one: `organs.json` beside
/// `organs.nii.gz`, for example. [`read_label_table`] lists the formats.
///
/// # Errors
/// Whatever is wrong with the file, with its name in front.
pub fn read_file(
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<LoadedVolume, Error> {
    let mut loaded = read_volume(name, files, options)?;
    if options.label_table.is_some() {
        loaded.labels.clone_from(&options.label_table);
    } else if options.as_labels || loaded.labels.is_some() {
        let added = label_tables::add_beside(&mut loaded, name, files);
        added.map_err(|error| error.in_file(name))?;
    }
    Ok(loaded)
}

/// The volume of a file, with the labels that it names itself.
fn read_volume(
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<LoadedVolume, Error> {
    let in_file = |error: Error| error.in_file(name);
    let bytes = files.open(name).map_err(|error| in_file(error.into()))?;
    let input = Input {
        name,
        bytes: &*bytes,
        files,
    };
    read_input(&input, options).map_err(in_file)
}

/// Reads the one volume that all of `files` make together: a DICOM series, or numbered slices. If none of them is
/// one, a DICOM series is looked for in the folders below, as archives and the CDs of patients have it.
/// Without one, volumes of zeros and one other number are masks: labels with the names of the files.
/// `name` is what the folder is called in messages.
///
/// # Errors
/// Whatever is wrong with the files; no volume in them; several, none picked by `options.series`.
pub fn read_folder(
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<LoadedVolume, Error> {
    let mut loaded = folder(name, files, options).map_err(|error| error.in_file(name))?;
    if options.label_table.is_some() {
        loaded.labels.clone_from(&options.label_table);
    } else if options.as_labels {
        loaded.labels.get_or_insert_default();
    }
    Ok(loaded)
}

/// As [`read_file`] under `control`, which is told the share of the bytes that has been read. The values of the
/// volume have been counted.
///
/// # Errors
/// As [`read_file`]; it was cancelled.
pub fn read_file_under(
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
    control: &Control,
) -> Result<LoadedVolume, Error> {
    let read = read_file(name, &Watched::new(files, control), options);
    counted(read, control)
}

/// As [`read_folder`] under `control`, as [`read_file_under`] has it.
///
/// # Errors
/// As [`read_folder`]; it was cancelled.
pub fn read_folder_under(
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
    control: &Control,
) -> Result<LoadedVolume, Error> {
    let read = read_folder(name, &Watched::new(files, control), options);
    counted(read, control)
}

fn counted(read: Result<LoadedVolume, Error>, control: &Control) -> Result<LoadedVolume, Error> {
    let loaded = uncancelled(read, control)?;
    loaded.volume.statistics_under(control)?;
    Ok(loaded)
}

fn read_input(input: &Input, options: &ReadOptions) -> Result<LoadedVolume, Error> {
    let kind = sniff::kind(input.bytes)?;
    match kind {
        Some(Kind::Packed(encoding)) => {
            if let Some(header) = header_of_samples(input) {
                return read_volume(&header, input.files, options);
            }
            // NIfTI unpacks its own samples in one go, because it is usually packed.
            let start = block::head(input.bytes, 0, encoding, sniff::HEAD_BYTES)?;
            if encoding == block::Encoding::Gzip
                && sniff::kind(&start)?.is_some_and(|kind| kind == Kind::Nifti)
            {
                return read_kind(Kind::Nifti, input, options);
            }
            unpacked::read(input, encoding, &|kind, input| match kind {
                Some(kind) => read_kind(kind, input, options),
                None => read_unknown(input, options),
            })
        }
        Some(kind) => read_kind(kind, input, options),
        None => read_unknown(input, options),
    }
}

fn read_kind(kind: Kind, input: &Input, options: &ReadOptions) -> Result<LoadedVolume, Error> {
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
        Kind::Tiff => Err(Error::not_built_in("TIFF", "tiff")),
        Kind::Png | Kind::Bmp | Kind::Jpeg => slices::read_one(kind, input, options),
        #[cfg(feature = "dicom")]
        Kind::Dicom => dicom::read_file(input, options),
        #[cfg(not(feature = "dicom"))]
        Kind::Dicom => Err(Error::not_built_in("DICOM", "dicom")),
        Kind::MaybeDicom | Kind::MaybeAnalyze => read_unknown(input, options),
        Kind::Packed(encoding) => Err(ErrorKind::Unsupported {
            feature: format!("{encoding:?} inside {encoding:?}"),
            instead: "unpack the file first".into(),
        }
        .into()),
        Kind::Mgh => mgh::read(input, options),
        Kind::Vtk => vtk::read(input, options),
        Kind::Vti => vti::read(input, options),
        Kind::Mrc => mrc::read(input, options),
        Kind::Zip if npz::is_npz(input.bytes) => npz::read(input, options),
        Kind::Zip => Err(not_read(Foreign {
            what: "a zip archive without arrays of NumPy",
            instead: "unpack it first",
        })),
        Kind::Foreign(foreign) => Err(not_read(foreign)),
    }
}

/// What a kind is called, and what its files leave for the user to say. The other kinds are not
/// read, or looked at more closely first.
fn left_open(kind: Kind) -> Option<(&'static str, &'static [Open])> {
    Some(match kind {
        Kind::Nifti => ("NIfTI", &[Open::Time, Open::Component]),
        Kind::Nrrd => ("NRRD", &[Open::Time, Open::Component]),
        Kind::MetaImage => ("MetaImage", &[Open::Time, Open::Component]),
        Kind::Npy => ("npy", &[Open::Time, Open::Spacing]),
        Kind::Tiff => ("TIFF", &[Open::Time, Open::Spacing, Open::Component]),
        Kind::Png | Kind::Bmp | Kind::Jpeg => ("picture", &[Open::Spacing, Open::Component]),
        Kind::Dat => (".dat", &[Open::Endian, Open::Spacing]),
        Kind::Pvm => ("PVM", &[Open::Spacing]),
        Kind::Dicom => ("DICOM", DICOM_LEAVES_OPEN),
        Kind::Mgh => ("MGH", &[Open::Time]),
        Kind::Vtk | Kind::Vti => ("VTK", &[Open::Spacing, Open::Component]),
        Kind::Mrc => ("MRC", &[Open::Time, Open::Spacing]),
        Kind::Zip => ("npz", &[Open::Time, Open::Spacing]),
        Kind::MaybeDicom | Kind::MaybeAnalyze | Kind::Packed(_) | Kind::Foreign(_) => {
            return None;
        }
    })
}

const DICOM_LEAVES_OPEN: &[Open] = &[Open::Time, Open::Series, Open::Spacing, Open::Component];

fn not_read(Foreign { what, instead }: Foreign) -> Error {
    ErrorKind::Unsupported {
        feature: what.into(),
        instead: instead.into(),
    }
    .into()
}

/// The bytes say nothing, or not enough: the name decides.
fn read_unknown(input: &Input, options: &ReadOptions) -> Result<LoadedVolume, Error> {
    let name = input.name.to_ascii_lowercase();
    let is_raw = options.raw.dims.is_some()
        || name.ends_with(".raw")
        || name.ends_with(".bin")
        || raw::layout_of_name(input.name).is_some();
    if let Some(header) = header_of_samples(input) {
        return read_volume(&header, input.files, options);
    }
    match sniff::kind(input.bytes)? {
        Some(Kind::MaybeAnalyze) if !is_raw => read_kind(Kind::Nifti, input, options),
        Some(Kind::MaybeDicom) if !is_raw => read_kind(Kind::Dicom, input, options),
        _ if is_raw => {
            options.check("raw", &[Open::Layout, Open::Endian, Open::Spacing])?;
            raw::read(input, options)
        }
        _ if let Some(foreign) = foreign::of_name(input.name) => Err(not_read(foreign)),
        _ => Err(ErrorKind::Unknown {
            why: sniff::describe(input.bytes)?,
        }
        .into()),
    }
}

/// The header beside the samples of a pair, which says what they are.
fn header_of_samples(input: &Input) -> Option<String> {
    let name = input.name.to_ascii_lowercase();
    let stem = name
        .strip_suffix(".gz")
        .unwrap_or(&name)
        .strip_suffix(".img")?;
    let stem = &input.name[..stem.len()];
    nifti::sibling(input, stem, ".hdr").or_else(|| nifti::sibling(input, stem, ".hdr.gz"))
}

fn folder(name: &str, files: &dyn Files, options: &ReadOptions) -> Result<LoadedVolume, Error> {
    let (mut has_dicom, mut pictures, mut others) = (false, Vec::new(), Vec::new());
    let mut volumes = Vec::new();
    for file in files.names() {
        let bytes = files
            .open(&file)
            .map_err(|e| Error::from(e).in_file(&file))?;
        match content(&*bytes).map_err(|e| e.in_file(&file))? {
            Some(Kind::Dicom | Kind::MaybeDicom) => has_dicom = true,
            Some(Kind::Tiff | Kind::Png | Kind::Bmp | Kind::Jpeg) => pictures.push(file),
            kind => {
                if let Some(kind) = kind.filter(Kind::is_volume) {
                    volumes.push((file.clone(), kind));
                }
                others.push(file);
            }
        }
    }
    // Of files that lie side by side, one has to be chosen; what lies deeper is no better choice.
    let below = match has_dicom || !pictures.is_empty() || !volumes.is_empty() {
        true => Vec::new(),
        false => names_in_folders(files)?,
    };
    for file in &below {
        let bytes = files.open(file).map_err(|e| Error::from(e).in_file(file))?;
        let kind = content(&*bytes).map_err(|e| e.in_file(file))?;
        has_dicom |= matches!(kind, Some(Kind::Dicom | Kind::MaybeDicom));
        if has_dicom {
            break;
        }
    }
    if has_dicom {
        options.check("DICOM", DICOM_LEAVES_OPEN)?;
        #[cfg(feature = "dicom")]
        return dicom::read_folder(name, files, options);
        #[cfg(not(feature = "dicom"))]
        return Err(Error::not_built_in("DICOM", "dicom"));
    }
    if !pictures.is_empty() {
        options.check("picture", &[Open::Time, Open::Spacing, Open::Component])?;
        let mut loaded = match pictures.as_slice() {
            [only] => read_volume(only, files, options)?,
            _ => slices::read_pictures(name, files, pictures, options)?,
        };
        loaded.notes.extend(slices::note_of_others(&others));
        return Ok(loaded);
    }
    let masks = masks::among(&volumes);
    let volumes: Vec<String> = volumes.into_iter().map(|(name, _)| name).collect();
    if !masks.is_empty() {
        options.check("mask", &[])?;
        let read = |mask: &str| read_volume(mask, files, &ReadOptions::default());
        return masks::read(name, &others, &masks, &read, &volumes_in_folder(&volumes));
    }
    let why = match (volumes.is_empty(), others.is_empty()) {
        (false, _) => volumes_in_folder(&volumes),
        (true, true) => no_files(&below),
        (true, false) => format!(
            "the folder has no volume that can be read as a folder: {} and no DICOM file or picture (TIFF, PNG, BMP, JPEG); name a single file to read another format",
            numbered(others.len(), "file")
        ),
    };
    Err(ErrorKind::Unknown { why }.into())
}

/// Why a folder of volume files is not read: the caller has to choose one of them.
fn volumes_in_folder(volumes: &[String]) -> String {
    const SHOWN: usize = 8;
    let names = volumes[..volumes.len().min(SHOWN)].join(", ");
    let more = if volumes.len() > SHOWN { ", …" } else { "" };
    format!(
        "there are {}: {names}{more}; name the one to read (only the files of a DICOM series, of a sequence of pictures, and masks are read together; `objects` of a scene draw several volumes)",
        numbered(volumes.len(), "volume file")
    )
}

/// `1 file`, `2 files`.
fn numbered(count: usize, noun: &str) -> String {
    match count {
        1 => format!("1 {noun}"),
        _ => format!("{count} {noun}s"),
    }
}

/// The kind of a file, or of what is packed in it.
fn content(bytes: &dyn Bytes) -> Result<Option<Kind>, Error> {
    match sniff::kind(bytes)? {
        Some(Kind::Packed(encoding)) => {
            let start = block::head(bytes, 0, encoding, sniff::HEAD_BYTES)?;
            let inside = sniff::kind(&start)?;
            let is_dicom = |kind| kind == Kind::Dicom && encoding == block::Encoding::Gzip;
            let is_known = |kind: &Kind| is_dicom(*kind) || kind.is_volume();
            Ok(inside.filter(is_known).or(Some(Kind::Packed(encoding))))
        }
        kind => Ok(kind),
    }
}

/// The files in folders below.
fn names_in_folders(files: &dyn Files) -> Result<Vec<String>, Error> {
    let mut names = files.names_below()?;
    names.retain(|name| name.contains('/'));
    Ok(names)
}

fn no_files(below: &[String]) -> String {
    const SHOWN: usize = 5;
    let mut folders: Vec<&str> = below
        .iter()
        .filter_map(|name| name.split('/').next())
        .collect();
    folders.dedup();
    let more = if folders.len() > SHOWN { ", …" } else { "" };
    match folders.len() {
        0 => "the folder is empty".into(),
        n => format!(
            "the folder holds no file, only folders without DICOM images; name one of them: {}{more}",
            folders[..n.min(SHOWN)].join(", ")
        ),
    }
}
