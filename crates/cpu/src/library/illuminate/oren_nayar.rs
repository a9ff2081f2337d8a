use super::surface::Surface;
use crate::lanes::{F32s, dot};
use crate::levels::Level;

/// Matt and rough: the qualitative model of M. Oren and S. Nayar (1994), σ being the roughness,
/// N·L·(A + B·max(0, cos(φ_L − φ_V))·sin α·tan β), A = 1 − σ²/2/(σ² + 0.33), B = 0.45·σ²/(σ² + 0.09), with the larger (α)
/// and the smaller (β) of the angles of light and eye to the normal.
#[inline(always)]
pub fn parts<S: Level>(surface: &Surface<S>, diffuse: f32, roughness: f32) -> (F32s<S>, F32s<S>) {
    let variance = roughness * roughness;
    let a = F32s::splat(1.0 - 0.5 * variance / (variance + 0.33));
    let b = F32s::splat(0.45 * variance / (variance + 0.09));
    let eye = dot(surface.normal, surface.to_eye).max(F32s::zero());
    // L·V − (N·L)(N·V) is the cosine of the azimuths times both sines.
    let together = dot(surface.to_light, surface.to_eye) - surface.cosine * eye;
    // Where nothing is lit any cosine will do.
    let larger = surface.cosine.max(eye).max(F32s::splat(1e-30));
    let turned = together.max(F32s::zero()).over(larger);
    let matt = surface.cosine * F32s::splat(diffuse) * (a + b * turned);
    (matt, F32s::zero())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::splat3;
    use crate::levels::Portable;

    /// Light and eye at these angles to the normal, in one plane, on the same side of it or not.
    fn matt(light: f32, eye: f32, same_side: bool, roughness: f32) -> f32 {
        let side = if same_side { 1.0 } else { -1.0 };
        let surface = Surface::<Portable> {
            normal: splat3([0.0, 0.0, 1.0]),
            to_light: splat3([light.sin(), 0.0, light.cos()]),
            to_eye: splat3([side * eye.sin(), 0.0, eye.cos()]),
            cosine: F32s::splat(light.cos()),
        };
        parts(&surface, 1.0, roughness).0.lane(0)
    }

    #[test]
    fn the_formula_with_angles_gives_the_same() {
        let sigma: f32 = 0.6;
        let a = 1.0 - 0.5 * sigma * sigma / (sigma * sigma + 0.33);
        let b = 0.45 * sigma * sigma / (sigma * sigma + 0.09);
        for (light, eye) in [(0.2f32, 0.9f32), (1.2, 0.3), (0.7, 0.7), (0.0, 1.3)] {
            let (alpha, beta) = (light.max(eye), light.min(eye));
            let same = light.cos() * (a + b * alpha.sin() * beta.tan());
            assert!((matt(light, eye, true, sigma) - same).abs() < 1e-5);
            assert!((matt(light, eye, false, sigma) - light.cos() * a).abs() < 1e-5);
        }
    }

    #[test]
    fn without_roughness_it_is_lambert() {
        for light in [0.0f32, 0.4, 1.1] {
            assert!((matt(light, 0.8, true, 0.0) - light.cos()).abs() < 1e-6);
        }
    }
}
