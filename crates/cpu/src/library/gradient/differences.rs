//! Differences along the voxel axes.

use super::field::Field;
use crate::lanes::{F32s, Vec3s, each};
use crate::levels::Level;

/// A position moved along one axis, in voxels.
#[inline(always)]
fn moved<S: Level>(mut position: Vec3s<S>, axis: usize, by: f32) -> Vec3s<S> {
    position[axis] += F32s::splat(by);
    position
}

/// f(p + 1) − f(p): 4 values.
#[inline(always)]
pub fn forward<S: Level>(field: &Field<S>, position: Vec3s<S>) -> Vec3s<S> {
    let here = field(position);
    each!([0, 1, 2], |axis| field(moved(position, axis, 1.0)) - here)
}

/// f(p) − f(p − 1): 4 values.
#[inline(always)]
pub fn backward<S: Level>(field: &Field<S>, position: Vec3s<S>) -> Vec3s<S> {
    let here = field(position);
    each!([0, 1, 2], |axis| here - field(moved(position, axis, -1.0)))
}

/// Half the difference one voxel to either side: 6 values.
#[inline(always)]
pub fn central<S: Level>(field: &Field<S>, position: Vec3s<S>) -> Vec3s<S> {
    each!([0, 1, 2], |axis| {
        let ahead = field(moved(position, axis, 1.0));
        (ahead - field(moved(position, axis, -1.0))) * F32s::splat(0.5)
    })
}

/// The mean of central differences here and at the corners half a voxel around: 54 values.
#[inline(always)]
pub fn central_9<S: Level>(field: &Field<S>, position: Vec3s<S>) -> Vec3s<S> {
    let mut sum = central(field, position);
    for corner in 0..8 {
        let mut at = position;
        for (axis, at) in at.iter_mut().enumerate() {
            *at += F32s::splat(if corner >> axis & 1 == 1 { 0.5 } else { -0.5 });
        }
        for (sum, part) in sum.iter_mut().zip(central(field, at)) {
            *sum += part;
        }
    }
    each!(sum, |s| s * F32s::splat(1.0 / 9.0))
}
