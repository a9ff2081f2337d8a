//! A lamp; its light falls with the square of the distance.
struct Params {
    /// Where the lamp is; world space.
    /// default (0, 0, 0), unit mm
    place_mm: vec3f,
    /// The distance at which the radiance is as given.
    /// default 500, range 0.001 to 1e6, unit mm
    reach_mm: f32,
    /// Linear red, green, blue.
    /// default (1, 1, 1), range 0 to 1000
    radiance: vec3f,
}

fn light(place_mm: vec3f, to_eye: vec3f) -> Light {
    let way = params.place_mm - place_mm;
    // At the lamp itself there is no direction and no end of brightness.
    let distance = max(length(way), 0.001 * params.reach_mm);
    let fall = params.reach_mm / distance;
    return Light(way / distance, params.radiance * fall * fall);
}
