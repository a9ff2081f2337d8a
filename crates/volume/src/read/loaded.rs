//! What was read.

use crate::{Label, Volume};

/// What a file held.
#[derive(Clone, Debug)]
pub struct LoadedVolume {
    /// The grid.
    pub volume: Volume,
    /// Names and colors of the objects, if the file or the options say that its numbers are object
    /// ids. An id occurs once.
    pub labels: Option<Vec<Label>>,
    /// What the user should know: slices left out, fields that were put right.
    pub notes: Vec<String>,
}
