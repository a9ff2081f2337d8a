//! Errors between a path and a picture.

use crate::estimate::{About, Bytes, Estimate};
use std::path::{Path, PathBuf};
use std::{fmt, io};
use strahl_volume::Cancelled;

/// An error of this crate: the step that failed, and the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The caller cancelled with [`Control`](strahl_volume::Control).
    #[error("cancelled")]
    Cancelled,
    /// The operating system could not find, read, create or rename a file.
    #[error("{}: {}", .path.display(), Reason(.error))]
    Path {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        error: io::Error,
    },
    /// A file or folder is not usable here.
    #[error("{}: {why}", .path.display())]
    NotUsable {
        /// The file or folder.
        path: PathBuf,
        /// The problem and the remedy.
        why: String,
    },
    /// A scene names what lies outside of the folder that it may read in.
    #[error(
        "{}: lies outside of {}, and this scene may read only there",
        .path.display(),
        .folder.display()
    )]
    Outside {
        /// What it names.
        path: PathBuf,
        /// Where it may read.
        folder: PathBuf,
    },
    /// The volume cannot be read, or is not one.
    #[error(transparent)]
    Volume(strahl_volume::Error),
    /// The text of a scene file is not a scene.
    #[error(transparent)]
    Scene(#[from] strahl_scene::Error),
    /// The scene cannot be drawn; all reasons at once.
    #[error("{}{problems}", Named(.file))]
    Problems {
        /// The file that the scene comes from, if it comes from one.
        file: Option<PathBuf>,
        /// The problems.
        problems: strahl_scene::Problems,
    },
    /// A shader function is invalid, or functions cannot be linked.
    #[error(transparent)]
    Shader(#[from] strahl_shader::Error),
    /// A graph, an edit or a pattern is invalid.
    #[cfg(feature = "graph")]
    #[error(transparent)]
    Graph(#[from] strahl_graph::Error),
    /// The CPU renderer failed.
    #[error(transparent)]
    Draw(strahl_cpu::Error),
    /// This build has neither graphs nor shader functions from files.
    #[error(
        "{}{what} is not part of this build; build with the feature `graph`",
        Named(.file)
    )]
    NoGraphs {
        /// The file, if there is one.
        file: Option<PathBuf>,
        /// `a graph` or `a shader function`.
        what: &'static str,
    },
    /// The evaluator failed.
    #[cfg(feature = "graph")]
    #[error(transparent)]
    Evaluate(strahl_evaluate::Error),
    /// The GPU renderer failed.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(strahl_gpu::Error),
    /// This build has no GPU renderer.
    #[error("drawing on the GPU is not part of this build; build with the feature `gpu`")]
    NoGpu,
    /// Neither the scene nor the caller names a volume.
    #[error(
        "{}volume is missing; give the scene a \"volume\" with a \"path\" or a \"phantom\", or give a volume after the scene",
        Named(.scene)
    )]
    NoVolume {
        /// The file of the scene.
        scene: Option<PathBuf>,
    },
    /// The renderer or the graph does not draw in stages.
    #[error("pictures in stages are drawn by the CPU's own ray loop only, and not by a graph")]
    NoStages,
    /// A scene with a graph cannot be drawn into a texture.
    #[error("a scene with a graph is not drawn into a texture; draw it into memory")]
    NoGraph,
    /// The picture would take longer than its [`Budget`](crate::Budget) allows.
    #[error(
        "the picture would take about {} ({:.0} rays of {:.0} samples); the limit is {}. Less are a smaller picture (it is {} × {} pixels), a longer step (it is {step_mm} mm) or fewer frames (there are {frames})",
        About(.estimate.seconds),
        .estimate.rays,
        .estimate.points,
        About(*.most_seconds),
        .size[0],
        .size[1]
    )]
    TooMuchTime {
        /// What it would take.
        estimate: Box<Estimate>,
        /// What it may take.
        most_seconds: f64,
        /// Columns and rows.
        size: [u32; 2],
        /// Of the Plan.
        step_mm: f64,
        /// Of the Plan.
        frames: u32,
    },
    /// The picture would take more memory than its [`Budget`](crate::Budget) allows.
    #[error(
        "data and picture would take about {}; the limit is {}. Less are a coarser volume (its `level`) or a smaller picture (it is {} × {} pixels)",
        Bytes(*.bytes),
        Bytes(*.most_bytes),
        .size[0],
        .size[1]
    )]
    TooMuchMemory {
        /// What it would take.
        bytes: u64,
        /// What it may take.
        most_bytes: u64,
        /// Columns and rows.
        size: [u32; 2],
    },
    /// The system has no room for the picture.
    #[error("there is no memory for the {bytes} bytes of the picture; draw a smaller one")]
    NoMemory {
        /// Bytes asked for.
        bytes: u64,
    },
    /// A picture file cannot be written.
    #[error("the {format} file cannot be written: {why}")]
    NotWritten {
        /// PNG or EXR.
        format: &'static str,
        /// What the encoder said.
        why: String,
    },
    /// A picture file cannot be read.
    #[error("the {format} file cannot be read: {why}")]
    NotRead {
        /// PNG or EXR.
        format: &'static str,
        /// What the decoder said.
        why: String,
    },
    /// The scene in a picture file cannot be unpacked.
    #[error(
        "{}the scene in the picture is damaged, or longer than {} bytes, which no scene is",
        Named(.file),
        strahl_scene::MOST_SCENE_BYTES
    )]
    NoRecipe {
        /// The file, if its name is known.
        file: Option<PathBuf>,
    },
    /// PNG holds no depth.
    #[error("PNG cannot hold depth; use a name that ends in .exr")]
    NoDepth,
    /// The depth belongs to another picture.
    #[error("the depth has {numbers} numbers; it has to have one for each of {pixels} pixels")]
    DepthSize {
        /// Of the depth.
        numbers: usize,
        /// Of the picture.
        pixels: usize,
    },
}

impl From<Cancelled> for Error {
    fn from(_: Cancelled) -> Error {
        Error::Cancelled
    }
}

impl From<strahl_volume::Error> for Error {
    fn from(error: strahl_volume::Error) -> Error {
        match error.is_cancelled() {
            true => Error::Cancelled,
            false => Error::Volume(error),
        }
    }
}

impl From<strahl_cpu::Error> for Error {
    fn from(error: strahl_cpu::Error) -> Error {
        match error {
            strahl_cpu::Error::Cancelled => Error::Cancelled,
            error => Error::Draw(error),
        }
    }
}

#[cfg(feature = "graph")]
impl From<strahl_evaluate::Error> for Error {
    fn from(error: strahl_evaluate::Error) -> Error {
        match error {
            strahl_evaluate::Error::Cancelled => Error::Cancelled,
            error => Error::Evaluate(error),
        }
    }
}

#[cfg(feature = "gpu")]
impl From<strahl_gpu::Error> for Error {
    fn from(error: strahl_gpu::Error) -> Error {
        match error {
            strahl_gpu::Error::Cancelled => Error::Cancelled,
            error => Error::Gpu(error),
        }
    }
}

impl From<strahl_scene::Problems> for Error {
    /// Problems of a scene whose file is unknown.
    fn from(problems: strahl_scene::Problems) -> Error {
        Error::Problems {
            file: None,
            problems,
        }
    }
}

impl Error {
    pub(crate) fn path(path: &Path, error: io::Error) -> Error {
        Error::Path {
            path: path.to_owned(),
            error,
        }
    }

    /// Problems of a scene are those of the file `scene`, unless they name another one.
    pub(crate) fn of_scene(self, scene: &Option<PathBuf>) -> Error {
        match self {
            Error::Problems {
                file: None,
                problems,
            } => Error::Problems {
                file: scene.clone(),
                problems,
            },
            other => other,
        }
    }

    pub(crate) fn not_read(format: &'static str, why: impl fmt::Display) -> Error {
        let why = why.to_string();
        Error::NotRead { format, why }
    }

    pub(crate) fn not_written(format: &'static str, why: impl fmt::Display) -> Error {
        let why = why.to_string();
        Error::NotWritten { format, why }
    }

    pub(crate) fn not_usable(path: &Path, why: impl Into<String>) -> Error {
        Error::NotUsable {
            path: path.to_owned(),
            why: why.into(),
        }
    }
}

/// A file name before a message.
struct Named<'a>(&'a Option<PathBuf>);

impl fmt::Display for Named<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(path) => write!(f, "{}: ", path.display()),
            None => Ok(()),
        }
    }
}

/// The system's message without its error number, for common errors.
struct Reason<'a>(&'a io::Error);

impl fmt::Display for Reason<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.kind() {
            io::ErrorKind::NotFound => f.write_str("no such file or folder"),
            io::ErrorKind::PermissionDenied => f.write_str("permission denied"),
            io::ErrorKind::ReadOnlyFilesystem => f.write_str("the file system is read-only"),
            io::ErrorKind::StorageFull => f.write_str("no space is left on the device"),
            _ => self.0.fmt(f),
        }
    }
}
