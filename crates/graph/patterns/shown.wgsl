/// A pixel of color and opacity.
/// color: color.linear
fn shown(color: vec3f, opacity: f32) -> vec4f {
    return vec4f(color * opacity, opacity);
}
