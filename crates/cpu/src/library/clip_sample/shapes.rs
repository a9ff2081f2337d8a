//! Shapes in the cube from −0.5 to 0.5; what lies exactly on a face is inside.

use crate::lanes::{F32s, Mask, Vec3s, dot};
use crate::levels::Level;

#[inline(always)]
pub fn in_box<S: Level>(unit: Vec3s<S>) -> Mask<S> {
    let half = F32s::splat(0.5);
    unit[0].abs().le(half) & unit[1].abs().le(half) & unit[2].abs().le(half)
}

#[inline(always)]
pub fn in_ellipsoid<S: Level>(unit: Vec3s<S>) -> Mask<S> {
    dot(unit, unit).le(F32s::splat(0.25))
}

#[inline(always)]
pub fn in_cylinder<S: Level>(unit: Vec3s<S>) -> Mask<S> {
    let round = unit[0] * unit[0] + unit[1] * unit[1];
    round.le(F32s::splat(0.25)) & unit[2].abs().le(F32s::splat(0.5))
}
