use super::sample::Sample;
use super::surface::Surface;
use crate::lanes::{F32s, I32s, each};
use crate::levels::Level;

/// The eight voxels around are classified, and the premultiplied colors interpolated: what programs
/// did that classify first, for comparison.
#[inline(always)]
pub fn surface<S: Level>(sample: &Sample<S>) -> Surface<S> {
    let (table, values) = (sample.table, sample.values);
    let shape = values.shape();
    let clamped = shape.clamp(sample.position);
    let cell = shape.cell(clamped);
    let part = each!([0, 1, 2], |axis| clamped[axis] - cell[axis].to_f32s());
    let one = F32s::splat(1.0);
    let (mut color, mut opacity) = ([F32s::zero(); 3], F32s::zero());
    for corner in 0..8 {
        let upper = |axis: usize| corner >> axis & 1;
        let voxel = each!([0, 1, 2], |axis| cell[axis] + I32s::splat(upper(axis)));
        let surface = table.at_apart(values.voxel(voxel));
        let mut weight = surface.opacity;
        for (axis, &part) in part.iter().enumerate() {
            weight = weight * if upper(axis) == 1 { part } else { one - part };
        }
        for (sum, c) in color.iter_mut().zip(surface.color) {
            *sum += c * weight;
        }
        opacity += weight;
    }
    let divisor = F32s::zero().lt(opacity).select(opacity, one);
    Surface {
        color: each!(color, |c| c.over(divisor)),
        opacity,
    }
}
