//! J. Blinn's half-vector form of Phong's model (1977).
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
    var lit = vec3f(0.0);
    if cosine > 0.0 {
        let between = light.direction + to_eye;
        let square = dot(between, between);
        // Light from exactly behind has no half vector.
        let cosine_of_half = select(0.0, dot(normal, between) * inverseSqrt(square), square > 0.0);
        let highlight = params.specular * pow(clamp(cosine_of_half, 0.0, 1.0), params.shininess);
        lit = light.radiance * (params.diffuse * cosine * color + highlight);
    }
    return lit;
}
