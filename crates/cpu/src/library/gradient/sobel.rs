use super::field::Field;
use crate::lanes::{F32s, Vec3s};
use crate::levels::Level;

/// I. Sobel's masks in three dimensions, (−1, 0, 1) along one axis and (1, 2, 1) across it, scaled by
/// 1/32 so that a ramp gives its slope: 27 positions.
#[inline(always)]
pub fn per_voxel<S: Level>(field: &Field<S>, position: Vec3s<S>) -> Vec3s<S> {
    let mut first = None;
    let mut gradient = [F32s::zero(); 3];
    let steps = [-1i32, 0, 1];
    for z in steps {
        for y in steps {
            for x in steps {
                let offset = [x, y, z];
                if offset == [0; 3] {
                    continue;
                }
                let mut at = position;
                for (at, by) in at.iter_mut().zip(offset) {
                    *at += F32s::splat(by as f32);
                }
                // Differences from one of them: of equal numbers nothing is left.
                let value = field(at);
                let value = value - *first.get_or_insert(value);
                for axis in 0..3 {
                    let across = (0..3).filter(|other| *other != axis);
                    let weight: i32 = across.map(|other| 2 - offset[other].abs()).product();
                    let weight = (offset[axis] * weight) as f32 / 32.0;
                    if weight != 0.0 {
                        gradient[axis] += value * F32s::splat(weight);
                    }
                }
            }
        }
    }
    gradient
}
