//! Parallel light.
struct Params {
    /// Towards the light; world space, length 1.
    /// default (0, 0, 1), range -1 to 1
    to_light: vec3f,
    /// Linear red, green, blue.
    /// default (1, 1, 1), range 0 to 1000
    radiance: vec3f,
}

fn light(place_mm: vec3f, to_eye: vec3f) -> Light {
    return Light(params.to_light, params.radiance);
}
