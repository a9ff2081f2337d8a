use super::surface::Surface;
use crate::lanes::{F32s, Vec3s, dot};
use crate::levels::Level;

/// Tone shading (A. Gooch et al., SIGGRAPH 1998): this share of the surface color, and the tones of [`tint`].
#[inline(always)]
pub fn parts<S: Level>(
    surface: &Surface<S>,
    diffuse: f32,
    _cool: f32,
    _warm: f32,
    cool_share: f32,
    warm_share: f32,
) -> (F32s<S>, F32s<S>) {
    let [cool, warm] = [cool_share, warm_share].map(|share| F32s::splat(diffuse * share));
    (cool.lerp(warm, warmth(surface)), F32s::zero())
}

/// What is added to the share of the surface color: yellow towards the light, blue away from it.
#[inline(always)]
pub fn tint<S: Level>(surface: &Surface<S>, diffuse: f32, cool: f32, warm: f32) -> Vec3s<S> {
    let part = warmth(surface);
    let yellow = part * F32s::splat(diffuse * warm);
    let blue = (F32s::splat(1.0) - part) * F32s::splat(diffuse * cool);
    [yellow, yellow, blue]
}

/// 1 towards the light, 0 away from it.
#[inline(always)]
fn warmth<S: Level>(surface: &Surface<S>) -> F32s<S> {
    let half = F32s::splat(0.5);
    let part = half + half * dot(surface.normal, surface.to_light);
    part.max(F32s::zero()).min(F32s::splat(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::splat3;
    use crate::levels::Portable;

    #[test]
    fn towards_the_light_is_warm_and_away_from_it_cool() {
        for (z, share, tones) in [
            (1.0f32, 0.6, [0.4, 0.4, 0.0]),
            (0.0, 0.4, [0.2, 0.2, 0.15]),
            (-1.0, 0.2, [0.0, 0.0, 0.3]),
        ] {
            let surface = Surface::<Portable> {
                normal: splat3([0.0, 0.0, 1.0]),
                to_light: splat3([(1.0 - z * z).sqrt(), 0.0, z]),
                to_eye: splat3([0.0, 0.0, 1.0]),
                cosine: F32s::splat(z.max(0.0)),
            };
            let (of_color, highlight) = parts(&surface, 2.0, 0.3, 0.4, 0.2, 0.6);
            assert!((of_color.lane(0) - 2.0 * share).abs() < 1e-6);
            assert_eq!(highlight.lane(0), 0.0);
            let tint = tint(&surface, 2.0, 0.3, 0.4).map(|t| t.lane(0));
            for (got, expected) in tint.into_iter().zip(tones) {
                assert!((got - 2.0 * expected).abs() < 1e-6, "{z}: {tint:?}");
            }
        }
    }
}
