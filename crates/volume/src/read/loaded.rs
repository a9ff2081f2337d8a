//! What was read.

use crate::{Label, Volume};

/// What a file held.
#[derive(Clone, Debug)]
pub struct LoadedVolume {
    /// The grid.
    pub volume: Volume,
    /// Names and colours of the objects, if the file says that its numbers are object ids.
    pub labels: Option<Vec<Label>>,
    /// What the user should know: slices left out, fields that were put right.
    pub notes: Vec<String>,
}
