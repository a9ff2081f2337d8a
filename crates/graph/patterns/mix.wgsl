/// Between two colors.
/// a: color.linear
/// b: color.linear
/// result: color.linear
fn mixed(a: vec3f, b: vec3f, share_of_b: f32) -> vec3f {
    return mix(a, b, share_of_b);
}
