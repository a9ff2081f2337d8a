use super::IllustratedPlace;
use crate::lanes::{F32s, Vec3s, dot, each, scale, unit};
use crate::levels::Level;

/// Dark where |N·V| < √(T·κ·(2 − T·κ)), with T the width of the lines and κ the curvature of the surface towards the eye.
#[inline(always)]
pub fn color<S: Level>(
    color: Vec3s<S>,
    place: &impl IllustratedPlace<S>,
    width_mm: f32,
    reach_mm: f32,
    strength: f32,
    softness: f32,
) -> Vec3s<S> {
    let (zero, one) = (F32s::zero(), F32s::splat(1.0));
    let to_eye = place.to_eye();
    let (normal, has_normal) = unit(place.gradient());
    let facing = dot(normal, to_eye);
    let (along, _) = unit(each!([0, 1, 2], |c| to_eye[c] - facing * normal[c]));
    let apart = scale(along, F32s::splat(0.5 * reach_mm));
    let (before, _) = unit(place.gradient_beside(each!(apart, |c| -c)));
    let (behind, _) = unit(place.gradient_beside(apart));
    let turned = dot(each!([0, 1, 2], |c| behind[c] - before[c]), along).abs();
    let curvature = turned.over(F32s::splat(reach_mm));
    let bent = (F32s::splat(width_mm) * curvature).min(one);
    let limit = (bent * (F32s::splat(2.0) - bent)).sqrt();
    let fading = (F32s::splat(softness) * limit).max(F32s::splat(1e-6));
    let inside = (limit - facing.abs()).over(fading).max(zero).min(one);
    let light = one - F32s::splat(strength) * inside;
    scale(color, has_normal.select(light, one))
}
