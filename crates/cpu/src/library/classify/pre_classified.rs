use super::{Surface, Table};
use crate::lanes::{F32s, I32s, Vec3s};
use crate::library::reconstruct::Values;

/// The eight voxels around are classified, and the premultiplied colours interpolated: what programs
/// did that classify first, for comparison.
pub fn at(table: &Table, values: &dyn Values, position: Vec3s) -> Surface {
    let shape = values.shape();
    let clamped = shape.clamp(position);
    let cell = shape.cell(clamped);
    let part = [0, 1, 2].map(|axis| clamped[axis] - cell[axis].to_f32s());
    let one = F32s::splat(1.0);
    let (mut colour, mut opacity) = ([F32s::ZERO; 3], F32s::ZERO);
    for corner in 0..8 {
        let upper = |axis: usize| corner >> axis & 1;
        let voxel = [0, 1, 2].map(|axis| cell[axis] + I32s([upper(axis); _]));
        let surface = table.at(values.voxel(voxel));
        let mut weight = surface.opacity;
        for (axis, &part) in part.iter().enumerate() {
            weight = weight * if upper(axis) == 1 { part } else { one - part };
        }
        for (sum, c) in colour.iter_mut().zip(surface.colour) {
            *sum += c * weight;
        }
        opacity += weight;
    }
    let divisor = F32s::ZERO.lt(opacity).select(opacity, one);
    Surface {
        colour: colour.map(|c| c.over(divisor)),
        opacity,
    }
}
