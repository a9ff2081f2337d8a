use super::transfer::Table;
use crate::lanes::{F32s, Mask, Vec3s};
use crate::levels::Level;
use crate::library::gradient::Gradients;
use crate::library::reconstruct::Values;

/// A sample of each ray, and what a classification may ask of its volume.
pub struct Sample<'v, S: Level> {
    pub value: F32s<S>,
    /// In voxel space.
    pub position: Vec3s<S>,
    /// Where the classification is asked for.
    pub asked: Mask<S>,
    pub table: &'v Table<'v>,
    pub gradients: &'v Gradients,
    pub values: &'v dyn Values<S>,
}
