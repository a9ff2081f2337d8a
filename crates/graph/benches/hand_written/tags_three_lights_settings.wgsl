// What can be set: the person's program is as little compiled again as the generated one when a light turns.

struct Params {
    /// default (0.3, -0.6, 0.7)
    to_light_1: vec3f,
    /// default (-0.8, -0.2, 0.1)
    to_light_2: vec3f,
    /// default (0.1, 0.9, 0.3)
    to_light_3: vec3f,
    /// default (0.8, 0.8, 0.8)
    radiance: vec3f,
    /// default 0.2
    specular: f32,
    /// default 32
    shininess: f32,
    /// default (0.05, 0.08, 0.35)
    cool: vec3f,
    /// default (0.9, 0.6, 0.2)
    warm: vec3f,
    /// default (0.3, -0.6, 0.7)
    to_warm: vec3f,
    /// default 0.5
    share: f32,
    /// Constant, strength, exponent, full per mm.
    /// default (0.2, 1, 1, 100)
    boundary: vec4f,
    /// Constant, strength, exponent.
    /// default (0.3, 1.5, 2)
    silhouette: vec3f,
    /// default 0.00390625
    stop_at_transmittance: f32,
}

struct Settings {
    to_light_1: vec3f,
    to_light_2: vec3f,
    to_light_3: vec3f,
    radiance: vec3f,
    specular: f32,
    shininess: f32,
    cool: vec3f,
    warm: vec3f,
    to_warm: vec3f,
    share: f32,
    boundary: vec4f,
    silhouette: vec3f,
    stop_at_transmittance: f32,
}

fn settings() -> Settings {
    return Settings(
        params.to_light_1, params.to_light_2, params.to_light_3, params.radiance, params.specular, params.shininess,
        params.cool, params.warm, params.to_warm, params.share, params.boundary, params.silhouette,
        params.stop_at_transmittance,
    );
}
