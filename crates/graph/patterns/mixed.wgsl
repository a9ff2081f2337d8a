/// One more object at a place where several are, none before another: what passes is the product of what passes
/// each, and each gives its color by its opacity.
/// color: color.linear
/// opacity: opacity.step
/// light_before: default (0, 0, 0)
/// sum_before: default 0
/// passing_before: default 1
fn mixed(color: vec3f, opacity: f32, light_before: vec3f, sum_before: f32, passing_before: f32) -> Mixed {
    let light = light_before + opacity * color;
    let sum = sum_before + opacity;
    let mean = select(vec3f(0.0), light / sum, sum > 0.0);
    return Mixed(mean, light, sum, passing_before * (1.0 - opacity));
}

struct Mixed {
    /// color.linear
    mean: vec3f,
    /// what all have given
    light: vec3f,
    /// of their opacities
    sum: f32,
    /// what passes all
    passing: f32,
}
