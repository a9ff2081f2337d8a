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

/// All numbers of each voxel, as one volume for each number.
#[derive(Clone, Debug)]
pub struct LoadedComponents {
    /// One volume for each number of a voxel, in the order of the file. They have the same grid and metadata.
    pub volumes: Vec<Volume>,
    /// As in [`LoadedVolume`].
    pub labels: Option<Vec<Label>>,
    /// As in [`LoadedVolume`].
    pub notes: Vec<String>,
}
