use crate::lanes::{F32s, Vec3s, each};
use crate::levels::Level;

/// A vector as a color, (v + 1)/2.
#[inline(always)]
pub fn vector_color<S: Level>(v: Vec3s<S>) -> Vec3s<S> {
    let (half, one) = (F32s::splat(0.5), F32s::splat(1.0));
    each!(v, |c| (c * half + half).max(F32s::zero()).min(one))
}
