// The ray is walked from the eye.
fn in_order(k: f32, count: f32) -> f32 {
    return k;
}

fn onward(step: vec3f) -> vec3f {
    return step;
}

fn way_to(interval: vec2f, lattice_point: f32) -> f32 {
    return interval.x - lattice_point;
}
