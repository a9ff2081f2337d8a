//! Light that comes along each ray, from the eye.
struct Params {
    /// Linear red, green, blue.
    /// default (1, 1, 1), range 0 to 1000
    radiance: vec3f,
}

fn light(place_mm: vec3f, to_eye: vec3f) -> Light {
    return Light(to_eye, params.radiance);
}
