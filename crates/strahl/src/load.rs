//! From paths to a volume.

use crate::Error;
use crate::folder::{Folder, file_name};
use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use strahl_volume::read::{Bytes, Files, Loaded, ReadOptions, read_file, read_folder};

/// Reads the volume at `path`: a file, a header with its siblings, or a folder that holds one DICOM
/// series or numbered slices.
///
/// # Errors
/// If there is nothing at `path`, or whatever is wrong with the file, by name and field.
pub fn load(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Loaded, Error> {
    load_with_progress(&[path.as_ref().to_owned()], options, &|_| ())
}

/// Reads one volume from `paths`: as [`load`] if there is one, else the slices of one series in any
/// order. `progress` is told, from any thread, which share of the bytes has been read (0 to 1).
///
/// # Errors
/// As [`load`]; if `paths` is empty, names a file twice, or names a folder among files.
pub fn load_with_progress(
    paths: &[PathBuf],
    options: &ReadOptions,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Loaded, Error> {
    match paths {
        [] => Err(Error::NoVolume { scene: None }),
        [path] => {
            let metadata = fs::metadata(path).map_err(|error| Error::path(path, error))?;
            if metadata.is_dir() {
                let folder = Watched::new(Folder::of(path)?, progress);
                Ok(read_folder(&path.display().to_string(), &folder, options)?)
            } else {
                let folder = Watched::new(Folder::around(path), progress);
                Ok(read_file(&file_name(path), &folder, options)?)
            }
        }
        [first, others @ ..] => {
            let name = format!("{} and {} more", first.display(), others.len());
            let folder = Watched::new(Folder::of_files(paths)?, progress);
            Ok(read_folder(&name, &folder, options)?)
        }
    }
}

/// Counts the bytes that a reader takes.
struct Watched<'a> {
    folder: Folder,
    progress: &'a (dyn Fn(f64) + Sync),
    read: AtomicU64,
    total: AtomicU64,
    /// Files whose length is in `total`; a reader may open one several times.
    known: Mutex<BTreeSet<String>>,
}

impl Watched<'_> {
    fn new(folder: Folder, progress: &(dyn Fn(f64) + Sync)) -> Watched<'_> {
        Watched {
            total: folder.total_len().into(),
            folder,
            progress,
            read: 0.into(),
            known: Mutex::default(),
        }
    }
}

impl Files for Watched<'_> {
    fn names(&self) -> Vec<String> {
        self.folder.names()
    }

    fn open(&self, name: &str) -> io::Result<Box<dyn Bytes + '_>> {
        let bytes = self.folder.open(name)?;
        if self.folder.total_len() == 0
            && let Ok(mut known) = self.known.lock()
            && known.insert(name.to_owned())
        {
            self.total.fetch_add(bytes.len(), Ordering::Relaxed);
        }
        Ok(Box::new(WatchedBytes {
            bytes,
            watched: self,
        }))
    }
}

struct WatchedBytes<'a> {
    bytes: Box<dyn Bytes + 'a>,
    watched: &'a Watched<'a>,
}

impl Bytes for WatchedBytes<'_> {
    fn len(&self) -> u64 {
        self.bytes.len()
    }

    fn read_at(&self, offset: u64, into: &mut [u8]) -> io::Result<()> {
        /// Large enough to cost nothing, small enough to show progress.
        const PIECE: usize = 16 << 20;
        let mut offset = offset;
        for piece in into.chunks_mut(PIECE) {
            self.bytes.read_at(offset, piece)?;
            offset += piece.len() as u64;
            let watched = self.watched;
            let before = watched
                .read
                .fetch_add(piece.len() as u64, Ordering::Relaxed);
            let total = watched.total.load(Ordering::Relaxed).max(1);
            (watched.progress)(((before + piece.len() as u64) as f64 / total as f64).min(1.0));
        }
        Ok(())
    }
}
