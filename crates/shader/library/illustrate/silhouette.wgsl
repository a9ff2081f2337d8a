//! Dark where the surface is steep and seen from the side: the color times exp(−strength·s), s = m^weight·ramp, where m is the
//! gradient magnitude and the ramp rises smoothly with the slant 1 − |N·V|. `importance_aware` measures silhouettes in the same way.
struct Params {
    /// How dark silhouettes become.
    /// default 4, range 0 to 1000
    strength: f32,
    /// Exponent of the gradient magnitude: 0 darkens whatever is seen from the side, larger ones only what is steep.
    /// default 0.5, range 0 to 20
    gradient_weight: f32,
    /// The gradient magnitude that counts as 1.
    /// default 100, range 1e-30 to 1e30
    full_per_mm: f32,
    /// The slant at which the ramp begins: 0 faces the eye, 1 is seen from the side …
    /// default 0.5, range 0 to 1
    from_slant: f32,
    /// … and the one at which it ends. If it is below `from_slant`, what faces the eye is dark.
    /// default 0.9, range 0 to 1, not from_slant
    to_slant: f32,
}

fn illustrate(color: vec3f, position: vec3f, to_eye: vec3f) -> vec3f {
    let here = gradient(position);
    let slant = 1.0 - abs(dot(direction(here), to_eye));
    let rise = clamp((slant - params.from_slant) / (params.to_slant - params.from_slant), 0.0, 1.0);
    let steep = clamp(magnitude(here) / params.full_per_mm, 0.0, 1.0);
    var weight = 0.0;
    if steep > 0.0 {
        weight = pow(steep, params.gradient_weight);
    }
    let silhouette = weight * rise * rise * (3.0 - 2.0 * rise);
    return color * exp(-params.strength * silhouette);
}
