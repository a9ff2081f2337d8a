use super::cubic::cubic;
use crate::lanes::{F32s, Vec3s};
use crate::levels::{Level, inlined};
use crate::library::fetch::Fetch;

/// The spline of E. Catmull and R. Rom (1974) over 64 voxels.
#[inline(always)]
pub fn stored<S: Level, F: Fetch<S>>(fetch: &F, position: Vec3s<S>) -> F32s<S> {
    cubic(
        fetch,
        position,
        #[inline(always)]
        |a| weights(a),
    )
}

#[inline(always)]
fn weights<S: Level>(a: F32s<S>) -> [F32s<S>; 4] {
    let one = F32s::splat(1.0);
    let b = one - a;
    let outer = inlined(
        #[inline(always)]
        |near: F32s<S>, far: F32s<S>| near * far * far * F32s::splat(-0.5),
    );
    let inner = inlined(
        #[inline(always)]
        |t: F32s<S>| one + t * t * (t * F32s::splat(1.5) - F32s::splat(2.5)),
    );
    [outer(a, b), inner(a), inner(b), outer(b, a)]
}
