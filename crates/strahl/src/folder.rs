//! Files on disk, as the readers of [`strahl_volume::read`] want them.

use crate::Error;
use crate::confinement::open_regular;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::path::{Component, Path, PathBuf};
use std::time::SystemTime;
use strahl_volume::read::{Bytes, Files};

/// A folder, the folder around one file, or a list of files.
///
/// Files are read by position, without a memory map: a map of a file that another program cuts off,
/// or that lies on a network share that goes away, kills the process.
#[derive(Clone, Debug)]
pub struct Folder(Source);

#[derive(Clone, Debug)]
enum Source {
    /// Any file that can be reached from here; listed only when asked. With the file that all of them are around, by
    /// the name that readers know it by: not every name is text.
    Around(PathBuf, String, PathBuf),
    /// These files and no other, with their lengths …
    Listed(BTreeMap<String, (PathBuf, u64)>),
    /// … and what lies in folders below this one, listed only when asked.
    Tree(PathBuf, BTreeMap<String, (PathBuf, u64)>),
}

impl Folder {
    /// The files of a folder, and those of folders in it if somebody asks; names that begin with a dot are left out.
    ///
    /// # Errors
    /// If the folder cannot be listed, or is empty.
    pub fn of(path: &Path) -> Result<Folder, Error> {
        let (files, folders) = list(path).map_err(|error| Error::path(path, error))?;
        if files.is_empty() && folders.is_empty() {
            return Err(Error::not_usable(path, "the folder is empty"));
        }
        Ok(Folder(Source::Tree(path.to_owned(), files)))
    }

    /// The files beside `path`, for headers that name their data file.
    pub fn around(path: &Path) -> Folder {
        let parent = path.parent().filter(|p| !p.as_os_str().is_empty());
        let folder = parent.unwrap_or(Path::new(".")).to_owned();
        Folder(Source::Around(folder, file_name(path), path.to_owned()))
    }

    /// Exactly these files. Each is called by its file name, or by its whole path where two files of
    /// different folders have the same name.
    ///
    /// # Errors
    /// If one does not exist, is a folder, or is listed twice.
    pub fn of_files(paths: &[PathBuf]) -> Result<Folder, Error> {
        let mut count = BTreeMap::<String, usize>::new();
        let mut lengths = Vec::new();
        for path in paths {
            let metadata = fs::metadata(path).map_err(|error| Error::path(path, error))?;
            if metadata.is_dir() {
                return Err(Error::not_usable(
                    path,
                    "a folder among several files; give one folder, or files only",
                ));
            }
            *count.entry(file_name(path)).or_default() += 1;
            lengths.push(metadata.len());
        }
        let mut files = BTreeMap::new();
        for (path, len) in paths.iter().zip(lengths) {
            let short = file_name(path);
            let name = match count[&short] {
                1 => short,
                _ => path.display().to_string(),
            };
            if files.insert(name, (path.clone(), len)).is_some() {
                return Err(Error::not_usable(path, "given twice"));
            }
        }
        Ok(Folder(Source::Listed(files)))
    }

    /// The names that [`names`](Files::names) would give of this folder as it is now.
    pub(crate) fn current_names(&self) -> Vec<String> {
        match &self.0 {
            Source::Around(folder, ..) | Source::Tree(folder, _) => list(folder)
                .map(|(files, _)| files.into_keys().collect())
                .unwrap_or_default(),
            Source::Listed(_) => self.names(),
        }
    }

    /// When a file was last added to the folder or taken out of it; not known of a list of files.
    pub(crate) fn last_change(&self) -> Option<SystemTime> {
        match &self.0 {
            Source::Around(folder, ..) | Source::Tree(folder, _) => {
                fs::metadata(folder).ok()?.modified().ok()
            }
            Source::Listed(_) => None,
        }
    }

    /// Where the file `name` lies.
    pub(crate) fn path_of(&self, name: &str) -> io::Result<PathBuf> {
        match &self.0 {
            Source::Around(_, known, path) if name == known => Ok(path.clone()),
            Source::Around(folder, ..) => inside(folder, name),
            Source::Tree(folder, files) => match files.get(name) {
                Some((path, _)) => Ok(path.clone()),
                None if name.contains('/') => inside(folder, name),
                None => Err(io::ErrorKind::NotFound.into()),
            },
            Source::Listed(files) => files
                .get(name)
                .map(|(path, _)| path.clone())
                .ok_or_else(|| io::ErrorKind::NotFound.into()),
        }
    }
}

impl Files for Folder {
    fn names(&self) -> Vec<String> {
        match &self.0 {
            Source::Around(..) => self.current_names(),
            Source::Listed(files) | Source::Tree(_, files) => files.keys().cloned().collect(),
        }
    }

    fn names_below(&self) -> io::Result<Vec<String>> {
        match &self.0 {
            Source::Around(folder, ..) | Source::Tree(folder, _) => list_below(folder),
            Source::Listed(_) => Ok(self.names()),
        }
    }

    fn open(&self, name: &str) -> io::Result<Box<dyn Bytes + '_>> {
        Ok(Box::new(FileBytes::open(&self.path_of(name)?)?))
    }
}

/// The name that a reader knows a file by.
pub(crate) fn file_name(path: &Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}

/// Path and length of each file, by name.
type FilesByName = BTreeMap<String, (PathBuf, u64)>;

/// Regular files (behind symbolic links too), and the names of folders.
fn list(folder: &Path) -> io::Result<(FilesByName, Vec<String>)> {
    let (mut files, mut folders) = (FilesByName::new(), Vec::new());
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with('.') {
            continue;
        }
        // A dangling link is not worth failing for.
        let Ok(metadata) = fs::metadata(entry.path()) else {
            continue;
        };
        if metadata.is_dir() {
            folders.push(name);
        } else if metadata.is_file() {
            files.insert(name, (entry.path(), metadata.len()));
        }
    }
    folders.sort();
    Ok((files, folders))
}

/// A file in the folder or below it: a downloaded header has no business elsewhere on this machine.
fn inside(folder: &Path, name: &str) -> io::Result<PathBuf> {
    let is_inside = Path::new(name)
        .components()
        .all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
    match is_inside {
        true => Ok(folder.join(name)),
        false => Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "names a file outside the folder of its header; put it beside the header",
        )),
    }
}

/// Archives and CDs nest patient, study, series and part; more is no tree of images.
const DEEPEST: usize = 8;
const MOST_FILES: usize = 200_000;

/// The names of all files in a folder and below, with `/` between folders. Links to folders are not followed, so no
/// way leads out or round.
fn list_below(folder: &Path) -> io::Result<Vec<String>> {
    let too_many = |what: String| {
        let message = format!(
            "{what} lie below {}; name a folder of one series",
            folder.display()
        );
        io::Error::other(message)
    };
    let mut names = Vec::new();
    let mut open = vec![(folder.to_owned(), String::new(), 0)];
    while let Some((path, prefix, depth)) = open.pop() {
        if depth > DEEPEST {
            return Err(too_many(format!("folders deeper than {DEEPEST}")));
        }
        for entry in fs::read_dir(&path)? {
            let entry = entry?;
            let name = entry.file_name().to_string_lossy().into_owned();
            if name.starts_with('.') {
                continue;
            }
            let name = format!("{prefix}{name}");
            let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
            if is_folder {
                open.push((entry.path(), format!("{name}/"), depth + 1));
            } else if fs::metadata(entry.path()).is_ok_and(|metadata| metadata.is_file()) {
                names.push(name);
            }
            if names.len() + open.len() > MOST_FILES {
                return Err(too_many(format!("more than {MOST_FILES} files")));
            }
        }
    }
    names.sort();
    Ok(names)
}

/// An open file.
struct FileBytes {
    file: File,
    len: u64,
}

impl FileBytes {
    fn open(path: &Path) -> io::Result<FileBytes> {
        let file = open_regular(path)?;
        let metadata = file.metadata()?;
        Ok(FileBytes {
            file,
            len: metadata.len(),
        })
    }
}

impl Bytes for FileBytes {
    fn len(&self) -> u64 {
        self.len
    }

    #[cfg(unix)]
    fn read_at(&self, offset: u64, into: &mut [u8]) -> io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(&self.file, into, offset)
    }

    #[cfg(windows)]
    fn read_at(&self, mut offset: u64, mut into: &mut [u8]) -> io::Result<()> {
        while !into.is_empty() {
            match std::os::windows::fs::FileExt::seek_read(&self.file, into, offset)? {
                0 => return Err(io::ErrorKind::UnexpectedEof.into()),
                read => {
                    offset += read as u64;
                    into = &mut into[read..];
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder_with(names: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, name.as_bytes()).unwrap();
        }
        folder
    }

    fn bytes_of(files: &dyn Files, name: &str) -> Vec<u8> {
        let bytes = files.open(name).unwrap();
        let mut all = vec![0; bytes.len() as usize];
        bytes.read_at(0, &mut all).unwrap();
        all
    }

    #[test]
    fn a_folder_lists_its_files_sorted_without_folders_and_dot_files() {
        let folder = folder_with(&["b.dcm", "a.dcm", ".DS_Store", "below/c.dcm"]);
        let files = Folder::of(folder.path()).unwrap();
        assert_eq!(files.names(), ["a.dcm", "b.dcm"]);
        assert_eq!(bytes_of(&files, "b.dcm"), b"b.dcm");
        assert_eq!(
            files.open("c.dcm").err().unwrap().kind(),
            io::ErrorKind::NotFound
        );
    }

    #[test]
    fn files_in_folders_are_listed_when_asked() {
        let folder = folder_with(&["b.txt", "study/1/a.dcm", "study/2/.x", "study/2/c.dcm"]);
        let files = Folder::of(folder.path()).unwrap();
        assert_eq!(files.names(), ["b.txt"]);
        let below = ["b.txt", "study/1/a.dcm", "study/2/c.dcm"];
        assert_eq!(files.names_below().unwrap(), below);
        assert_eq!(bytes_of(&files, "study/2/c.dcm"), b"study/2/c.dcm");
        let kind = files.open("study/../../b.txt").err().unwrap().kind();
        assert_eq!(kind, io::ErrorKind::InvalidInput);
        let around = Folder::around(&folder.path().join("b.txt"));
        assert_eq!(around.names_below().unwrap(), below);

        let deep = folder_with(&["1/2/3/4/5/6/7/8/9/a"]);
        let error = Folder::of(deep.path()).unwrap().names_below().unwrap_err();
        assert!(error.to_string().contains("deeper than 8"), "{error}");
        let empty = tempfile::tempdir().unwrap();
        let message = Folder::of(empty.path()).unwrap_err().to_string();
        assert!(message.ends_with("the folder is empty"), "{message}");
    }

    #[test]
    fn a_header_reaches_files_beside_and_below_it_and_no_others() {
        let folder = folder_with(&["in/head.nhdr", "in/head.raw", "in/raw/z.raw", "secret"]);
        let files = Folder::around(&folder.path().join("in/head.nhdr"));
        assert_eq!(bytes_of(&files, "head.raw"), b"in/head.raw");
        assert_eq!(bytes_of(&files, "raw/z.raw"), b"in/raw/z.raw");
        for name in ["../secret", "/etc/hosts", "raw/../../secret"] {
            let kind = files.open(name).err().unwrap().kind();
            assert_eq!(kind, io::ErrorKind::InvalidInput, "{name}");
        }
    }

    #[test]
    fn files_of_the_same_name_keep_apart() {
        let folder = folder_with(&["one/1.dcm", "two/1.dcm", "two/2.dcm"]);
        let path = |name: &str| folder.path().join(name);
        let files =
            Folder::of_files(&[path("one/1.dcm"), path("two/1.dcm"), path("two/2.dcm")]).unwrap();
        assert_eq!(files.names().len(), 3);
        assert_eq!(bytes_of(&files, "2.dcm"), b"two/2.dcm");
        let one = path("one/1.dcm").display().to_string();
        assert_eq!(bytes_of(&files, &one), b"one/1.dcm");
        assert!(Folder::of_files(&[path("two/2.dcm"), path("two/2.dcm")]).is_err());
        assert!(Folder::of_files(&[path("two")]).is_err());
        let message = Folder::of_files(&[path("three")]).unwrap_err().to_string();
        assert!(
            message.ends_with("three: no such file or folder"),
            "{message}"
        );
    }

    #[test]
    fn reading_beyond_the_end_is_an_error() {
        let folder = folder_with(&["four"]);
        let files = Folder::of(folder.path()).unwrap();
        let bytes = files.open("four").unwrap();
        let mut two = [0; 2];
        bytes.read_at(2, &mut two).unwrap();
        assert_eq!(&two, b"ur");
        let error = bytes.read_at(3, &mut two).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::UnexpectedEof);
    }
}
