//! The derivative of the cubic B-spline whose coefficients are the input at voxel centers: 64 reads, smooth to
//! the first derivative.
fn weights(a: f32) -> vec4f {
    let b = 1.0 - a;
    return vec4f(
        b * b * b,
        4.0 - 6.0 * a * a + 3.0 * a * a * a,
        4.0 - 6.0 * b * b + 3.0 * b * b * b,
        a * a * a,
    ) / 6.0;
}

fn slopes(a: f32) -> vec4f {
    let b = 1.0 - a;
    return vec4f(
        -0.5 * b * b,
        1.5 * a * a - 2.0 * a,
        2.0 * b - 1.5 * b * b,
        0.5 * a * a,
    );
}

fn gradient(position: vec3f) -> vec3f {
    let cell = floor(position);
    let part = position - cell;
    let weight_x = weights(part.x);
    let weight_y = weights(part.y);
    let weight_z = weights(part.z);
    let slope_x = slopes(part.x);
    let slope_y = slopes(part.y);
    let slope_z = slopes(part.z);
    var first = 0.0;
    var largest = 0.0;
    var sum = vec3f(0.0);
    for (var z = 0; z < 4; z++) {
        for (var y = 0; y < 4; y++) {
            for (var x = 0; x < 4; x++) {
                let value = gradient_input(cell + vec3f(vec3i(x, y, z) - 1));
                largest = max(largest, abs(value));
                if x == 0 && y == 0 && z == 0 {
                    first = value;
                }
                // Differences from one of them: of equal numbers nothing is left.
                sum += (value - first) * vec3f(
                    slope_x[x] * weight_y[y] * weight_z[z],
                    weight_x[x] * slope_y[y] * weight_z[z],
                    weight_x[x] * weight_y[y] * slope_z[z],
                );
            }
        }
    }
    return gradient_per_mm(above_rounding(sum, vec3f(largest)));
}
