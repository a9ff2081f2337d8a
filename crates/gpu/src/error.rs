//! Why there is no picture.

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No adapter at all.
    #[error(
        "no graphics adapter was found; install its driver (on Debian and Ubuntu, mesa-vulkan-drivers brings one that needs no graphics card), or draw with --backend cpu"
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
    #[error("the graphics device was lost: {0}; open it again, or draw with --backend cpu")]
    Lost(String),
    /// The driver refused something.
    #[error("the graphics driver refused: {0}")]
    Driver(String),
    /// The volume does not fit into one texture.
    #[error(
        "the volume has {dims:?} voxels, the graphics adapter takes at most {most} along an axis and {most_bytes} bytes in all; draw with --backend cpu"
    )]
    TooLarge {
        /// Of the volume.
        dims: [usize; 3],
        /// Voxels along an axis.
        most: u32,
        /// Bytes of the whole texture.
        most_bytes: u64,
    },
    /// The graphics renderer has no means for this yet.
    #[error("the graphics renderer does not draw {0} yet; draw with --backend cpu")]
    NotYet(&'static str),
    /// The coefficients of an interpolating B-spline cannot be made.
    #[error(transparent)]
    Coefficients(#[from] strahl_volume::Error),
    /// The Plan was resolved for another volume.
    #[error(
        "the plan is for a grid of {plan:?} voxels, the volume has {volume:?} (or lies elsewhere); resolve the scene with this volume's header"
    )]
    OtherGrid {
        /// Dimensions in the Plan.
        plan: [usize; 3],
        /// Dimensions of the volume.
        volume: [usize; 3],
    },
    /// The functions cannot be linked.
    #[error(transparent)]
    Shader(#[from] strahl_shader::Error),
    /// The caller's progress function asked for it.
    #[error("cancelled")]
    Cancelled,
}
