use super::surface::Surface;
use crate::lanes::{F32s, dot};
use crate::levels::Level;

/// Cel shading (A. Lake et al., NPAR 2000): the cosine in steps, with an outline where the surface turns away from the eye.
#[inline(always)]
pub fn parts<S: Level>(
    surface: &Surface<S>,
    diffuse: f32,
    bands: f32,
    softness: f32,
    outline: f32,
) -> (F32s<S>, F32s<S>) {
    let (zero, one) = (F32s::zero(), F32s::splat(1.0));
    let steps = surface.cosine.min(one) * F32s::splat(bands);
    let whole = steps.floor();
    let rise = (steps - whole - one).over(F32s::splat(softness)) + one;
    let rise = rise.max(zero).min(one);
    let level = whole + rise * rise * (F32s::splat(3.0) - (rise + rise));
    let border = F32s::splat((outline * softness).max(1e-3));
    let inner = (dot(surface.normal, surface.to_eye) - F32s::splat(outline)).over(border) + one;
    let inner = inner.max(zero).min(one);
    let matt = level.over(F32s::splat(bands)) * F32s::splat(diffuse) * inner;
    (matt, zero)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::splat3;
    use crate::levels::Portable;

    /// The share of the color with these cosines to the light and to the eye.
    fn matt(light: f32, eye: f32) -> f32 {
        let surface = Surface::<Portable> {
            normal: splat3([0.0, 0.0, 1.0]),
            to_light: splat3([(1.0 - light * light).sqrt(), 0.0, light]),
            to_eye: splat3([(1.0 - eye * eye).sqrt(), 0.0, eye]),
            cosine: F32s::splat(light),
        };
        parts(&surface, 1.5, 4.0, 0.2, 0.3).0.lane(0)
    }

    #[test]
    fn brightness_has_steps_and_an_outline() {
        // The last fifth of each quarter rises to the next one.
        for (light, expected) in [
            (0.0, 0.0),
            (0.1, 0.0),
            (0.225, 0.125),
            (0.3, 0.25),
            (0.44, 0.25),
            (0.6, 0.5),
            (1.0, 1.0),
        ] {
            let got = matt(light, 0.9);
            assert!((got - 1.5 * expected).abs() < 1e-5, "{light}: {got}");
        }
        assert_eq!(matt(1.0, 0.2), 0.0);
        assert!((matt(1.0, 0.31) - 1.5).abs() < 1e-5);
        assert!((matt(1.0, 0.27) - 0.75).abs() < 1e-4);
    }
}
