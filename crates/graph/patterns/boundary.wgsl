//! Boundary enhancement (P. Rheingans and D. Ebert 2001): opacity * (kc + ks * |gradient|^ke).
struct Params {
    /// kc.
    /// default 0.2, range 0 to 100
    constant: f32,
    /// ks, of a gradient of `full_per_mm`.
    /// default 1, range 0 to 100
    strength: f32,
    /// ke.
    /// default 1, range 0 to 100
    exponent: f32,
    /// The gradient magnitude that counts as 1.
    /// default 100, range 1e-30 to 1e30
    full_per_mm: f32,
}

/// opacity: opacity.reference
/// gradient_here: gradient.per_mm
/// result: opacity.reference
fn boundary(opacity: f32, gradient_here: vec3f) -> f32 {
    let steep = clamp(magnitude(gradient_here) / params.full_per_mm, 0.0, 1.0);
    return clamp(opacity * (params.constant + params.strength * pow(steep, params.exponent)), 0.0, 1.0);
}
