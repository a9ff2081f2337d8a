/// A vector times a number.
fn scaled(v: vec3f, factor: f32) -> vec3f {
    return v * factor;
}
