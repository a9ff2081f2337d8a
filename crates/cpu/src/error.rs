//! The one error of this crate.

use strahl_volume::Cancelled;

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Whoever asked for the picture ended it by its [`Control`](strahl_volume::Control).
    #[error("cancelled")]
    Cancelled,
    /// The Plan was resolved for other data.
    #[error(transparent)]
    OtherData(#[from] strahl_scene::OtherData),
    /// A shader function without a twin for the CPU.
    #[error(
        "the function {function} for the slot {slot} has no CPU implementation; draw its program with strahl-evaluate or on a GPU, or remove it"
    )]
    NoTwin {
        /// Name of the function.
        function: String,
        /// Its slot.
        slot: &'static str,
    },
    /// Data that drawing needs (bricks, coefficients, numbers of labels) cannot be made.
    #[error(transparent)]
    Coefficients(strahl_volume::Error),
    /// The step is too short for the length of the rays.
    #[error(
        "a step of {step_mm} mm gives up to {points:.0} samples on a ray; at most {most} are possible, take a step of at least {least_mm} mm"
    )]
    StepTooShort {
        /// Of the Plan.
        step_mm: f64,
        /// On the longest diagonal.
        points: f64,
        /// As many are possible.
        most: f64,
        /// The shortest possible step.
        least_mm: f64,
    },
    /// The option `instructions`, or the environment variable `STRAHL_SIMD`, names no set that there is.
    #[error(
        "there are no instructions {value:?} on this CPU; set STRAHL_SIMD (or the option) to avx512, avx2 or portable, or leave it unset for the fastest set available"
    )]
    NoSuchInstructions {
        /// What it names.
        value: String,
    },
    /// Rays on their way belong to a picture of another size.
    #[error(
        "the plan has {plan:?} rays (columns, rows, frames), the states are those of {states:?}; march the states that were started for this plan"
    )]
    OtherRays {
        /// Columns, rows and frames of the Plan.
        plan: [usize; 3],
        /// Those of the states.
        states: [usize; 3],
    },
    /// There is no room for the picture.
    #[error("no memory for {bytes} bytes of {what}; make the picture smaller")]
    NoMemory {
        /// `the picture` or `its rays`.
        what: &'static str,
        /// As many are needed.
        bytes: u64,
    },
    /// The option `tile` is 0.
    #[error("tile is 0; allowed: 1 and above")]
    NoTile,
    /// The operating system gave no threads.
    #[error("cannot start {threads} threads: {why}")]
    Threads {
        /// Number asked for.
        threads: usize,
        /// What was said.
        why: String,
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
            false => Error::Coefficients(error),
        }
    }
}
