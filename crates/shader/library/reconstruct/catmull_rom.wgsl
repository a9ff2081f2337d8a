//! Catmull–Rom spline: smooth to the first derivative, passes through the voxels' values, and
//! overshoots at steep edges. 64 voxels (E. Catmull and R. Rom, 1974).
fn weights(a: f32) -> vec4f {
    let b = 1.0 - a;
    return vec4f(
        -0.5 * a * b * b,
        1.0 + a * a * (1.5 * a - 2.5),
        1.0 + b * b * (1.5 * b - 2.5),
        -0.5 * b * a * a,
    );
}

fn reconstruct(position: vec3f) -> f32 {
    let clamped = clamp(position, vec3f(0.0), vec3f(dims() - 1));
    // The last cell ends at the last voxel, and holds it.
    let cell = min(floor(clamped), vec3f(max(dims() - 2, vec3i(0))));
    let part = clamped - cell;
    let corner = vec3i(cell) - 1;
    let across_x = weights(part.x);
    let across_y = weights(part.y);
    let across_z = weights(part.z);
    // Added up are differences from the first voxel, so that of equal numbers nothing is left but that number:
    // constant parts have no gradient.
    var first = 0.0;
    var sum = 0.0;
    for (var z = 0; z < 4; z++) {
        for (var y = 0; y < 4; y++) {
            let row = corner + vec3i(0, y, z);
            let values = vec4f(
                fetch(row),
                fetch(row + vec3i(1, 0, 0)),
                fetch(row + vec3i(2, 0, 0)),
                fetch(row + vec3i(3, 0, 0)),
            );
            if y == 0 && z == 0 {
                first = values.x;
            }
            sum += across_z[z] * across_y[y] * dot(across_x, values - first);
        }
    }
    return first + sum;
}
