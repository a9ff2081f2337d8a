use crate::elementary::power_of_cosine;
use crate::lanes::{F32s, Mask, Vec3s, along, dot, scale};
use crate::library::illuminate::Light;

/// J. Blinn's half-vector form of Phong's model (SIGGRAPH 1977), two-sided: the gradient, turned
/// towards the eye, is the normal N, and
/// colour = ambient·c + Σ radiance·(diffuse·c·max(N·L, 0) + specular·max(N·H, 0)^shininess),
/// the highlight only where N·L > 0. Where the gradient is 0 (or not finite) the colour is c.
pub struct BlinnPhong {
    pub ambient: f32,
    pub diffuse: f32,
    pub specular: f32,
    pub shininess: f32,
}

impl BlinnPhong {
    /// The colour of `surface` towards the eye, seen along `direction`.
    #[inline(always)]
    pub fn colour(
        &self,
        surface: Vec3s,
        gradient: Vec3s,
        direction: Vec3s,
        lights: &[Light],
    ) -> Vec3s {
        let to_eye = direction.map(|d| -d);
        let (normal, lit) = unit(gradient);
        let facing_away = dot(normal, to_eye).lt(F32s::ZERO);
        let normal = facing_away.select3(normal.map(|n| -n), normal);

        let mut colour = scale(surface, F32s::splat(self.ambient));
        for light in lights {
            let to_light = light.direction(to_eye);
            let radiance = light.radiance();
            let cosine = dot(normal, to_light).max(F32s::ZERO);
            let diffuse = cosine * F32s::splat(self.diffuse);
            let highlight = self.highlight(normal, to_light, to_eye, cosine);
            for c in 0..3 {
                colour[c] += radiance[c] * (diffuse * surface[c] + highlight);
            }
        }
        lit.select3(colour, surface)
    }

    #[inline(always)]
    fn highlight(&self, normal: Vec3s, to_light: Vec3s, to_eye: Vec3s, cosine: F32s) -> F32s {
        if self.specular == 0.0 {
            return F32s::ZERO;
        }
        // The half vector has no direction where the light comes exactly from behind: not lit there.
        let (half, has_half) = unit(along(to_light, to_eye, F32s::splat(1.0)));
        let cosine_of_half = dot(normal, half).max(F32s::ZERO).min(F32s::splat(1.0));
        let power = power_of_cosine(cosine_of_half, self.shininess) * F32s::splat(self.specular);
        (F32s::ZERO.lt(cosine) & has_half).select(power, F32s::ZERO)
    }
}

/// `v` scaled to unit length, and where it has a direction. Divided by its largest component first:
/// the square of a small gradient would underflow.
#[inline(always)]
fn unit(v: Vec3s) -> (Vec3s, Mask) {
    let largest = v[0].abs().max(v[1].abs()).max(v[2].abs());
    // NaN anywhere makes the sum NaN, which compares with nothing.
    let sum = v[0].abs() + v[1].abs() + v[2].abs();
    let usable = F32s::ZERO.lt(largest) & sum.lt(F32s::splat(f32::INFINITY));
    let divisor = usable.select(largest, F32s::splat(1.0));
    let v = v.map(|c| usable.select(c, F32s::ZERO).over(divisor));
    let length = usable.select(dot(v, v).sqrt(), F32s::splat(1.0));
    (v.map(|c| c.over(length)), usable)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{LANES, splat3};

    const MODEL: BlinnPhong = BlinnPhong {
        ambient: 0.25,
        diffuse: 0.5,
        specular: 0.5,
        shininess: 8.0,
    };

    fn shade(gradient: [f32; 3], to_light: [f32; 3]) -> [f32; 3] {
        let light = Light::Directional {
            to_light,
            radiance: [1.0, 2.0, 1.0],
        };
        MODEL
            .colour(
                splat3([0.5, 0.25, 0.0]),
                splat3(gradient),
                splat3([0.0, 0.0, -1.0]),
                &[light],
            )
            .map(|c| c.0[LANES - 1])
    }

    fn close(a: [f32; 3], b: [f32; 3]) {
        assert!(
            a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6),
            "{a:?} instead of {b:?}"
        );
    }

    #[test]
    fn head_on_adds_all_three_parts() {
        // N = L = H: radiance·(0.5·c + 0.5) + 0.25·c.
        let lit = [0.125 + 0.25 + 0.5, 0.0625 + 2.0 * (0.125 + 0.5), 0.5];
        close(shade([0.0, 0.0, 3.0], [0.0, 0.0, 1.0]), lit);
        close(shade([0.0, 0.0, -1e-30], [0.0, 0.0, 1.0]), lit);
        close(shade([0.0, 0.0, 1e30], [0.0, 0.0, 1.0]), lit);
    }

    #[test]
    fn light_from_behind_leaves_the_ambient_part() {
        close(
            shade([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]),
            [0.125, 0.0625, 0.0],
        );
    }

    #[test]
    fn a_gradient_without_direction_is_unlit() {
        for gradient in [[0.0; 3], [f32::NAN, 1.0, 0.0], [f32::INFINITY, 0.0, 0.0]] {
            close(shade(gradient, [0.0, 0.0, 1.0]), [0.5, 0.25, 0.0]);
        }
    }
}
