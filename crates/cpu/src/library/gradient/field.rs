use crate::lanes::{F32s, Vec3s};

/// A field in voxel space.
pub type Field<'f, S> = dyn Fn(Vec3s<S>) -> F32s<S> + 'f;
