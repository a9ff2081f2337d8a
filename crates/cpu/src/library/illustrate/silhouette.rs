use super::IllustratedPlace;
use crate::elementary::{exp_of_negative, powers_of_share};
use crate::lanes::{F32s, Vec3s, dot, length, scale, unit};
use crate::levels::Level;

/// Times exp(−strength·m^weight·ramp): m is the gradient magnitude, and the ramp rises with the slant.
#[inline(always)]
pub fn color<S: Level>(
    color: Vec3s<S>,
    place: &impl IllustratedPlace<S>,
    strength: f32,
    gradient_weight: f32,
    full_per_mm: f32,
    from_slant: f32,
    to_slant: f32,
) -> Vec3s<S> {
    let (zero, one) = (F32s::zero(), F32s::splat(1.0));
    let gradient = place.gradient();
    let (normal, _) = unit(gradient);
    let slant = one - dot(normal, place.to_eye()).abs();
    let rise = (slant - F32s::splat(from_slant)).over(F32s::splat(to_slant - from_slant));
    let rise = rise.max(zero).min(one);
    let steep = length(gradient)
        .over(F32s::splat(full_per_mm))
        .max(zero)
        .min(one);
    let weight = powers_of_share(steep, F32s::splat(gradient_weight));
    let weight = zero.lt(steep).select(weight, zero);
    let silhouette = weight * rise * rise * (F32s::splat(3.0) - (rise + rise));
    scale(
        color,
        exp_of_negative(-(silhouette * F32s::splat(strength))),
    )
}
