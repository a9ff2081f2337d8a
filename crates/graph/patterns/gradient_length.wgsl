/// The magnitude of a gradient.
/// gradient_here: gradient.per_mm
fn gradient_length(gradient_here: vec3f) -> f32 {
    return magnitude(gradient_here);
}
