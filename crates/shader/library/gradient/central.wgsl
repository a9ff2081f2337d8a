//! Half the difference of the voxels on either side: 6 reads.
fn gradient(position: vec3f) -> vec3f {
    return gradient_per_mm(per_voxel(position));
}

fn per_voxel(position: vec3f) -> vec3f {
    return 0.5 * vec3f(
        gradient_input(position + vec3f(1.0, 0.0, 0.0)) - gradient_input(position - vec3f(1.0, 0.0, 0.0)),
        gradient_input(position + vec3f(0.0, 1.0, 0.0)) - gradient_input(position - vec3f(0.0, 1.0, 0.0)),
        gradient_input(position + vec3f(0.0, 0.0, 1.0)) - gradient_input(position - vec3f(0.0, 0.0, 1.0)),
    );
}
