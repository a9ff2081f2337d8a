//! As blinn_phong, with absolute values of both products: light from behind a surface lights it as from the front.
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
    let between = light.direction + to_eye;
    let square = dot(between, between);
    // Light from exactly behind has no half vector.
    let cosine_of_half = select(0.0, abs(dot(normal, between)) * inverseSqrt(square), square > 0.0);
    let highlight = select(0.0, params.specular * pow(min(cosine_of_half, 1.0), params.shininess), square > 0.0);
    return light.radiance * (params.diffuse * abs(dot(normal, light.direction)) * color + highlight);
}
