//! Unlit, with the opacity scaled by the steepness of the value: borders stay, the inside of a
//! material fades.
struct Params {
    /// The gradient magnitude that leaves the opacity as it is.
    /// default 100, range 1e-30 to 1e30
    full_per_mm: f32,
}

fn shade(surface: Surface, position: vec3f, to_eye: vec3f) -> Surface {
    let part = clamp(magnitude(gradient(position)) / params.full_per_mm, 0.0, 1.0);
    return Surface(surface.color, surface.opacity * part);
}
