//! What can go wrong with stored data, in words that name the file, the field and what would be right.

use crate::control::{Cancelled, OverBudget};
use std::fmt;
use std::path::Path;

/// An error of this crate: what went wrong and, once a reader has said so, in which file.
#[derive(Debug)]
pub struct Error {
    file: Option<String>,
    kind: Box<ErrorKind>,
    remedy: Option<Remedy>,
}

/// What the caller can say so that the file is read: fields of [`ReadOptions`](crate::read::ReadOptions). Messages
/// leave it out, because each program has its own words for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Remedy {
    /// Which series it is (`series`).
    Series,
    /// How far apart its voxels are (`spacing_mm`).
    Spacing,
    /// Which of several numbers per voxel (`component`).
    Component,
    /// That missing slices may be interpolated (`allow_gaps`).
    AllowGaps,
    /// Size and type of samples without a header (`raw.dims`, `raw.sample_type`).
    DimsAndType,
    /// Their type (`raw.sample_type`).
    Type,
    /// How much memory reading may take ([`Control::with_memory`](crate::Control::with_memory)).
    Memory,
    /// How many bytes before the first sample are a header after all (`raw.header_bytes`).
    HeaderBytes(u64),
}

/// What went wrong.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ErrorKind {
    /// Whoever asked for it ended it by its [`Control`](crate::Control).
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The operating system could not read or write.
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// No reader knows the first bytes of the file.
    #[error(
        "not a volume that can be read: {why}. Known are NIfTI, NRRD, MetaImage, DICOM, TIFF, PNG, BMP and JPEG slices, MGH, VTK, MRC, npy, npz, PVM, .dat and raw"
    )]
    Unknown {
        /// What was looked at and found.
        why: String,
    },
    /// A header field has a value that is not allowed.
    #[error("{field} is {value}; allowed: {allowed}")]
    Field {
        /// The field as the format's documentation calls it.
        field: String,
        /// The value found.
        value: String,
        /// What would be right.
        allowed: String,
    },
    /// A required header field is not there.
    #[error("{field} is missing; {allowed}")]
    Missing {
        /// The field as the format's documentation calls it.
        field: String,
        /// What would be right.
        allowed: String,
    },
    /// The file ends before the data that its header promises.
    #[error("{what} is cut off: the header promises {expected} bytes, {found} are there")]
    Truncated {
        /// What ended early: the header, the samples, …
        what: String,
        /// Bytes promised.
        expected: u64,
        /// Bytes found.
        found: u64,
    },
    /// Compressed data is damaged, or unpacks to more than its header promises.
    #[error("the {codec} data cannot be unpacked: {why}")]
    Compression {
        /// gzip, bzip2, zlib, …
        codec: &'static str,
        /// What the decompressor said.
        why: String,
    },
    /// The voxel-to-world map cannot place a volume.
    #[error("world_from_voxel {affine} {why}")]
    BadAffine {
        /// The first three rows of the matrix.
        affine: String,
        /// What is wrong with it.
        why: &'static str,
    },
    /// The file uses a part of its format that is not read or written.
    #[error("{feature} is not supported; {instead}")]
    Unsupported {
        /// The part.
        feature: String,
        /// What to do instead.
        instead: String,
    },
    /// Slices of a series do not lie on one even grid.
    #[error("{0}")]
    Slices(String),
    /// Several volumes are there and none was picked.
    #[error("{0}")]
    Ambiguous(String),
    /// What is read needs more memory than whoever reads it allows.
    #[error(transparent)]
    OverBudget(#[from] OverBudget),
    /// Not enough memory for data that is really there.
    #[error("no memory for {bytes} bytes of data")]
    NoMemory {
        /// Bytes asked for.
        bytes: u64,
    },
}

impl Error {
    /// A field with a value that is not allowed. Control characters of the value are escaped: it may
    /// be anything that a file holds, and messages go to terminals.
    pub fn field(
        field: impl Into<String>,
        value: impl fmt::Display,
        allowed: impl Into<String>,
    ) -> Error {
        ErrorKind::Field {
            field: field.into(),
            value: printable(&value.to_string()),
            allowed: allowed.into(),
        }
        .into()
    }

    /// What to say of a format whose feature is turned off.
    #[cfg(not(all(feature = "tiff", feature = "dicom")))]
    pub(crate) fn not_built_in(format: &str, feature: &str) -> Error {
        ErrorKind::Unsupported {
            feature: format!("{format} in this build"),
            instead: format!("build with the feature `{feature}`"),
        }
        .into()
    }

    /// The same error, said of `file`, unless a file is already named. (That the work was cancelled says nothing of
    /// any file.)
    pub fn in_file(mut self, file: &str) -> Error {
        if !self.is_cancelled() {
            self.file.get_or_insert_with(|| file.to_owned());
        }
        self
    }

    /// The same error, with `folder` before the name of its file.
    #[must_use]
    pub fn in_folder(mut self, folder: &Path) -> Error {
        if let Some(file) = &mut self.file {
            *file = folder.join(&*file).display().to_string();
        }
        self
    }

    /// The same error, with what the caller can do.
    pub(crate) fn with_remedy(mut self, remedy: Remedy) -> Error {
        self.remedy = Some(remedy);
        self
    }

    /// What the caller can say so that the file is read, if that would help.
    pub fn remedy(&self) -> Option<Remedy> {
        self.remedy
    }

    /// Whether nothing went wrong, but whoever asked for it ended it.
    pub fn is_cancelled(&self) -> bool {
        matches!(*self.kind, ErrorKind::Cancelled(_))
    }

    /// What went wrong.
    pub fn kind(&self) -> &ErrorKind {
        &self.kind
    }

    /// The file it went wrong in, if known.
    pub fn file(&self) -> Option<&str> {
        self.file.as_deref()
    }
}

fn printable(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() {
            out.extend(c.escape_default());
        } else {
            out.push(c);
        }
    }
    out
}

impl From<ErrorKind> for Error {
    fn from(kind: ErrorKind) -> Error {
        Error {
            file: None,
            kind: Box::new(kind),
            remedy: None,
        }
    }
}

impl From<Cancelled> for Error {
    fn from(cancelled: Cancelled) -> Error {
        ErrorKind::Cancelled(cancelled).into()
    }
}

impl From<OverBudget> for Error {
    fn from(over: OverBudget) -> Error {
        Error::from(ErrorKind::OverBudget(over)).with_remedy(Remedy::Memory)
    }
}

impl From<std::io::Error> for Error {
    fn from(error: std::io::Error) -> Error {
        ErrorKind::Io(error).into()
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.file {
            Some(file) => write!(f, "{file}: {}", self.kind),
            None => self.kind.fmt(f),
        }
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match &*self.kind {
            ErrorKind::Io(error) => Some(error),
            _ => None,
        }
    }
}
