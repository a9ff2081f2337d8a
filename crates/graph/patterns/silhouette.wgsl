//! Silhouette enhancement (P. Rheingans and D. Ebert 2001): opacity * (kc + ks * (1 - |n.v|)^ke).
struct Params {
    /// kc.
    /// default 0.3, range 0 to 100
    constant: f32,
    /// ks.
    /// default 1.5, range 0 to 100
    strength: f32,
    /// ke.
    /// default 2, range 0 to 100
    exponent: f32,
}

/// opacity: opacity.reference
/// normal: direction.world
/// to_eye: direction.world
/// result: opacity.reference
fn silhouette(opacity: f32, normal: vec3f, to_eye: vec3f) -> f32 {
    var changed = opacity;
    if dot(normal, normal) > 0.0 {
        let edge = 1.0 - min(abs(dot(normal, to_eye)), 1.0);
        changed = clamp(opacity * (params.constant + params.strength * pow(edge, params.exponent)), 0.0, 1.0);
    }
    return changed;
}
