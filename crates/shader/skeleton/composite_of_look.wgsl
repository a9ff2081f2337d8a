fn composite_of_look(state: CompositeState, value: f32, lattice_point: f32, position: vec3f, to_eye: vec3f, color: vec3f, opacity: f32) -> CompositeState {
    looked_at = Surface(color, opacity);
    return composite_add(state, Sample(value, lattice_point, position, to_eye));
}
