//! What segments know of the lattice points around a ray.

use crate::lanes::{F32s, Mask, Vec3s};
use crate::levels::Level;

/// What is known at lattice points behind a ray and where it stands: see
/// [`RayState::values`](crate::ray_state::RayState::values).
#[derive(Clone, Copy)]
pub(super) struct RayHistory<S: Level> {
    pub(super) values: [F32s<S>; 3],
    pub(super) gradient: Vec3s<S>,
    /// A whole number, of which bit i says whether `values[i]` are known, and bit 3 whether the gradient is.
    pub(super) known: F32s<S>,
}

impl<S: Level> RayHistory<S> {
    /// Nothing.
    #[inline(always)]
    pub(super) fn none() -> RayHistory<S> {
        RayHistory {
            values: [F32s::zero(); 3],
            gradient: [F32s::zero(); 3],
            known: F32s::zero(),
        }
    }

    /// Where bit `bit` is set.
    #[inline(always)]
    pub(super) fn knows(&self, bit: u32) -> Mask<S> {
        let bits = self.known.to_i32s().and(1 << bit);
        F32s::zero().lt(bits.to_f32s())
    }
}
