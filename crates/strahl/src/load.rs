//! Reads volumes from paths.

use crate::Error;
use crate::confinement::{Confinement, open_regular};
use crate::folder::{Folder, file_name};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, SystemTime};
use strahl_volume::read::{
    Bytes, Files, LoadedComponents, LoadedVolume, ReadOptions, read_components, read_file_under,
    read_folder_under, read_label_table,
};
use strahl_volume::{Control, Label, Remedy};

/// Reads the volume at `path`: a file, a header with its siblings, or a folder that holds one DICOM
/// series or numbered slices.
///
/// # Errors
/// If `path` does not exist, or any problem with the file; the message names file and field.
pub fn load(path: impl AsRef<Path>, options: &ReadOptions) -> Result<LoadedVolume, Error> {
    load_under(&[path.as_ref().to_owned()], options, &Control::NONE)
}

/// Reads names and colors of labels from a file in one of the formats of [`read_label_table`].
///
/// # Errors
/// If there is no such file, it is larger than 16 MiB, or whatever is wrong with it, by line or key.
pub fn load_label_table(path: impl AsRef<Path>) -> Result<Vec<Label>, Error> {
    const MOST_BYTES: u64 = 1 << 24;
    let path = path.as_ref();
    let fail = |error| Error::path(path, error);
    let mut bytes = Vec::new();
    let mut file = open_regular(path).map_err(fail)?.take(MOST_BYTES + 1);
    file.read_to_end(&mut bytes).map_err(fail)?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(Error::not_usable(
            path,
            "no label table: larger than 16 MiB",
        ));
    }
    Ok(read_label_table(&path.display().to_string(), &bytes)?)
}

/// Reads one volume from `paths`: as [`load`] for a single path, otherwise the slices of one
/// series in any order. `control` receives the fraction of the bytes that has been read.
///
/// # Errors
/// As [`load`]; if `paths` is empty, names a file twice, or names a folder among files; `control` was cancelled.
pub fn load_under(
    paths: &[PathBuf],
    options: &ReadOptions,
    control: &Control,
) -> Result<LoadedVolume, Error> {
    Ok(load_seen(paths, options, None, control)?.0)
}

/// As [`load_under`], with all numbers of each voxel: a volume for each of them. `options` pick no component.
///
/// # Errors
/// As [`load_under`].
pub fn load_components_under(
    paths: &[PathBuf],
    options: &ReadOptions,
    control: &Control,
) -> Result<LoadedComponents, Error> {
    let mut read = |component| {
        let options = ReadOptions {
            component,
            ..options.clone()
        };
        load_under(paths, &options, control)
    };
    let wants_component = |error: &Error| match error {
        Error::Volume(error) => error.remedy() == Some(Remedy::Component),
        _ => false,
    };
    read_components(&mut read, wants_component)
}

/// As [`load_under`], with what was seen of the files, all of which lie `within`.
pub(crate) fn load_seen(
    paths: &[PathBuf],
    options: &ReadOptions,
    within: Option<&Confinement>,
    control: &Control,
) -> Result<(LoadedVolume, Seen), Error> {
    let is_folder = |path: &PathBuf| {
        let metadata = fs::metadata(path).map_err(|error| Error::path(path, error))?;
        Ok::<_, Error>(metadata.is_dir())
    };
    let (name, folder, is_file) = match paths {
        [] => return Err(Error::NoVolume { scene: None }),
        [path] if is_folder(path)? => (path.display().to_string(), Folder::of(path)?, false),
        [path] => (file_name(path), Folder::around(path), true),
        [first, others @ ..] => {
            let name = format!("{} and {} more", first.display(), others.len());
            (name, Folder::of_files(paths)?, false)
        }
    };
    let recorded = RecordingFiles {
        folder,
        within,
        opened: Mutex::default(),
        listed: Mutex::default(),
    };
    let loaded = match is_file {
        true => read_file_under(&name, &recorded, options, control),
        false => read_folder_under(&name, &recorded, options, control),
    };
    let loaded = loaded.map_err(|error| match paths {
        [path] if is_file => error.in_folder(path.parent().unwrap_or(Path::new(""))),
        _ => error,
    });
    Ok((loaded?, recorded.seen()))
}

/// Files and folders as they were when something was read from them.
#[derive(Default)]
pub(crate) struct Seen {
    opened: Vec<FileState>,
    listed: Vec<Listing>,
}

impl Seen {
    /// Whether reading again would read the same.
    pub fn is_same(&self) -> bool {
        self.opened.iter().all(FileState::is_same) && self.listed.iter().all(Listing::is_same)
    }

    pub fn extend(&mut self, other: Seen) {
        self.opened.extend(other.opened);
        self.listed.extend(other.listed);
    }
}

/// A file as it was when it was opened.
struct FileState {
    path: PathBuf,
    state: Option<(u64, Option<SystemTime>)>,
}

impl FileState {
    fn new(path: PathBuf) -> FileState {
        FileState {
            state: state(&path),
            path,
        }
    }

    /// Whether length and modification time are unchanged.
    pub fn is_same(&self) -> bool {
        self.state == state(&self.path)
    }
}

fn state(path: &Path) -> Option<(u64, Option<SystemTime>)> {
    let metadata = fs::metadata(path).ok()?;
    Some((metadata.len(), metadata.modified().ok()))
}

/// The names that a reader was given of the files in a folder. Only those count that end as a file that it opened does: a
/// picture that is written beside a series is no slice of it.
struct Listing {
    folder: Folder,
    is_below: bool,
    /// When the folder had last changed; not known with folders below.
    last_change: Option<SystemTime>,
    extensions: BTreeSet<String>,
    names: Vec<String>,
}

impl Listing {
    fn is_same(&self) -> bool {
        if self.last_change.is_some() && self.last_change == self.folder.last_change() {
            return true;
        }
        let now = match self.is_below {
            true => self.folder.names_below().unwrap_or_default(),
            false => self.folder.current_names(),
        };
        now.iter()
            .filter(|name| self.extensions.contains(extension(name)))
            .eq(&self.names)
    }
}

/// The names that a reader was given, and when the folder had last changed.
struct GivenNames {
    names: Vec<String>,
    last_change: Option<SystemTime>,
}

/// What stands behind the last dot of a name; nothing if it has none.
fn extension(name: &str) -> &str {
    let extension = Path::new(name).extension();
    extension.and_then(|text| text.to_str()).unwrap_or_default()
}

/// Records which files are opened, and which names are given.
struct RecordingFiles<'w> {
    folder: Folder,
    within: Option<&'w Confinement>,
    opened: Mutex<BTreeMap<String, FileState>>,
    /// In the folder, and in it and below.
    listed: Mutex<[Option<GivenNames>; 2]>,
}

impl RecordingFiles<'_> {
    fn seen(self) -> Seen {
        let opened = self.opened.into_inner();
        let opened = opened.unwrap_or_else(PoisonError::into_inner);
        let listed = self.listed.into_inner();
        let listed = listed.unwrap_or_else(PoisonError::into_inner);
        let extensions: BTreeSet<String> = opened
            .keys()
            .map(|name| extension(name).to_owned())
            .collect();
        let listing = |(given, is_below): (Option<GivenNames>, bool)| {
            let GivenNames {
                mut names,
                last_change,
            } = given?;
            names.retain(|name| extensions.contains(extension(name)));
            Some(Listing {
                folder: self.folder.clone(),
                is_below,
                last_change,
                extensions: extensions.clone(),
                names,
            })
        };
        let listed = listed.into_iter().zip([false, true]);
        Seen {
            listed: listed.filter_map(listing).collect(),
            opened: opened.into_values().collect(),
        }
    }

    fn note_names(&self, is_below: bool, names: &[String], last_change: Option<SystemTime>) {
        let mut listed = self.listed.lock().unwrap_or_else(PoisonError::into_inner);
        listed[usize::from(is_below)].get_or_insert_with(|| GivenNames {
            names: names.to_vec(),
            last_change,
        });
    }
}

/// How coarse the clocks of file systems are, at worst: FAT counts in steps of two seconds.
const CLOCK_STEP: Duration = Duration::from_secs(2);

/// A time that tells apart what follows it from what was before: `time`, if the clock has gone on since.
fn settled(time: SystemTime) -> Option<SystemTime> {
    let has_gone_on = time.elapsed().is_ok_and(|elapsed| elapsed > CLOCK_STEP);
    has_gone_on.then_some(time)
}

impl Files for RecordingFiles<'_> {
    fn names(&self) -> Vec<String> {
        // Before it is listed: what is added meanwhile is a change.
        let last_change = self.folder.last_change().and_then(settled);
        let names = self.folder.names();
        self.note_names(false, &names, last_change);
        names
    }

    fn names_below(&self) -> io::Result<Vec<String>> {
        let names = self.folder.names_below()?;
        self.note_names(true, &names, None);
        Ok(names)
    }

    fn open(&self, name: &str) -> io::Result<Box<dyn Bytes + '_>> {
        let path = self.folder.path_of(name)?;
        if let Some(within) = self.within {
            within.check(&path).map_err(io::Error::other)?;
        }
        // Before it is read: what changes meanwhile has changed.
        let mut opened = self.opened.lock().unwrap_or_else(PoisonError::into_inner);
        opened
            .entry(name.to_owned())
            .or_insert_with(|| FileState::new(path));
        self.folder.open(name)
    }
}
