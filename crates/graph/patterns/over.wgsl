/// A sample behind what was seen so far, front to back (N. Max 1995).
/// color: color.linear
/// opacity: opacity.step
/// sum_color: color.premultiplied
fn over(color: vec3f, opacity: f32, sum_color: vec3f, sum_opacity: f32) -> Over {
    let share = (1.0 - sum_opacity) * opacity;
    return Over(sum_color + share * color, sum_opacity + share);
}

struct Over {
    /// color.premultiplied
    color: vec3f,
    /// of all samples so far
    opacity: f32,
}
