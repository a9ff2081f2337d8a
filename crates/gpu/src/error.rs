//! Why there is no picture.

use strahl_volume::Cancelled;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No adapter at all.
    #[error(
        "no graphics adapter was found; install its driver (on Debian and Ubuntu, mesa-vulkan-drivers brings one that needs no graphics card), or draw on the CPU"
    )]
    NoAdapter,
    /// No adapter of the name asked for.
    #[error("no graphics adapter has {name:?} in its name; there are: {known}")]
    NoSuchAdapter {
        /// What was asked for.
        name: String,
        /// What there is.
        known: String,
    },
    /// The adapter gives no device.
    #[error("the graphics adapter {adapter} cannot be used: {why}")]
    Device {
        /// Its name.
        adapter: String,
        /// What was said.
        why: String,
    },
    /// The device went away: a reset, a removed card, a driver that was updated.
    #[error("the graphics device was lost: {0}; open it again, or draw on the CPU")]
    Lost(String),
    /// The driver refused something.
    #[error("the graphics driver refused: {0}")]
    Driver(String),
    /// The volume does not fit into a texture, nor do its pages.
    #[error(
        "the volume of {dims:?} voxels does not fit into the textures of the graphics adapter (at most {most} texels along an axis and {most_bytes} bytes), even if equal blocks are stored once; draw on the CPU, or use a coarser level of detail"
    )]
    TooLarge {
        /// Of the volume.
        dims: [usize; 3],
        /// Voxels along an axis.
        most: u32,
        /// Bytes of the whole texture.
        most_bytes: u64,
    },
    /// A mesh does not fit into a buffer.
    #[error(
        "the mesh has {triangles} triangles, the graphics adapter takes at most {most}; draw on the CPU"
    )]
    MeshTooLarge {
        /// Of the mesh.
        triangles: usize,
        /// Of a buffer.
        most: usize,
    },
    /// A mask is larger than a texture.
    #[error(
        "the mask has {dims:?} voxels, the graphics adapter takes at most {most} along an axis; draw on the CPU"
    )]
    MaskTooLarge {
        /// Of the mask.
        dims: [usize; 3],
        /// Voxels along an axis.
        most: u32,
    },
    /// A label volume is larger than a texture.
    #[error(
        "the label volume has {dims:?} voxels, the graphics adapter takes at most {most} along an axis; draw on the CPU"
    )]
    LabelsTooLarge {
        /// Of the label volume.
        dims: [usize; 3],
        /// Voxels along an axis.
        most: u32,
    },
    /// The Plan was resolved for other data.
    #[error(transparent)]
    OtherData(#[from] strahl_scene::OtherData),
    /// The Plan asks for what slices cannot do.
    #[error(transparent)]
    Slicing(#[from] strahl_program::SlicingError),
    /// The adapter does not blend 32-bit floats.
    #[error(
        "the graphics adapter {adapter} cannot blend 32-bit floats, which slices need (16 bits are too few for many thin slices); draw on the CPU, or by a graph with a loop along the ray"
    )]
    NoBlending {
        /// Its name.
        adapter: String,
    },
    /// Coefficients of a B-spline, or the values of a mask, cannot be made.
    #[error(transparent)]
    Volume(strahl_volume::Error),
    /// The functions cannot be linked.
    #[error(transparent)]
    Shader(#[from] strahl_shader::Error),
    /// Whoever asked for the picture ended it by its [`Control`](strahl_volume::Control).
    #[error("cancelled")]
    Cancelled,
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
