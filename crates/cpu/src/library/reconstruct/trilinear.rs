use crate::lanes::{F32s, I32s, Mask, Vec3s, each};
use crate::levels::{Level, inlined};
use crate::library::fetch::{Corners, Fetch};

/// Linear in x, then y, then z between the stored numbers of the eight voxels around; clamped at
/// the border.
#[inline(always)]
pub fn stored<S: Level, F: Fetch<S>>(fetch: &F, position: Vec3s<S>) -> F32s<S> {
    let shape = fetch.shape();
    let clamped = shape.clamp(position);
    let cell = shape.cell(clamped);
    let part = [
        clamped[0] - cell[0].to_f32s(),
        clamped[1] - cell[1].to_f32s(),
        clamped[2] - cell[2].to_f32s(),
    ];
    // SAFETY: a cell of the shape of these voxels.
    between(unsafe { fetch.corners(cell) }, part)
}

/// Between corners, at the place `part` of the way along each axis.
#[inline(always)]
pub fn between<S: Level>(corners: Corners<S>, part: Vec3s<S>) -> F32s<S> {
    let row = inlined(
        #[inline(always)]
        |[lower, upper]: [F32s<S>; 2]| lower.lerp(upper, part[0]),
    );
    let near = row(corners[0]).lerp(row(corners[1]), part[1]);
    let far = row(corners[2]).lerp(row(corners[3]), part[1]);
    near.lerp(far, part[2])
}

/// The difference between the stored numbers one voxel ahead of `position` and one behind along each
/// axis, the number at `position`, and where that is so: in cells that are not at the border, of the lanes that are
/// `asked`. `None` if it is nowhere.
///
/// Between the same eight corners the difference of two linear interpolations is the interpolation of
/// differences: 32 voxels, most in words of four, instead of six times eight.
#[inline(always)]
pub fn differences<S: Level, F: Fetch<S>>(
    fetch: &F,
    position: Vec3s<S>,
    asked: Mask<S>,
) -> Option<(Vec3s<S>, F32s<S>, Mask<S>)> {
    let shape = fetch.shape();
    if shape.last_cell[0]
        .min(shape.last_cell[1])
        .min(shape.last_cell[2])
        < 2
    {
        return None;
    }
    let clamped = shape.clamp(position);
    let mut cell = shape.cell(clamped);
    let mut inside = asked;
    for (cell, last) in cell.iter().zip(shape.last_cell) {
        inside = inside & I32s::splat(0).lt(*cell) & cell.lt(I32s::splat(last));
    }
    if !inside.any() {
        return None;
    }
    let part = [
        clamped[0] - cell[0].to_f32s(),
        clamped[1] - cell[1].to_f32s(),
        clamped[2] - cell[2].to_f32s(),
    ];
    // The others look at the second cell.
    let second = I32s::splat(1);
    cell = each!(cell, |cell| inside.select_i32s(cell, second));
    // SAFETY: `inside` is 1 to the last cell but one, and the second cell is: each axis has three cells at least.
    let around = unsafe { fetch.surroundings(cell) }?;
    let row = inlined(
        #[inline(always)]
        |[lower, upper]: [F32s<S>; 2]| lower.lerp(upper, part[0]),
    );
    let middle = inlined(
        #[inline(always)]
        |four: [F32s<S>; 4]| row([four[1], four[2]]),
    );
    let slope = inlined(
        #[inline(always)]
        |four: [F32s<S>; 4]| row([four[2] - four[0], four[3] - four[1]]),
    );
    let [x00, x10, x01, x11] = around.along_x;
    let (y, z) = (around.along_y, around.along_z);
    let near = slope(x00).lerp(slope(x10), part[1]);
    let far = slope(x01).lerp(slope(x11), part[1]);
    let along_x = near.lerp(far, part[2]);
    let (r00, r10, r01, r11) = (middle(x00), middle(x10), middle(x01), middle(x11));
    let near = (r10 - row(y[0])).lerp(row(y[1]) - r00, part[1]);
    let far = (r11 - row(y[2])).lerp(row(y[3]) - r01, part[1]);
    let along_y = near.lerp(far, part[2]);
    let lower = (r01 - row(z[0])).lerp(row(z[2]) - r00, part[2]);
    let upper = (r11 - row(z[1])).lerp(row(z[3]) - r10, part[2]);
    let along_z = lower.lerp(upper, part[1]);
    let near = r00.lerp(r10, part[1]);
    let at = near.lerp(r01.lerp(r11, part[1]), part[2]);
    Some(([along_x, along_y, along_z], at, inside))
}
