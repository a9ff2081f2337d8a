use crate::lanes::{F32s, Vec3s};
use crate::levels::Level;

/// What a value looks like.
#[derive(Clone, Copy)]
pub struct Surface<S: Level> {
    /// Not premultiplied.
    pub color: Vec3s<S>,
    /// Per reference length.
    pub opacity: F32s<S>,
}
