use super::place::Place;
use crate::lanes::{F32s, Mask, Vec3s, dot, each, scale, splat3, unit};
use crate::levels::Level;
use crate::library::illuminate::illuminate;
use crate::library::light::Light;
use strahl_scene::plan::Illuminate;

/// Ambient light, multiplied by the surface color, and all lights, two-sided: the gradient, turned
/// towards the eye, is the normal. Where it is 0 (or not finite) the last normal of the ray counts;
/// where there is none, the color stays as it is.
#[inline(always)]
pub fn color<S: Level>(
    lights: &[Light],
    model: Illuminate,
    ambient: f32,
    surface: Vec3s<S>,
    place: &Place<S, impl Fn() -> Vec3s<S>, impl Fn() -> Vec3s<S>>,
    shaded: Mask<S>,
    last_normal: &mut Vec3s<S>,
) -> Vec3s<S> {
    let (normal, has_normal) = unit((place.gradient)());
    let normal = has_normal.select3(normal, *last_normal);
    *last_normal = shaded.select3(normal, *last_normal);
    let lit = F32s::zero().lt(dot(normal, normal));
    let facing_away = dot(normal, place.to_eye).lt(F32s::zero());
    let normal = facing_away.select3(each!(normal, |n| -n), normal);
    let place_mm = if lights.iter().any(Light::has_place) {
        (place.place_mm)()
    } else {
        splat3([0.0; 3])
    };

    let mut color = scale(surface, F32s::splat(ambient));
    for light in lights {
        let (to_light, radiance) = light.at(place_mm, place.to_eye);
        let seen = illuminate(model, surface, normal, place.to_eye, to_light, radiance);
        for (sum, part) in color.iter_mut().zip(seen) {
            *sum += part;
        }
    }
    lit.select3(color, surface)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::LANES;
    use crate::levels::Portable;

    const MODEL: Illuminate = Illuminate::BlinnPhong {
        diffuse: 0.5,
        specular: 0.5,
        shininess: 8.0,
    };

    fn shade(
        gradient: [f32; 3],
        to_light: [f32; 3],
        last_normal: &mut Vec3s<Portable>,
    ) -> [f32; 3] {
        let light = Light::Directional {
            to_light,
            radiance: [1.0, 2.0, 1.0],
        };
        let place = Place {
            gradient: || splat3(gradient),
            place_mm: || splat3([0.0; 3]),
            to_eye: splat3([0.0, 0.0, 1.0]),
        };
        let surface = splat3([0.5, 0.25, 0.0]);
        let all = F32s::zero().le(F32s::zero());
        color(&[light], MODEL, 0.25, surface, &place, all, last_normal).map(|c| c.lane(LANES - 1))
    }

    fn shade_first(gradient: [f32; 3], to_light: [f32; 3]) -> [f32; 3] {
        shade(gradient, to_light, &mut [F32s::<Portable>::zero(); 3])
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
        close(shade_first([0.0, 0.0, 3.0], [0.0, 0.0, 1.0]), lit);
        close(shade_first([0.0, 0.0, -1e-30], [0.0, 0.0, 1.0]), lit);
        close(shade_first([0.0, 0.0, 1e30], [0.0, 0.0, 1.0]), lit);
    }

    #[test]
    fn lambert_is_a_mix_of_the_color_and_its_darkening() {
        // Of a share p: N·L + (1 − p − N·L·(1 − p)) = (1 − p) + p·N·L, on both sides of the surface.
        for (p, cosine) in [
            (0.0, 0.6f32),
            (0.25, 0.6),
            (0.25, 0.0),
            (0.8, 1.0),
            (1.0, 0.28),
        ] {
            for side in [1.0, -1.0] {
                let lights = [Light::Directional {
                    to_light: [(1.0 - cosine * cosine).sqrt(), 0.0, cosine],
                    radiance: [1.0; 3],
                }];
                let place = Place {
                    gradient: || splat3([0.0, 0.0, side]),
                    place_mm: || splat3([0.0; 3]),
                    to_eye: splat3([0.0, 0.0, 1.0]),
                };
                let model = Illuminate::Lambert { diffuse: p };
                let all = F32s::<Portable>::zero().le(F32s::zero());
                let surface = splat3([0.5, 0.25, 1.0]);
                let mut last = [F32s::zero(); 3];
                let lit = color(&lights, model, 1.0 - p, surface, &place, all, &mut last);
                let factor = cosine + (1.0 - p - cosine * (1.0 - p));
                let expected = [0.5, 0.25, 1.0].map(|c| c * factor);
                close(lit.map(|c| c.lane(0)), expected);
            }
        }
    }

    #[test]
    fn light_from_behind_leaves_the_ambient_part() {
        close(
            shade_first([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]),
            [0.125, 0.0625, 0.0],
        );
    }

    #[test]
    fn a_gradient_without_direction_is_unlit_or_lit_by_the_last_normal() {
        for gradient in [[0.0; 3], [f32::NAN, 1.0, 0.0], [f32::INFINITY, 0.0, 0.0]] {
            close(shade_first(gradient, [0.0, 0.0, 1.0]), [0.5, 0.25, 0.0]);
            let mut last = [F32s::<Portable>::zero(); 3];
            let lit = shade([0.0, 0.0, 2.0], [0.0, 0.0, 1.0], &mut last);
            close(shade(gradient, [0.0, 0.0, 1.0], &mut last), lit);
        }
    }
}
