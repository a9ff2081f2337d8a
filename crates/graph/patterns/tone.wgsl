//! Tone shading (A. Gooch et al. 1998): from cool to warm by the angle to the light, with the color of the
//! object.
struct Params {
    /// The color away from the light.
    /// default (0.05, 0.08, 0.35), range 0 to 10
    cool: vec3f,
    /// The color towards the light.
    /// default (0.9, 0.6, 0.2), range 0 to 10
    warm: vec3f,
    /// Towards the light, world space; its length does not matter.
    /// default (0.3, -0.6, 0.7)
    to_light: vec3f,
    /// Share of the object's own color.
    /// default 0.5, range 0 to 1
    share: f32,
}

/// color: color.linear
/// normal: direction.world
/// result: color.linear
fn tone(color: vec3f, normal: vec3f) -> vec3f {
    let warmth = 0.5 * (1.0 + dot(normal, direction(params.to_light)));
    return mix(mix(params.cool, params.warm, warmth), color * (0.4 + 0.6 * warmth), params.share);
}
