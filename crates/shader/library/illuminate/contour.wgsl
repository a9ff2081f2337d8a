//! Matt, with dark silhouettes: light is damped where the surface turns away from the eye, by exp(-strength * s), where s rises
//! from 0 to 1 with the slant 1 - |N * V| (J. Groll 2017, after R. de Moura Pinto and C. Freitas 2010).
struct Params {
    /// Share of the color that follows the angle to the light.
    /// default 0.8, range 0 to 10
    diffuse: f32,
    /// How dark silhouettes are.
    /// default 8, range 0 to 50
    strength: f32,
    /// The slant at which they begin.
    /// default 0.4, range 0 to 1
    from_slant: f32,
    /// The slant at which they are complete, above that at which they begin.
    /// default 0.8, range 0 to 1
    to_slant: f32,
}

fn illuminate(color: vec3f, normal: vec3f, to_eye: vec3f, light: Light) -> vec3f {
    let slant = 1.0 - abs(dot(normal, to_eye));
    let rise = clamp((slant - params.from_slant) / max(params.to_slant - params.from_slant, 0.01), 0.0, 1.0);
    let dark = exp(-params.strength * rise * rise * (3.0 - 2.0 * rise));
    return light.radiance * params.diffuse * max(dot(normal, light.direction), 0.0) * dark * color;
}
