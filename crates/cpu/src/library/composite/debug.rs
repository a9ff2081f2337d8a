//! Views of how a picture is made.

use crate::lanes::{F32s, Vec3s, each, splat3};
use crate::levels::Level;
use crate::library::fetch::Shape;

/// A position in voxel space as a colour: 0 to 1 over the extent along each axis.
#[inline(always)]
pub fn position_colour<S: Level>(shape: &Shape, position: Vec3s<S>) -> Vec3s<S> {
    let (half, one) = (F32s::splat(0.5), F32s::splat(1.0));
    each!([0, 1, 2], |axis| {
        let share = (position[axis] + half).over(F32s::splat(shape.last[axis] + 1.0));
        share.max(F32s::zero()).min(one)
    })
}

/// A vector as a colour, (v + 1)/2.
#[inline(always)]
pub fn vector_colour<S: Level>(v: Vec3s<S>) -> Vec3s<S> {
    let (half, one) = (F32s::splat(0.5), F32s::splat(1.0));
    each!(v, |c| (c * half + half).max(F32s::zero()).min(one))
}

/// A number as grey.
#[inline(always)]
pub fn grey<S: Level>(value: F32s<S>, black: f32, white: f32) -> Vec3s<S> {
    let share = (value - F32s::splat(black)).over(F32s::splat(white - black));
    let grey = share.max(F32s::zero()).min(F32s::splat(1.0));
    let mut colour = splat3([0.0; 3]);
    colour.fill(grey);
    colour
}
