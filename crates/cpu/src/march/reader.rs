//! What the values at lattice points come from.

use super::points::Points;
use crate::lanes::F32s;
use crate::levels::Level;
use crate::library::fetch::{Fetch, Linear, Shape};
use crate::library::reconstruct::{Values, trilinear};
use crate::scenery::Object;
use strahl_volume::Sample;

/// Voxels of one type, whose loop is compiled for it, or any values.
pub(super) trait Reader<S: Level> {
    fn shape(&self) -> &Shape;
    /// The values at `points`, which are made of that shape, in the volume of `object`.
    fn values(&self, object: &Object<S>, points: &Points<S>) -> F32s<S>;
}

impl<S: Level, T: Sample> Reader<S> for Linear<'_, T> {
    #[inline(always)]
    fn shape(&self) -> &Shape {
        <Self as Fetch<S>>::shape(self)
    }

    #[inline(always)]
    fn values(&self, object: &Object<S>, points: &Points<S>) -> F32s<S> {
        // SAFETY: points are clamped to the shape that they are made of.
        let corners = unsafe { self.corners(points.cell) };
        object.rescaled(trilinear::between(corners, points.part()))
    }
}

impl<S: Level> Reader<S> for &dyn Values<S> {
    #[inline(always)]
    fn shape(&self) -> &Shape {
        Values::shape(*self)
    }

    #[inline(always)]
    fn values(&self, _: &Object<S>, points: &Points<S>) -> F32s<S> {
        self.at(points.position)
    }
}
