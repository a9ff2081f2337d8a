use super::transfer::Table;
use crate::lanes::{F32s, Mask, Vec3s};
use crate::levels::Level;
use crate::library::gradient::Gradients;
use crate::library::reconstruct::Values;
use std::cell::Cell;

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
    /// Of the values, once it has been asked for: shading may need it, too.
    pub gradient: Cell<Option<Vec3s<S>>>,
}

impl<S: Level> Sample<'_, S> {
    /// The gradient of the value where `asked`, anything elsewhere. (That of the opacity would ask for the
    /// classification itself.)
    #[inline(always)]
    pub fn gradient(&self, asked: Mask<S>) -> Vec3s<S> {
        let gradient = (self.gradients).of_values(self.values, self.position, asked);
        self.gradient.set(Some(gradient));
        gradient
    }
}
