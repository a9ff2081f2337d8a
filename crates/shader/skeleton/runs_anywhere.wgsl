// A sample adds nothing to the importance of its run.
fn importance_of_place(position: vec3f) -> f32 {
    return 0.0;
}
