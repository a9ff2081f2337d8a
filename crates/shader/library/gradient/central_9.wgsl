//! The mean of the central differences here and at the eight corners of the cube of one voxel
//! around: 54 reads, smooth.
fn gradient(position: vec3f) -> vec3f {
    var sum = per_voxel(position);
    for (var corner = 0u; corner < 8u; corner++) {
        let side = vec3f(vec3u(corner & 1u, (corner >> 1u) & 1u, corner >> 2u));
        sum += per_voxel(position + side - 0.5);
    }
    return gradient_per_mm(sum / 9.0);
}

fn per_voxel(position: vec3f) -> vec3f {
    return 0.5 * vec3f(
        gradient_input(position + vec3f(1.0, 0.0, 0.0)) - gradient_input(position - vec3f(1.0, 0.0, 0.0)),
        gradient_input(position + vec3f(0.0, 1.0, 0.0)) - gradient_input(position - vec3f(0.0, 1.0, 0.0)),
        gradient_input(position + vec3f(0.0, 0.0, 1.0)) - gradient_input(position - vec3f(0.0, 0.0, 1.0)),
    );
}
