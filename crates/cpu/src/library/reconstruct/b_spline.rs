use crate::lanes::{F32s, Vec3s};
use crate::library::fetch::Fetch;

/// The uniform cubic B-spline over 64 voxels.
pub fn stored<F: Fetch>(fetch: &F, position: Vec3s) -> F32s {
    super::cubic(fetch, position, weights)
}

/// The weights of the four voxels along an axis, `a` behind the second of them.
#[inline(always)]
pub fn weights(a: F32s) -> [F32s; 4] {
    let (one, sixth) = (F32s::splat(1.0), F32s::splat(1.0 / 6.0));
    let b = one - a;
    let outer = |t: F32s| t * t * t * sixth;
    let inner = |t: F32s| {
        (F32s::splat(4.0) - t * t * F32s::splat(6.0) + t * t * t * F32s::splat(3.0)) * sixth
    };
    [outer(b), inner(a), inner(b), outer(a)]
}
