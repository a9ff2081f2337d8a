use super::field::Field;
use crate::lanes::{F32s, Vec3s, each};
use crate::levels::{Level, inlined};
use crate::library::reconstruct::b_spline_weights;

/// The derivative of the uniform cubic B-spline whose coefficients are the field at voxel centers:
/// 64 positions.
#[inline(always)]
pub fn per_voxel<S: Level>(field: &Field<S>, position: Vec3s<S>) -> Vec3s<S> {
    let cell = each!(position, |c| F32s::floor(c));
    let part = each!([0, 1, 2], |axis| position[axis] - cell[axis]);
    let weights = each!(part, |c| b_spline_weights(c));
    let slopes = each!(part, |c| slopes(c));
    let mut first = None;
    let mut gradient = [F32s::zero(); 3];
    for z in 0..4 {
        for y in 0..4 {
            for x in 0..4 {
                let tap = [x, y, z];
                let at = each!([0, 1, 2], |axis| {
                    cell[axis] + F32s::splat(tap[axis] as f32 - 1.0)
                });
                // Differences from one of them: of equal numbers nothing is left.
                let value = field(at);
                let value = value - *first.get_or_insert(value);
                let [wx, wy, wz] = each!([0, 1, 2], |axis| weights[axis][tap[axis]]);
                let [sx, sy, sz] = each!([0, 1, 2], |axis| slopes[axis][tap[axis]]);
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
fn slopes<S: Level>(a: F32s<S>) -> [F32s<S>; 4] {
    let half = F32s::splat(0.5);
    let b = F32s::splat(1.0) - a;
    let inner = inlined(
        #[inline(always)]
        |t: F32s<S>| t * t * F32s::splat(1.5) - t * F32s::splat(2.0),
    );
    [-(b * b * half), inner(a), -inner(b), a * a * half]
}
