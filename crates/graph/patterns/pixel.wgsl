/// A pixel of premultiplied color and opacity.
/// color: color.premultiplied
fn pixel(color: vec3f, opacity: f32) -> vec4f {
    return vec4f(color, opacity);
}
