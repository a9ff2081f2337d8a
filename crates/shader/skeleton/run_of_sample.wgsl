fn run_of_sample(state: CompositeState, value: f32, lattice_point: f32, position: vec3f, to_eye: vec3f) -> CompositeState {
    let before_mm = hit_mm;
    let next = composite_add(state, Sample(value, lattice_point, position, to_eye));
    keep_first_hit(before_mm);
    return next;
}
