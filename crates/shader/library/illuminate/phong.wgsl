//! B. Phong's model (1975): a highlight around the mirrored light.
struct Params {
    /// Share of the color that follows the angle to the light.
    /// default 0.8, range 0 to 10
    diffuse: f32,
    /// Strength of the white highlight.
    /// default 0.2, range 0 to 10
    specular: f32,
    /// Exponent of the highlight: the larger, the smaller the highlight.
    /// default 32, range 0.01 to 1000
    shininess: f32,
}

fn illuminate(color: vec3f, normal: vec3f, to_eye: vec3f, light: Light) -> vec3f {
    let cosine = dot(normal, light.direction);
    if !(cosine > 0.0) {
        return vec3f(0.0);
    }
    let mirrored = 2.0 * cosine * normal - light.direction;
    let highlight = params.specular * pow(clamp(dot(mirrored, to_eye), 0.0, 1.0), params.shininess);
    return light.radiance * (params.diffuse * cosine * color + highlight);
}
