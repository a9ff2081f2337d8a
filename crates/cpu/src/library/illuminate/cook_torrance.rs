use super::surface::Surface;
use crate::lanes::{F32s, along, dot, each};
use crate::levels::{Level, inlined};

/// Rough mirror facets (R. Cook and K. Torrance 1982) with the distribution of B. Walter et al.
/// (2007) and the height-correlated masking of E. Heitz (2014), whose denominator is never 0 where
/// the surface is lit: no NaN.
#[inline(always)]
pub fn parts<S: Level>(
    surface: &Surface<S>,
    diffuse: f32,
    roughness: f32,
    reflectance: f32,
) -> (F32s<S>, F32s<S>) {
    let one = F32s::splat(1.0);
    // Where nothing is lit any cosine will do.
    let to_light = surface.cosine.max(F32s::splat(1e-30));
    let eye = dot(surface.normal, surface.to_eye).max(F32s::splat(1e-4));
    let between = along(surface.to_light, surface.to_eye, one);
    let length = dot(between, between).sqrt().max(F32s::splat(1e-4));
    let half = each!(between, |c| c.over(length));
    let a = F32s::splat(roughness * roughness);
    let a2 = a * a;
    let clamped = inlined(
        #[inline(always)]
        |cosine: F32s<S>| cosine.max(F32s::zero()).min(one),
    );
    let cosine_of_half = clamped(dot(surface.normal, half));
    let spread = cosine_of_half * cosine_of_half * (a2 - one) + one;
    // Without 1/π throughout, so that the diffuse part is as bright as Lambert's.
    let facets = a2.over(spread * spread);
    let masked = inlined(
        #[inline(always)]
        |cosine: F32s<S>| (cosine * cosine * (one - a2) + a2).sqrt(),
    );
    let masking = F32s::splat(0.5).over(to_light * masked(eye) + eye * masked(to_light));
    let rest = one - clamped(dot(surface.to_light, half));
    let squared = rest * rest;
    let fresnel =
        F32s::splat(reflectance) + F32s::splat(1.0 - reflectance) * (squared * squared * rest);
    (
        surface.cosine * F32s::splat(diffuse),
        surface.cosine * facets * masking * fresnel,
    )
}
