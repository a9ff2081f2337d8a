use super::field::{Field, moved};
use crate::lanes::{F32s, Vec3s, each};
use crate::levels::Level;

/// Half the difference one voxel to either side: 6 values.
#[inline(always)]
pub fn per_voxel<S: Level>(field: &Field<S>, position: Vec3s<S>) -> Vec3s<S> {
    each!([0, 1, 2], |axis| {
        let ahead = field(moved(position, axis, 1.0));
        (ahead - field(moved(position, axis, -1.0))) * F32s::splat(0.5)
    })
}
