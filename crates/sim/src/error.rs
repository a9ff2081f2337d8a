//! The one error of this crate.

/// Why a Spec cannot be built or a frame cannot be run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A field of the Spec contradicts another one, the volume or the view. Change it as the message says.
    #[error("{field} is {value}: {problem}")]
    Field {
        /// Path of the field in the Spec, such as `widths.length`.
        field: &'static str,
        /// What it says.
        value: String,
        /// What is wrong, and the bound that would be right.
        problem: String,
    },
    /// A Spec file is not what it should be.
    #[error("{file}: {problem}")]
    File {
        /// The name of the file.
        file: String,
        /// What is wrong, with the place.
        problem: String,
    },
    /// A picture could not be encoded.
    #[error("cannot encode the picture: {0}")]
    Picture(#[from] png::EncodingError),
    /// A volume could not be made or read.
    #[error(transparent)]
    Volume(#[from] strahl_volume::Error),
    /// Somebody stopped a study.
    #[error("stopped before the end")]
    Stopped,
    /// There is no study of that name.
    #[error("there is no study {name}; there are {known}")]
    Study {
        /// What was asked for.
        name: String,
        /// What there is.
        known: String,
    },
    /// A file could not be written.
    #[error("{path}: {source}")]
    Write {
        /// The file.
        path: String,
        /// Why.
        source: std::io::Error,
    },
}

impl Error {
    pub(crate) fn field(
        field: &'static str,
        value: impl ToString,
        problem: impl Into<String>,
    ) -> Error {
        Error::Field {
            field,
            value: value.to_string(),
            problem: problem.into(),
        }
    }
}
