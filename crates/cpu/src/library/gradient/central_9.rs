use super::central;
use super::field::Field;
use crate::lanes::{F32s, Vec3s, each};
use crate::levels::Level;

/// The mean of central differences here and at the corners half a voxel around: 54 values.
#[inline(always)]
pub fn per_voxel<S: Level>(field: &Field<S>, position: Vec3s<S>) -> Vec3s<S> {
    let mut sum = central::per_voxel(field, position);
    for corner in 0..8 {
        let mut at = position;
        for (axis, at) in at.iter_mut().enumerate() {
            *at += F32s::splat(if corner >> axis & 1 == 1 { 0.5 } else { -0.5 });
        }
        for (sum, part) in sum.iter_mut().zip(central::per_voxel(field, at)) {
            *sum += part;
        }
    }
    each!(sum, |s| s * F32s::splat(1.0 / 9.0))
}
