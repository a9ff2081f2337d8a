//! Matt: brightness by the cosine of the angle to the light.
struct Params {
    /// Share of the color that follows the angle to the light.
    /// default 0.8, range 0 to 10
    diffuse: f32,
}

fn illuminate(color: vec3f, normal: vec3f, to_eye: vec3f, light: Light) -> vec3f {
    return light.radiance * params.diffuse * max(dot(normal, light.direction), 0.0) * color;
}
