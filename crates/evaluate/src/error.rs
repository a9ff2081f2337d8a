//! Why a program does not run.

use strahl_volume::Cancelled;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The program does something that the evaluator does not.
    #[error("the evaluator has no {what}, which function {function} uses; draw on a GPU")]
    NotCovered {
        /// What it is.
        what: String,
        /// Where.
        function: String,
    },
    /// The module is no valid one.
    #[error("the program is not valid: {0}")]
    Invalid(String),
    /// There is no such function.
    #[error("the program has no function {name:?}; there are: {known}")]
    NoFunction {
        /// What was asked for.
        name: String,
        /// What there is.
        known: String,
    },
    /// The arguments do not fit the function.
    #[error("function {function} takes {takes} scalars per lane, {given} were given")]
    Arguments {
        /// The function.
        function: String,
        /// Scalars that it takes.
        takes: usize,
        /// Scalars, or lanes of one of them, that were given.
        given: String,
    },
    /// A resource that the program reads is missing or of another kind.
    #[error("the program reads {name} (group {group}, binding {binding}): {problem}")]
    Resource {
        /// Its name in the program.
        name: String,
        /// Its group.
        group: u32,
        /// Its binding.
        binding: u32,
        /// What is wrong.
        problem: String,
    },
    /// A texture of other numbers than it says.
    #[error(
        "a texture of {dims:?} texels with {channels} channels (1 to 4) was given {given} numbers"
    )]
    Texture {
        /// Texels.
        dims: [u32; 3],
        /// Numbers per texel.
        channels: u32,
        /// Numbers.
        given: usize,
    },
    /// A loop that does not end.
    #[error("a loop of the program did not end after {0} turns; give it a bound")]
    Endless(u32),
    /// A program that does not end.
    #[error(
        "the program did not end after {0} operations for one block of pixels; let its loops turn fewer times, or call less in them"
    )]
    TooMuch(u64),
    /// The Plan was resolved for other data.
    #[error(transparent)]
    OtherData(#[from] strahl_scene::OtherData),
    /// The Plan asks for what slices cannot do.
    #[error(transparent)]
    Slicing(#[from] strahl_program::SlicingError),
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
