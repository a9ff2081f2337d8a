use super::field::{Field, moved};
use crate::lanes::{Vec3s, each};
use crate::levels::Level;

/// f(p + 1) − f(p): 4 values.
#[inline(always)]
pub fn per_voxel<S: Level>(field: &Field<S>, position: Vec3s<S>) -> Vec3s<S> {
    let here = field(position);
    each!([0, 1, 2], |axis| field(moved(position, axis, 1.0)) - here)
}
