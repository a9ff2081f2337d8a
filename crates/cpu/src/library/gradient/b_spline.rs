use crate::lanes::{F32s, Vec3s};
use crate::library::reconstruct::b_spline_weights;

/// The derivative of the uniform cubic B-spline whose coefficients are the field at voxel centres:
/// 64 positions.
pub fn per_voxel(field: &dyn Fn(Vec3s) -> F32s, position: Vec3s) -> Vec3s {
    let cell = position.map(F32s::floor);
    let part = [0, 1, 2].map(|axis| position[axis] - cell[axis]);
    let weights = part.map(b_spline_weights);
    let slopes = part.map(slopes);
    let mut gradient = [F32s::ZERO; 3];
    for z in 0..4 {
        for y in 0..4 {
            for x in 0..4 {
                let tap = [x, y, z];
                let at = [0, 1, 2].map(|axis| cell[axis] + F32s::splat(tap[axis] as f32 - 1.0));
                let value = field(at);
                let [wx, wy, wz] = [0, 1, 2].map(|axis| weights[axis][tap[axis]]);
                let [sx, sy, sz] = [0, 1, 2].map(|axis| slopes[axis][tap[axis]]);
                gradient[0] += value * (sx * wy * wz);
                gradient[1] += value * (wx * sy * wz);
                gradient[2] += value * (wx * wy * sz);
            }
        }
    }
    gradient
}

/// The derivatives of the weights.
#[inline(always)]
fn slopes(a: F32s) -> [F32s; 4] {
    let half = F32s::splat(0.5);
    let b = F32s::splat(1.0) - a;
    let inner = |t: F32s| t * t * F32s::splat(1.5) - t * F32s::splat(2.0);
    [-(b * b * half), inner(a), -inner(b), a * a * half]
}
