//! The first place on the ray where the value reaches a threshold.

use crate::lanes::{F32s, Mask};
use crate::levels::Level;

/// Halvings of the bracket around a hit: the place is exact to 1/4096 of a step.
const HALVINGS: u32 = 12;

/// Where in the bracket between `outside` and `inside` (lattice coordinates of two samples, the
/// threshold reached at the second only) the threshold is reached first, by bisection. The upper end
/// of the last bracket is returned, so that the threshold is reached there. `reached` says at which
/// lattice coordinates it is.
///
/// Bisection, not a secant: it needs no value outside, so that it also finds the face of a clip box,
/// and it cannot leave the bracket.
#[inline(always)]
pub fn refine<S: Level>(
    mut outside: F32s<S>,
    mut inside: F32s<S>,
    reached: impl Fn(F32s<S>) -> Mask<S>,
) -> F32s<S> {
    for _ in 0..HALVINGS {
        let middle = (outside + inside) * F32s::splat(0.5);
        let reached = reached(middle);
        inside = reached.select(middle, inside);
        outside = reached.select(outside, middle);
    }
    inside
}
