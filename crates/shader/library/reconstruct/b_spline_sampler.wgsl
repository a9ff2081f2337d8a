//! Cubic B-spline with the texture unit: 8 reads. Softer than the data.
fn reconstruct(position: vec3f) -> f32 {
    return b_spline(position);
}

// Two taps per axis at the centers of gravity of pairs of weights: 8 linear reads instead of 64
// (C. Sigg and M. Hadwiger, GPU Gems 2, chapter 20, 2005).
fn b_spline(position: vec3f) -> f32 {
    let clamped = clamp(position, vec3f(0.0), vec3f(dims() - 1));
    let cell = floor(clamped);
    let a = clamped - cell;
    let b = 1.0 - a;
    let w0 = b * b * b / 6.0;
    let w1 = (4.0 - 6.0 * a * a + 3.0 * a * a * a) / 6.0;
    let w3 = a * a * a / 6.0;
    let low_weight = w0 + w1;
    let high_weight = 1.0 - low_weight;
    let low = cell - 1.0 + w1 / low_weight;
    let high = cell + 1.0 + w3 / high_weight;
    let of_high = vec4f(
        texel_linear(vec3f(high.x, high.y, high.z)),
        texel_linear(vec3f(high.x, low.y, high.z)),
        texel_linear(vec3f(high.x, high.y, low.z)),
        texel_linear(vec3f(high.x, low.y, low.z)),
    );
    let of_low = vec4f(
        texel_linear(vec3f(low.x, high.y, high.z)),
        texel_linear(vec3f(low.x, low.y, high.z)),
        texel_linear(vec3f(low.x, high.y, low.z)),
        texel_linear(vec3f(low.x, low.y, low.z)),
    );
    // Not `mix`: between equal numbers this is exactly that number, so that constant parts have no gradient.
    let along_x = of_high + low_weight.x * (of_low - of_high);
    let along_y = along_x.xz + low_weight.y * (along_x.yw - along_x.xz);
    return along_y.x + low_weight.z * (along_y.y - along_y.x);
}
