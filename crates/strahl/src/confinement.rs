//! Which files may be read: regular ones only, and for a scene that somebody else has made those of one folder.

use crate::Error;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

/// A folder that a scene may read in, and below, and nowhere else. Links that lead out of it are not followed.
///
/// A picture brings its scene from wherever it comes: [`SceneFile::open`](crate::SceneFile::open) confines it to what
/// lies beside the picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Confinement {
    /// As it was named, and as it is behind links; both whole.
    named: PathBuf,
    real: PathBuf,
    /// Whole paths that may be read although they lie elsewhere.
    also: Vec<PathBuf>,
}

impl Confinement {
    /// To `folder`.
    ///
    /// # Errors
    /// There is no such folder.
    pub fn to(folder: &Path) -> Result<Confinement, Error> {
        let folder = match folder.as_os_str().is_empty() {
            true => Path::new("."),
            false => folder,
        };
        let fail = |error| Error::path(folder, error);
        let real = folder.canonicalize().map_err(fail)?;
        if !real.is_dir() {
            return Err(Error::not_usable(folder, "is not a folder"));
        }
        Ok(Confinement {
            named: plain(folder).map_err(fail)?,
            real,
            also: Vec::new(),
        })
    }

    /// The same with one more file or folder that may be read wherever it lies, together with what its reader needs
    /// beside it: somebody has named it who is not the scene.
    ///
    /// # Errors
    /// The path is empty.
    pub fn with_file(mut self, path: &Path) -> Result<Confinement, Error> {
        let whole = plain(path).map_err(|error| Error::path(path, error))?;
        self.also.push(whole);
        Ok(self)
    }

    /// Whether `path` is one of those that may lie anywhere.
    pub(crate) fn allows_anywhere(&self, path: &Path) -> bool {
        plain(path).is_ok_and(|whole| self.also.contains(&whole))
    }

    /// Whether the file or folder `path` lies inside. Of what does not, nothing is told, not even whether it is there.
    pub(crate) fn check(&self, path: &Path) -> Result<(), Error> {
        let outside = || Error::Outside {
            path: path.to_owned(),
            folder: self.named.clone(),
        };
        let whole = plain(path).map_err(|_| outside())?;
        if self.also.contains(&whole) {
            return Ok(());
        }
        if !whole.starts_with(&self.named) && !whole.starts_with(&self.real) {
            return Err(outside());
        }
        match whole.canonicalize() {
            Ok(real) if !real.starts_with(&self.real) => Err(outside()),
            // What is not there is found out by whoever reads it.
            _ => Ok(()),
        }
    }
}

/// The whole path, with every `..` taken back.
fn plain(path: &Path) -> io::Result<PathBuf> {
    let mut out = PathBuf::new();
    for part in std::path::absolute(path)?.components() {
        match part {
            Component::ParentDir => {
                out.pop();
            }
            Component::CurDir => {}
            part => out.push(part),
        }
    }
    Ok(out)
}

/// Opens a file to read it. Pipes, devices and folders are refused before they are opened: a pipe waits for a writer,
/// a device may never end.
///
/// # Errors
/// It is no regular file; what the system says.
pub(crate) fn open_regular(path: &Path) -> io::Result<File> {
    let metadata = fs::metadata(path)?;
    if metadata.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    if !metadata.is_file() {
        return Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "a pipe or a device; only regular files are read, so copy it into one",
        ));
    }
    File::open(path)
}

/// The text of a regular file, of at most `most` bytes.
///
/// # Errors
/// There is no such file, it is no regular one, is longer, or not in UTF-8.
pub fn read_text(path: &Path, most: usize) -> Result<String, Error> {
    let fail = |error| Error::path(path, error);
    let mut bytes = Vec::new();
    let file = open_regular(path).map_err(fail)?;
    file.take(most as u64 + 1)
        .read_to_end(&mut bytes)
        .map_err(fail)?;
    if bytes.len() > most {
        let why = format!("is longer than {most} bytes, which no such text is");
        return Err(Error::not_usable(path, why));
    }
    String::from_utf8(bytes).map_err(|_| Error::not_usable(path, "is no text in UTF-8"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_outside_is_refused_whatever_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let (inside, outside) = (folder.path().join("in"), folder.path().join("out"));
        fs::create_dir_all(inside.join("below")).unwrap();
        fs::create_dir_all(&outside).unwrap();
        fs::write(inside.join("below/a"), "a").unwrap();
        fs::write(outside.join("b"), "b").unwrap();
        let confined = Confinement::to(&inside).unwrap();
        for path in ["below/a", "below/../below/a", "none", "."] {
            confined.check(&inside.join(path)).unwrap();
        }
        for path in ["../out/b", "../out/none", "..", "/etc/hosts", "../in2"] {
            let said = confined.check(&inside.join(path)).unwrap_err().to_string();
            assert!(said.contains("outside"), "{said}");
        }
        assert!(Confinement::to(&outside.join("b")).is_err());
        assert!(Confinement::to(&outside.join("none")).is_err());
    }

    #[test]
    fn files_that_are_named_may_lie_anywhere_and_their_neighbors_may_not() {
        let folder = tempfile::tempdir().unwrap();
        let (inside, outside) = (folder.path().join("in"), folder.path().join("out"));
        fs::create_dir_all(&inside).unwrap();
        fs::create_dir_all(&outside).unwrap();
        let confined = Confinement::to(&inside).unwrap();
        let confined = confined.with_file(&outside.join("../out/a")).unwrap();
        assert!(confined.check(&outside.join("a")).is_ok());
        assert!(confined.allows_anywhere(&inside.join("../out/a")));
        for path in ["b", "a.json", "a/b", "."] {
            let path = outside.join(path);
            assert!(confined.check(&path).is_err(), "{}", path.display());
            assert!(!confined.allows_anywhere(&path));
        }
        assert!(confined.with_file(Path::new("")).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn links_that_lead_out_are_refused_and_those_to_the_folder_are_not() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let inside = folder.path().join("in");
        fs::create_dir_all(&inside).unwrap();
        fs::write(folder.path().join("b"), "b").unwrap();
        fs::write(inside.join("a"), "a").unwrap();
        symlink("../b", inside.join("link")).unwrap();
        symlink("in", folder.path().join("other")).unwrap();
        let confined = Confinement::to(&folder.path().join("other")).unwrap();
        confined.check(&folder.path().join("other/a")).unwrap();
        confined.check(&inside.join("a")).unwrap();
        assert!(confined.check(&folder.path().join("other/link")).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn pipes_and_devices_are_not_opened() {
        let said = |path: &str| open_regular(Path::new(path)).unwrap_err().to_string();
        assert!(said("/dev/zero").contains("only regular files"));
        assert!(said("/dev").contains("directory"));
    }
}
