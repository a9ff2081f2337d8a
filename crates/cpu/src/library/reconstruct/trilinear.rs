use crate::lanes::{F32s, Vec3s, lanes};
use crate::library::fetch::Fetch;

/// Linear in x, then y, then z between the stored numbers of the eight voxels around; clamped at
/// the border.
#[inline(always)]
pub fn stored<F: Fetch>(fetch: &F, position: Vec3s) -> F32s {
    let shape = fetch.shape();
    let clamped = shape.clamp(position);
    let cell = shape.cell(clamped);
    let part = [0, 1, 2].map(|axis| clamped[axis] - cell[axis].to_f32s());
    let base = shape.index(cell);
    let [dx, dy, dz] = shape.across;
    let row = |offset: usize| {
        let lower = fetch.fetch(lanes(|i| base[i] + offset));
        let upper = fetch.fetch(lanes(|i| base[i] + offset + dx));
        lower.lerp(upper, part[0])
    };
    let near = row(0).lerp(row(dy), part[1]);
    let far = row(dz).lerp(row(dy + dz), part[1]);
    near.lerp(far, part[2])
}
