fn composite_of_sample(state: CompositeState, value: f32, lattice_point: f32, position: vec3f, to_eye: vec3f) -> CompositeState {
    return composite_add(state, Sample(value, lattice_point, position, to_eye));
}
