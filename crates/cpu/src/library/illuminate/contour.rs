use super::surface::Surface;
use crate::elementary::exp_of_negative;
use crate::lanes::{F32s, dot};
use crate::levels::Level;

/// Matt, times exp(−strength·s), where s rises smoothly with the slant 1 − |N·V| from `from_slant` to `to_slant`.
#[inline(always)]
pub fn parts<S: Level>(
    surface: &Surface<S>,
    diffuse: f32,
    strength: f32,
    from_slant: f32,
    to_slant: f32,
) -> (F32s<S>, F32s<S>) {
    let (zero, one) = (F32s::zero(), F32s::splat(1.0));
    let slant = one - dot(surface.normal, surface.to_eye).abs();
    let width = (to_slant - from_slant).max(0.01);
    let rise = (slant - F32s::splat(from_slant)).over(F32s::splat(width));
    let rise = rise.max(zero).min(one);
    let silhouette = rise * rise * (F32s::splat(3.0) - (rise + rise));
    let light = exp_of_negative(-(silhouette * F32s::splat(strength)));
    (surface.cosine * F32s::splat(diffuse) * light, zero)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::splat3;
    use crate::levels::Portable;

    #[test]
    fn silhouettes_are_dark_by_the_exponential() {
        for (eye, rise) in [
            (1.0f32, 0.0f64),
            (0.6, 0.0),
            (0.4, 0.5),
            (0.3, 0.75),
            (0.2, 1.0),
            (0.0, 1.0),
        ] {
            for side in [1.0f32, -1.0] {
                let surface = Surface::<Portable> {
                    normal: splat3([0.0, 0.0, 1.0]),
                    to_light: splat3([0.6, 0.0, 0.8]),
                    to_eye: splat3([(1.0 - eye * eye).sqrt(), 0.0, side * eye]),
                    cosine: F32s::splat(0.8),
                };
                let silhouette = rise * rise * (3.0 - 2.0 * rise);
                let expected = 0.8 * 0.5 * (-8.0 * silhouette).exp();
                let got = f64::from(parts(&surface, 0.5, 8.0, 0.4, 0.8).0.lane(0));
                assert!((got - expected).abs() < 2e-6, "{eye}: {got} for {expected}");
            }
        }
    }
}
