//! The opacity that the value is classified to: normals follow what is seen instead of what is
//! stored.
fn gradient_input(position: vec3f) -> f32 {
    return classify(reconstruct(position), position).opacity;
}
