//! Differences along the voxel axes.

use crate::lanes::{F32s, Vec3s};

/// A position moved along one axis, in voxels.
#[inline(always)]
fn moved(mut position: Vec3s, axis: usize, by: f32) -> Vec3s {
    position[axis] += F32s::splat(by);
    position
}

/// f(p + 1) − f(p): 4 values.
pub fn forward(field: &dyn Fn(Vec3s) -> F32s, position: Vec3s) -> Vec3s {
    let here = field(position);
    [0, 1, 2].map(|axis| field(moved(position, axis, 1.0)) - here)
}

/// f(p) − f(p − 1): 4 values.
pub fn backward(field: &dyn Fn(Vec3s) -> F32s, position: Vec3s) -> Vec3s {
    let here = field(position);
    [0, 1, 2].map(|axis| here - field(moved(position, axis, -1.0)))
}

/// Half the difference one voxel to either side: 6 values.
pub fn central(field: &dyn Fn(Vec3s) -> F32s, position: Vec3s) -> Vec3s {
    [0, 1, 2].map(|axis| {
        let ahead = field(moved(position, axis, 1.0));
        (ahead - field(moved(position, axis, -1.0))) * F32s::splat(0.5)
    })
}

/// The mean of central differences here and at the corners half a voxel around: 54 values.
pub fn central_9(field: &dyn Fn(Vec3s) -> F32s, position: Vec3s) -> Vec3s {
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
    sum.map(|s| s * F32s::splat(1.0 / 9.0))
}
