use crate::lanes::{F32s, Vec3s};
use crate::levels::Level;

/// A number as gray.
#[inline(always)]
pub fn grey<S: Level>(value: F32s<S>, black: f32, white: f32) -> Vec3s<S> {
    let share = (value - F32s::splat(black)).over(F32s::splat(white - black));
    [share.max(F32s::zero()).min(F32s::splat(1.0)); 3]
}
