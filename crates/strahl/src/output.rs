//! Files that are either complete or absent: written next to their target, then renamed.

use crate::Error;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

/// Paths of the temporary files that exist now, for [`abandon_outputs`].
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A file that is being written. Until [`Output::finish`] the target is unchanged. Dropping it
/// removes the temporary file.
///
/// The disk is not flushed: this protects against a program that is stopped, not against a
/// power failure.
#[derive(Debug)]
pub struct Output {
    target: PathBuf,
    kind: Kind,
}

#[derive(Debug)]
enum Kind {
    Renamed(BufWriter<Part>),
    /// A device or pipe, which must not be replaced by a file. Kept in memory, since a picture is
    /// written with seeks.
    Device(io::Cursor<Vec<u8>>, File),
}

impl Output {
    /// Starts a file at `target`. Call it before long work, to detect early that the target
    /// cannot be written.
    ///
    /// # Errors
    /// If the folder does not exist or cannot be written, or `target` is a folder.
    pub fn create(target: &Path) -> Result<Output, Error> {
        let fail = |error| Error::path(target, error);
        let existing = match fs::metadata(target) {
            Ok(metadata) => Some(metadata),
            Err(e) if e.kind() == io::ErrorKind::NotFound => None,
            Err(e) => return Err(fail(e)),
        };
        // What a link points at is replaced, not the link, also if it is not there yet.
        let mut path = match &existing {
            Some(_) => target.to_owned(),
            None => behind_links(target).map_err(fail)?,
        };
        if let Some(metadata) = &existing {
            if metadata.is_dir() {
                return Err(Error::not_usable(
                    target,
                    "is a folder, not a file to write",
                ));
            }
            if metadata.permissions().readonly() {
                return Err(fail(io::ErrorKind::PermissionDenied.into()));
            }
            #[cfg(unix)]
            if std::os::unix::fs::FileTypeExt::is_fifo(&metadata.file_type()) {
                // Opening it would wait for a reader, perhaps for ever.
                return Err(Error::not_usable(target, "is a pipe, not a file to write"));
            }
            if !metadata.is_file() {
                let device = OpenOptions::new().write(true).open(target).map_err(fail)?;
                return Ok(Output {
                    target: path,
                    kind: Kind::Device(io::Cursor::default(), device),
                });
            }
            path = target.canonicalize().map_err(fail)?;
        }
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        if !folder.is_dir() {
            return Err(Error::not_usable(
                target,
                format!("cannot be written: there is no folder {}", folder.display()),
            ));
        }
        sweep(folder);
        let mut unfinished = UNFINISHED.lock().unwrap_or_else(|e| e.into_inner());
        let file = Part::new(folder)
            .and_then(|file| {
                if let Some(metadata) = &existing {
                    file.file.set_permissions(metadata.permissions())?;
                }
                Ok(file)
            })
            .map_err(|source| Error::not_usable(target, format!("cannot be written: {source}")))?;
        unfinished.push(file.path.clone());
        Ok(Output {
            target: path,
            kind: Kind::Renamed(BufWriter::with_capacity(1 << 16, file)),
        })
    }

    /// Removes what is there under the name of the target. Of files that belong together, the one that names the
    /// others goes before any of them gets its name: whoever ends in between leaves none that names what is not its
    /// own.
    ///
    /// # Errors
    /// If it is there and cannot be removed.
    pub fn remove_old(&self) -> Result<(), Error> {
        match (&self.kind, fs::remove_file(&self.target)) {
            (Kind::Device(..), _) | (_, Ok(())) => Ok(()),
            (_, Err(error)) if error.kind() == io::ErrorKind::NotFound => Ok(()),
            (_, Err(error)) => Err(Error::path(&self.target, error)),
        }
    }

    /// The folder that the file will lie in.
    pub fn folder(&self) -> &Path {
        self.target.parent().unwrap_or(Path::new(""))
    }

    /// Completes the file and replaces the target.
    ///
    /// # Errors
    /// If the last bytes cannot be written or the file cannot be renamed; nothing is left then.
    pub fn finish(mut self) -> Result<(), Error> {
        let finished = match &mut self.kind {
            Kind::Renamed(file) => file.flush().and_then(|()| {
                // Under the lock, so that an interrupt comes before or after, never between.
                let mut unfinished = UNFINISHED.lock().unwrap_or_else(|e| e.into_inner());
                let from = file.get_ref().path.clone();
                fs::rename(&from, &self.target)?;
                unfinished.retain(|path| *path != from);
                Ok(())
            }),
            Kind::Device(bytes, device) => device.write_all(bytes.get_ref()),
        };
        finished.map_err(|error| Error::path(&self.target, error))
    }
}

/// Where a link that points at nothing leads, over further links.
fn behind_links(path: &Path) -> io::Result<PathBuf> {
    /// More are taken for a circle, as the system does.
    const MOST_LINKS: usize = 40;
    let mut path = path.to_owned();
    for _ in 0..MOST_LINKS {
        let Ok(next) = fs::read_link(&path) else {
            return Ok(path);
        };
        path = match path.parent() {
            Some(folder) => folder.join(next),
            None => next,
        };
    }
    Err(io::Error::other("links that lead back to themselves"))
}

/// After so long without a change, an unfinished file of a process that is not there belongs to nobody. (It may be there
/// on another machine that sees the same folder.)
const ABANDONED: Duration = Duration::from_secs(24 * 3600);

/// Removes what processes have left in `folder` that were killed. Whatever cannot be removed stays.
fn sweep(folder: &Path) {
    let is_abandoned = |entry: &fs::DirEntry| -> Option<bool> {
        let name = entry.file_name().into_string().ok()?;
        let numbers = name.strip_prefix(".strahl-")?.strip_suffix(".part")?;
        let process: u32 = numbers.split_once('-')?.0.parse().ok()?;
        let age = entry.metadata().ok()?.modified().ok()?.elapsed().ok()?;
        Some(age > ABANDONED && !Path::new(&format!("/proc/{process}")).exists())
    };
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        if is_abandoned(&entry) == Some(true) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// A temporary file next to the target, removed when it is dropped.
#[derive(Debug)]
struct Part {
    path: PathBuf,
    file: File,
}

impl Part {
    /// With a name that no other file has, and readable as any new file is.
    fn new(folder: &Path) -> io::Result<Part> {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let process = std::process::id();
        loop {
            let number = NUMBER.fetch_add(1, Ordering::Relaxed);
            let path = folder.join(format!(".strahl-{process}-{number}.part"));
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => return Ok(Part { path, file }),
                // Of a process that was killed and had the same number.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
    }
}

impl Write for Part {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for Part {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        // It is not there any more once it has the name of the target.
        let _ = fs::remove_file(&self.path);
    }
}

impl Drop for Output {
    fn drop(&mut self) {
        if let Kind::Renamed(file) = &self.kind {
            let path = &file.get_ref().path;
            UNFINISHED
                .lock()
                .unwrap_or_else(|e| e.into_inner())
                .retain(|unfinished| unfinished != path);
        }
    }
}

impl Output {
    /// `error` with the name of the target.
    fn named(&self, error: io::Error) -> io::Error {
        io::Error::new(error.kind(), Error::path(&self.target, error))
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = match &mut self.kind {
            Kind::Renamed(file) => file.write(bytes),
            Kind::Device(memory, _) => memory.write(bytes),
        };
        written.map_err(|error| self.named(error))
    }

    fn flush(&mut self) -> io::Result<()> {
        let flushed = match &mut self.kind {
            Kind::Renamed(file) => file.flush(),
            Kind::Device(..) => Ok(()),
        };
        flushed.map_err(|error| self.named(error))
    }
}

impl Seek for Output {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match &mut self.kind {
            Kind::Renamed(file) => file.seek(to),
            Kind::Device(memory, _) => memory.seek(to),
        }
    }
}

/// Removes the temporary files of all [`Output`]s that are not finished, and keeps any from being
/// started or finished. For a program that is about to end by an interrupt: call it, then exit.
pub fn abandon_outputs() {
    let mut unfinished = UNFINISHED.lock().unwrap_or_else(|e| e.into_inner());
    for path in unfinished.drain(..) {
        // Nothing can be done about a failure on the way out.
        let _ = fs::remove_file(path);
    }
    std::mem::forget(unfinished);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_appears_when_it_is_finished() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("picture.png");
        let mut output = Output::create(&target).unwrap();
        output.write_all(b"half").unwrap();
        assert!(!target.exists());
        output.write_all(b" and half").unwrap();
        output.finish().unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"half and half");
        assert_eq!(names(folder.path()), ["picture.png"]);
    }

    #[test]
    fn dropping_leaves_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("picture.png");
        fs::write(&target, "old").unwrap();
        let mut output = Output::create(&target).unwrap();
        output.write_all(b"new").unwrap();
        output.flush().unwrap();
        drop(output);
        assert_eq!(fs::read(&target).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["picture.png"]);
    }

    #[test]
    fn places_that_cannot_be_written_are_found_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let message = |path: &Path| Output::create(path).unwrap_err().to_string();
        let found = message(&folder.path().join("none/picture.png"));
        assert!(found.contains("there is no folder"), "{found}");
        let found = message(folder.path());
        assert!(found.contains("is a folder"), "{found}");
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        assert!(Output::create(&file.join("picture.png")).is_err());
    }

    /// `/dev/full` stands in for a temporary file on a disk without space.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_reported_for_the_target() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("picture.png");
        let file = OpenOptions::new().write(true).open("/dev/full").unwrap();
        let path = folder.path().join(".strahl-1-0.part");
        let mut output = Output {
            target: target.clone(),
            kind: Kind::Renamed(BufWriter::with_capacity(16, Part { path, file })),
        };
        let expected = format!("{}: no space is left on the device", target.display());
        let error = output.write_all(&[0; 64]).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::StorageFull);
        assert_eq!(error.to_string(), expected);
        assert_eq!(output.write(b"x").unwrap(), 1);
        assert_eq!(output.finish().unwrap_err().to_string(), expected);
    }

    #[cfg(unix)]
    #[test]
    fn links_to_what_is_not_there_yet_are_kept() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("below")).unwrap();
        let link = folder.path().join("link.png");
        symlink("below/middle.png", &link).unwrap();
        symlink("a.png", folder.path().join("below/middle.png")).unwrap();
        let mut output = Output::create(&link).unwrap();
        output.write_all(b"new").unwrap();
        output.finish().unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(folder.path().join("below/a.png")).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["below", "link.png"]);

        let round = folder.path().join("round.png");
        symlink("round.png", &round).unwrap();
        assert!(Output::create(&round).is_err());
        symlink("none/a.png", folder.path().join("lost.png")).unwrap();
        let said = Output::create(&folder.path().join("lost.png")).unwrap_err();
        assert!(said.to_string().contains("there is no folder"), "{said}");
    }

    #[test]
    fn what_killed_processes_have_left_is_swept() {
        let folder = tempfile::tempdir().unwrap();
        let old = std::time::SystemTime::now() - 2 * ABANDONED;
        let mine = format!(".strahl-{}-4000000000.part", std::process::id());
        // No process has the largest number of all.
        let gone = ".strahl-4294967295-0.part";
        for (name, is_old) in [
            (gone, true),
            (".strahl-4294967295-1.part", false),
            (&mine, cfg!(target_os = "linux")),
            (".strahl-x-1.part", true),
            ("strahl-4294967295-0.part", true),
        ] {
            let file = File::create(folder.path().join(name)).unwrap();
            if is_old {
                file.set_modified(old).unwrap();
            }
        }
        drop(Output::create(&folder.path().join("a.png")).unwrap());
        let left = names(folder.path());
        assert_eq!(left.len(), 4, "{left:?}");
        assert!(!left.contains(&gone.to_owned()), "{left:?}");
    }

    #[test]
    fn the_old_file_can_go_before_the_new_one_comes() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a.mhd");
        fs::write(&target, "old").unwrap();
        let mut output = Output::create(&target).unwrap();
        output.write_all(b"new").unwrap();
        output.remove_old().unwrap();
        output.remove_old().unwrap();
        assert!(!target.exists());
        output.finish().unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"new");
    }

    #[cfg(unix)]
    #[test]
    fn permissions_links_and_devices_are_kept() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let (target, link) = (folder.path().join("a.png"), folder.path().join("link.png"));
        fs::write(&target, "old").unwrap();
        fs::set_permissions(&target, fs::Permissions::from_mode(0o640)).unwrap();
        symlink("a.png", &link).unwrap();
        let mut output = Output::create(&link).unwrap();
        output.write_all(b"new").unwrap();
        output.finish().unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&target).unwrap(), b"new");
        assert_eq!(
            fs::metadata(&target).unwrap().permissions().mode() & 0o777,
            0o640
        );

        let mut output = Output::create(Path::new("/dev/null")).unwrap();
        output.write_all(b"gone").unwrap();
        output.finish().unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }
}
