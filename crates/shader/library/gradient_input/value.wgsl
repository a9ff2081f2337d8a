//! The value itself.
fn gradient_input(position: vec3f) -> f32 {
    return reconstruct(position);
}
