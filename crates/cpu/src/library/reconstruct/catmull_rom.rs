use crate::lanes::{F32s, Vec3s};
use crate::library::fetch::Fetch;

/// The spline of E. Catmull and R. Rom (1974) over 64 voxels.
pub fn stored<F: Fetch>(fetch: &F, position: Vec3s) -> F32s {
    super::cubic(fetch, position, weights)
}

#[inline(always)]
fn weights(a: F32s) -> [F32s; 4] {
    let one = F32s::splat(1.0);
    let b = one - a;
    let outer = |near: F32s, far: F32s| near * far * far * F32s::splat(-0.5);
    let inner = |t: F32s| one + t * t * (t * F32s::splat(1.5) - F32s::splat(2.5));
    [outer(a, b), inner(a), inner(b), outer(b, a)]
}
