//! Cubic B-spline: smooth to the second derivative, and softer than the data (it does not pass
//! through the voxels' values).
fn reconstruct(position: vec3f) -> f32 {
    return b_spline(position);
}

// Two pairs of voxels per axis, each by its center of gravity: 8 linear steps of 8 voxels instead of 64 products
// (C. Sigg and M. Hadwiger, GPU Gems 2, chapter 20, 2005).
fn b_spline(position: vec3f) -> f32 {
    let clamped = clamp(position, vec3f(0.0), vec3f(dims() - 1));
    // The last cell ends at the last voxel, and holds it.
    let cell = min(floor(clamped), vec3f(max(dims() - 2, vec3i(0))));
    let a = clamped - cell;
    let b = 1.0 - a;
    let w0 = b * b * b / 6.0;
    let w1 = (4.0 - 6.0 * a * a + 3.0 * a * a * a) / 6.0;
    let w3 = a * a * a / 6.0;
    let low_weight = w0 + w1;
    let low = Pair(vec3i(cell) - 1, w1 / low_weight);
    let high = Pair(vec3i(cell) + 1, w3 / (1.0 - low_weight));
    let of_high = vec4f(
        of_pairs(high, high, high),
        of_pairs(high, low, high),
        of_pairs(high, high, low),
        of_pairs(high, low, low),
    );
    let of_low = vec4f(
        of_pairs(low, high, high),
        of_pairs(low, low, high),
        of_pairs(low, high, low),
        of_pairs(low, low, low),
    );
    // Not `mix`: between equal numbers this is exactly that number, so that constant parts have no gradient.
    let along_x = of_high + low_weight.x * (of_low - of_high);
    let along_y = along_x.xz + low_weight.y * (along_x.yw - along_x.xz);
    return along_y.x + low_weight.z * (along_y.y - along_y.x);
}

// Along each axis the first of two voxels, and the share of the second. Of both a value is wanted, also where a
// share is 0: a sample between 64 voxels has none if one of them has none.
struct Pair {
    first: vec3i,
    part: vec3f,
}

fn of_pairs(x: Pair, y: Pair, z: Pair) -> f32 {
    let cell = vec3i(x.first.x, y.first.y, z.first.z);
    let part = vec3f(x.part.x, y.part.y, z.part.z);
    let low = vec4f(
        fetch(cell),
        fetch(cell + vec3i(0, 1, 0)),
        fetch(cell + vec3i(0, 0, 1)),
        fetch(cell + vec3i(0, 1, 1)),
    );
    let high = vec4f(
        fetch(cell + vec3i(1, 0, 0)),
        fetch(cell + vec3i(1, 1, 0)),
        fetch(cell + vec3i(1, 0, 1)),
        fetch(cell + vec3i(1, 1, 1)),
    );
    let along_x = low + part.x * (high - low);
    let along_y = along_x.xz + part.y * (along_x.yw - along_x.xz);
    return along_y.x + part.z * (along_y.y - along_y.x);
}
