//! Lattice points of a packet among the voxels.

use crate::lanes::{I32s, Vec3s, each};
use crate::levels::Level;
use crate::library::fetch::Shape;

/// Lattice points at which the rays are, with what bricks and voxels both need of them.
#[derive(Clone, Copy)]
pub(super) struct Points<S: Level> {
    pub(super) position: Vec3s<S>,
    pub(super) clamped: Vec3s<S>,
    pub(super) cell: [I32s<S>; 3],
}

impl<S: Level> Points<S> {
    #[inline(always)]
    pub(super) fn at(shape: &Shape, position: Vec3s<S>) -> Points<S> {
        let clamped = shape.clamp(position);
        Points {
            position,
            clamped,
            cell: shape.cell(clamped),
        }
    }

    /// How far each point lies into its cell along each axis, 0 to 1.
    #[inline(always)]
    pub(super) fn part(&self) -> Vec3s<S> {
        each!([0, 1, 2], |axis| self.clamped[axis]
            - self.cell[axis].to_f32s())
    }
}
