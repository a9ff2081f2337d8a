use crate::lanes::{F32s, Vec3s};
use crate::levels::Level;

/// What illustration may ask for about a sample. Each is found only when it is asked for.
pub trait IllustratedPlace<S: Level> {
    /// Towards the eye; a unit vector.
    fn to_eye(&self) -> Vec3s<S>;
    /// The gradient.
    fn gradient(&self) -> Vec3s<S>;
    /// The gradient at the place that is `offset_mm` away in the world.
    fn gradient_beside(&self, offset_mm: Vec3s<S>) -> Vec3s<S>;
    /// The opacity, of the reference length, at the place that is `offset_mm` away; that of the same segment. 0 outside of
    /// the volume.
    fn opacity_beside(&self, offset_mm: Vec3s<S>) -> F32s<S>;
    /// How far in front of the eye it is, along the direction of view.
    fn depth_mm(&self) -> F32s<S>;
}
