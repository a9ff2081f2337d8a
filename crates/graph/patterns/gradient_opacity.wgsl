//! The opacity scaled by the steepness of the value: borders stay, the inside of a material fades.
struct Params {
    /// The gradient magnitude that leaves the opacity as it is.
    /// default 100, range 1e-30 to 1e30
    full_per_mm: f32,
}

/// opacity: opacity.reference
/// gradient_here: gradient.per_mm
/// result: opacity.reference
fn gradient_opacity(opacity: f32, gradient_here: vec3f) -> f32 {
    return opacity * clamp(magnitude(gradient_here) / params.full_per_mm, 0.0, 1.0);
}
