/// Color times opacity.
/// color: color.linear
/// result: color.premultiplied
fn premultiply(color: vec3f, opacity: f32) -> vec3f {
    return color * opacity;
}
