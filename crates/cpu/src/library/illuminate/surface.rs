use crate::lanes::{F32s, Vec3s};
use crate::levels::Level;

/// A surface under one light.
pub struct Surface<S: Level> {
    pub normal: Vec3s<S>,
    pub to_eye: Vec3s<S>,
    pub to_light: Vec3s<S>,
    /// Of the angle between normal and light, 0 if it comes from behind.
    pub cosine: F32s<S>,
}
