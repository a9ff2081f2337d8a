/// As `over`, for a sample whose color is multiplied by its opacity already.
/// color: color.premultiplied
/// opacity: opacity.step
/// sum_color: color.premultiplied
fn over_associated(color: vec3f, opacity: f32, sum_color: vec3f, sum_opacity: f32) -> Over {
    let passing = 1.0 - sum_opacity;
    return Over(sum_color + passing * color, sum_opacity + passing * opacity);
}

struct Over {
    /// color.premultiplied
    color: vec3f,
    /// of all samples so far
    opacity: f32,
}
