use super::cubic::cubic;
use crate::lanes::{F32s, Vec3s};
use crate::levels::{Level, inlined};
use crate::library::fetch::Fetch;

/// The uniform cubic B-spline over 64 voxels.
#[inline(always)]
pub fn stored<S: Level, F: Fetch<S>>(fetch: &F, position: Vec3s<S>) -> F32s<S> {
    cubic(
        fetch,
        position,
        #[inline(always)]
        |a| weights(a),
    )
}

/// The weights of the four voxels along an axis, `a` behind the second of them.
#[inline(always)]
pub fn weights<S: Level>(a: F32s<S>) -> [F32s<S>; 4] {
    let (one, sixth) = (F32s::splat(1.0), F32s::splat(1.0 / 6.0));
    let b = one - a;
    let outer = inlined(
        #[inline(always)]
        |t: F32s<S>| t * t * t * sixth,
    );
    let inner = inlined(
        #[inline(always)]
        |t: F32s<S>| {
            (F32s::splat(4.0) - t * t * F32s::splat(6.0) + t * t * t * F32s::splat(3.0)) * sixth
        },
    );
    [outer(b), inner(a), inner(b), outer(a)]
}
