//! The next voxel minus this one: 4 reads, noisy, shifted by half a voxel.
fn gradient(position: vec3f) -> vec3f {
    let here = gradient_input(position);
    return gradient_per_mm(vec3f(
        gradient_input(position + vec3f(1.0, 0.0, 0.0)),
        gradient_input(position + vec3f(0.0, 1.0, 0.0)),
        gradient_input(position + vec3f(0.0, 0.0, 1.0)),
    ) - here);
}
