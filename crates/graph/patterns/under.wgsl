/// A sample in front of what was seen so far, back to front.
/// color: color.linear
/// opacity: opacity.step
/// sum_color: color.premultiplied
fn under(color: vec3f, opacity: f32, sum_color: vec3f, sum_opacity: f32) -> Under {
    return Under(mix(sum_color, color, opacity), mix(sum_opacity, 1.0, opacity));
}

struct Under {
    /// color.premultiplied
    color: vec3f,
    /// of all samples so far
    opacity: f32,
}
