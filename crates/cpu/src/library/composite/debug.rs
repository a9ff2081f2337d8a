//! Views of how a picture is made.

use crate::lanes::{F32s, Vec3s, splat3};
use crate::library::fetch::Shape;

/// A position in voxel space as a colour: 0 to 1 over the extent along each axis.
pub fn position_colour(shape: &Shape, position: Vec3s) -> Vec3s {
    let (half, one) = (F32s::splat(0.5), F32s::splat(1.0));
    [0, 1, 2].map(|axis| {
        let share = (position[axis] + half).over(F32s::splat(shape.last[axis] + 1.0));
        share.max(F32s::ZERO).min(one)
    })
}

/// A vector as a colour, (v + 1)/2.
pub fn vector_colour(v: Vec3s) -> Vec3s {
    let (half, one) = (F32s::splat(0.5), F32s::splat(1.0));
    v.map(|c| (c * half + half).max(F32s::ZERO).min(one))
}

/// A number as grey.
pub fn grey(value: F32s, black: f32, white: f32) -> Vec3s {
    let share = (value - F32s::splat(black)).over(F32s::splat(white - black));
    let grey = share.max(F32s::ZERO).min(F32s::splat(1.0));
    let mut colour = splat3([0.0; 3]);
    colour.fill(grey);
    colour
}
