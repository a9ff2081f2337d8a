//! Tone shading (A. Gooch, B. Gooch, P. Shirley and E. Cohen 1998): from a cool tone away from the light to a warm one towards it,
//! so that shape is seen on both sides and nothing becomes black.
struct Params {
    /// Share of both tones that a light adds.
    /// default 0.8, range 0 to 10
    diffuse: f32,
    /// Blue in the cool tone.
    /// default 0.4, range 0 to 1
    cool: f32,
    /// Yellow in the warm tone.
    /// default 0.4, range 0 to 1
    warm: f32,
    /// Share of the surface color in the cool tone.
    /// default 0.2, range 0 to 1
    cool_share: f32,
    /// Share of the surface color in the warm tone.
    /// default 0.6, range 0 to 1
    warm_share: f32,
}

fn illuminate(color: vec3f, normal: vec3f, to_eye: vec3f, light: Light) -> vec3f {
    let part = clamp(0.5 + 0.5 * dot(normal, light.direction), 0.0, 1.0);
    let cool = vec3f(0.0, 0.0, params.cool) + params.cool_share * color;
    let warm = vec3f(params.warm, params.warm, 0.0) + params.warm_share * color;
    return light.radiance * params.diffuse * (part * warm + (1.0 - part) * cool);
}
