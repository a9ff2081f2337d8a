use super::IllustratedPlace;
use crate::lanes::{F32s, Vec3s, each, scale};
use crate::levels::Level;
use std::f32::consts::TAU;

/// Places around the line to the eye: every other one lies at half the width.
const PLACES: usize = 8;

/// Darker, the more of a ring around the line to the eye is covered by what is opaque there.
#[inline(always)]
pub fn color<S: Level>(
    color: Vec3s<S>,
    place: &impl IllustratedPlace<S>,
    width_mm: f32,
    reach_mm: f32,
    strength: f32,
    steps: u32,
) -> Vec3s<S> {
    let (zero, one) = (F32s::zero(), F32s::splat(1.0));
    let to_eye = place.to_eye();
    let [right, up] = across(to_eye);
    let mut covered = zero;
    for i in 0..PLACES {
        let (sine, cosine) = (i as f32 * (TAU / PLACES as f32)).sin_cos();
        let radius = width_mm * if i % 2 == 1 { 0.5 } else { 1.0 };
        let (sine, cosine) = (F32s::splat(radius * sine), F32s::splat(radius * cosine));
        let mut densest = zero;
        for k in 1..=steps {
            let ahead = F32s::splat(width_mm + reach_mm * k as f32 / steps as f32);
            let offset = each!([0, 1, 2], |c| {
                cosine * right[c] + sine * up[c] + ahead * to_eye[c]
            });
            densest = densest.max(place.opacity_beside(offset));
        }
        covered += densest;
    }
    let share = (F32s::splat(2.0 / PLACES as f32) * covered).min(one);
    scale(color, one - F32s::splat(strength) * share)
}

/// Two unit vectors across `to_eye` and each other.
#[inline(always)]
fn across<S: Level>([x, y, z]: Vec3s<S>) -> [Vec3s<S>; 2] {
    let zero = F32s::zero();
    let is_along_x = F32s::splat(0.6).lt(x.abs());
    // The product with y where the view is along x, elsewhere with x.
    let right = is_along_x.select3([-z, zero, x], [zero, z, -y]);
    let (right, _) = crate::lanes::unit(right);
    let [a, b, c] = right;
    [right, [b * z - c * y, c * x - a * z, a * y - b * x]]
}
