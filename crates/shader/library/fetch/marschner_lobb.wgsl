//! The test signal of S. Marschner and R. Lobb (Visualization 1994) instead of what is stored, -1 to 1 over the
//! voxel centers along each axis: it shows how well reconstruction works.
struct Params {
    /// Waves from the center to the border.
    /// default 6, range 0 to 1000
    frequency: f32,
    /// How high they are.
    /// default 0.25, range 0 to 1000
    alpha: f32,
}

const PI: f32 = 3.14159265;

fn fetch(voxel: vec3i) -> f32 {
    let last = dims() - 1;
    let place = 2.0 * vec3f(clamp(voxel, vec3i(0), last)) / max(vec3f(last), vec3f(1.0)) - 1.0;
    let wave = cos(2.0 * PI * params.frequency * cos(0.5 * PI * length(place.xy)));
    let slope = 1.0 - sin(0.5 * PI * place.z);
    return (slope + params.alpha * (1.0 + wave)) / (2.0 * (1.0 + params.alpha));
}
