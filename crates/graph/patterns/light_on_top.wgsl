//! One more directional light: in * weight + surface * light * max(n.l, 0) + max(n.h, 0)^shininess * light.
//! Chained, the first has the ambient share as weight, the others 1.
struct Params {
    /// Towards the light, world space; its length does not matter.
    /// default (0, 0, 1)
    to_light: vec3f,
    /// Linear RGB, multiplied by the diffuse share of the material.
    /// default (0.8, 0.8, 0.8), range 0 to 100
    radiance: vec3f,
    /// Strength of the highlight, which has the color of the light.
    /// default 0.2, range 0 to 10
    specular: f32,
    /// Exponent of the highlight.
    /// default 32, range 0.01 to 1000
    shininess: f32,
}

/// below: color.linear, what the lights before have made
/// weight: default 1
/// surface: color.linear
/// normal: direction.world
/// to_eye: direction.world
/// result: color.linear
fn light_on_top(below: vec3f, weight: f32, surface: vec3f, normal: vec3f, to_eye: vec3f) -> vec3f {
    let to_light = direction(params.to_light);
    let between = direction(to_light + to_eye);
    let diffuse = max(dot(normal, to_light), 0.0);
    let highlight = select(0.0, pow(max(dot(normal, between), 0.0), params.shininess), diffuse > 0.0);
    return below * weight + params.radiance * (surface * diffuse + params.specular * highlight);
}
