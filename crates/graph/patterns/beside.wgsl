/// Two volumes at one place, neither before the other: what passes is the product of what passes each.
/// color_a: color.linear
/// opacity_a: opacity.step
/// color_b: color.linear
/// opacity_b: opacity.step
fn beside(color_a: vec3f, opacity_a: f32, color_b: vec3f, opacity_b: f32) -> Beside {
    let sum = opacity_a + opacity_b;
    let color = select(vec3f(0.0), (opacity_a * color_a + opacity_b * color_b) / sum, sum > 0.0);
    return Beside(color, 1.0 - (1.0 - opacity_a) * (1.0 - opacity_b));
}

struct Beside {
    /// color.linear
    color: vec3f,
    /// opacity.step
    opacity: f32,
}
