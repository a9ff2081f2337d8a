/// The same step, the other way.
fn backwards(step: vec3f) -> vec3f {
    return -step;
}
