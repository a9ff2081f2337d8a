use crate::lanes::{F32s, Mask, Vec3s, each};
use crate::levels::Level;
use crate::library::reconstruct::Values;

/// Where the values of a mask, linear between its voxels, are above `threshold`; nowhere outside its
/// extent, and nowhere beside a voxel without a value.
#[inline(always)]
pub fn above<S: Level>(mask: &dyn Values<S>, unit: Vec3s<S>, threshold: f32) -> Mask<S> {
    let last = mask.shape().last;
    // The cube is the extent, which reaches half a voxel beyond the voxel centers.
    let position = each!([0, 1, 2], |axis| {
        (unit[axis] + F32s::splat(0.5)) * F32s::splat(last[axis] + 1.0) - F32s::splat(0.5)
    });
    let value = mask.at(position);
    super::shapes::in_box(unit) & value.is_finite() & F32s::splat(threshold).lt(value)
}
