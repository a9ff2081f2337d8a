//! J. Blinn's half-vector form of Phong's model (1977).
struct Params {
    /// Share of the colour that follows the angle to the light.
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
    var highlight = 0.0;
    let between = light.direction + to_eye;
    let between_length = length(between);
    // Light from exactly behind has no half vector.
    if between_length > 0.0 {
        let cosine_of_half = clamp(dot(normal, between / between_length), 0.0, 1.0);
        highlight = params.specular * pow(cosine_of_half, params.shininess);
    }
    return light.radiance * (params.diffuse * cosine * color + highlight);
}
