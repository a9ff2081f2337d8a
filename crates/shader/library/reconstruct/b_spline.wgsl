//! Cubic B-spline: smooth to the second derivative, and softer than the data (it does not pass
//! through the voxels' values).
fn reconstruct(position: vec3f) -> f32 {
    return b_spline(position);
}

// Two taps per axis at the centres of gravity of pairs of weights: 8 linear reads instead of 64
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
    let near = mix(
        mix(linear(vec3f(high.x, high.y, low.z)), linear(vec3f(low.x, high.y, low.z)), low_weight.x),
        mix(linear(vec3f(high.x, low.y, low.z)), linear(vec3f(low.x, low.y, low.z)), low_weight.x),
        low_weight.y,
    );
    let far = mix(
        mix(linear(vec3f(high.x, high.y, high.z)), linear(vec3f(low.x, high.y, high.z)), low_weight.x),
        mix(linear(vec3f(high.x, low.y, high.z)), linear(vec3f(low.x, low.y, high.z)), low_weight.x),
        low_weight.y,
    );
    return mix(far, near, low_weight.z);
}

fn linear(position: vec3f) -> f32 {
    // Clamped first: beyond the border the cell of the border goes on, with the border's value.
    let clamped = clamp(position, vec3f(0.0), vec3f(dims() - 1));
    let cell = vec3i(floor(clamped));
    let part = clamped - vec3f(cell);
    let near = mix(
        mix(fetch(cell), fetch(cell + vec3i(1, 0, 0)), part.x),
        mix(fetch(cell + vec3i(0, 1, 0)), fetch(cell + vec3i(1, 1, 0)), part.x),
        part.y,
    );
    let far = mix(
        mix(fetch(cell + vec3i(0, 0, 1)), fetch(cell + vec3i(1, 0, 1)), part.x),
        mix(fetch(cell + vec3i(0, 1, 1)), fetch(cell + vec3i(1, 1, 1)), part.x),
        part.y,
    );
    return mix(near, far, part.z);
}
