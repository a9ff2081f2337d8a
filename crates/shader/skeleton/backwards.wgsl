// The ray is walked towards the eye, on the same lattice.
fn in_order(k: f32, count: f32) -> f32 {
    return count - 1.0 - k;
}

fn onward(step: vec3f) -> vec3f {
    return -step;
}

fn way_to(interval: vec2f, lattice_point: f32) -> f32 {
    return lattice_point - interval.y;
}
