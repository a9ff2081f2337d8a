//! Sobel's kernel in three dimensions, (-1, 0, 1) × (1, 2, 1) × (1, 2, 1): 26 reads, smooth.
fn gradient(position: vec3f) -> vec3f {
    var first = 0.0;
    var largest = 0.0;
    var sum = vec3f(0.0);
    for (var z = -1; z <= 1; z++) {
        for (var y = -1; y <= 1; y++) {
            for (var x = -1; x <= 1; x++) {
                let side = vec3f(vec3i(x, y, z));
                // 2 in the middle, 1 on either side.
                let weight = 2.0 - abs(side);
                let value = gradient_input(position + side);
                largest = max(largest, abs(value));
                if x == -1 && y == -1 && z == -1 {
                    first = value;
                }
                // Differences from one of them: of equal numbers nothing is left.
                sum += (value - first) * side * vec3f(weight.y * weight.z, weight.x * weight.z, weight.x * weight.y);
            }
        }
    }
    // The weights of one side add up to 16, and the sides are two voxels apart.
    return gradient_per_mm(above_rounding(sum / 32.0, vec3f(largest)));
}
