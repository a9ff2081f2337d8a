/// Black at 0, white at `white`, clamped.
/// result: color.linear
fn grey(number: f32, white: f32) -> vec3f {
    return vec3f(clamp(number / white, 0.0, 1.0));
}
