use crate::lanes::{F32s, Vec3s};
use crate::levels::Level;

/// A field in voxel space.
pub type Field<'f, S> = dyn Fn(Vec3s<S>) -> F32s<S> + 'f;

/// A position moved along one axis, in voxels.
#[inline(always)]
pub fn moved<S: Level>(mut position: Vec3s<S>, axis: usize, by: f32) -> Vec3s<S> {
    position[axis] += F32s::splat(by);
    position
}
