use super::IllustratedPlace;
use crate::lanes::{F32s, Vec3s, each};
use crate::levels::Level;

/// Mixed with another color, up to `strength` from the depth `nearest_mm` to `farthest_mm`.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "the parameters of the function")]
pub fn color<S: Level>(
    color: Vec3s<S>,
    place: &impl IllustratedPlace<S>,
    strength: f32,
    nearest_mm: f32,
    farthest_mm: f32,
    red: f32,
    green: f32,
    blue: f32,
) -> Vec3s<S> {
    let way = place.depth_mm() - F32s::splat(nearest_mm);
    let far = way.over(F32s::splat(farthest_mm - nearest_mm));
    let far = far.max(F32s::zero()).min(F32s::splat(1.0));
    let share = F32s::splat(strength) * far;
    let haze = [red, green, blue];
    each!([0, 1, 2], |c| color[c].lerp(F32s::splat(haze[c]), share))
}
