//! This voxel minus the one before: 4 reads, noisy, shifted by half a voxel.
fn gradient(position: vec3f) -> vec3f {
    let here = gradient_input(position);
    let beside = vec3f(
        gradient_input(position - vec3f(1.0, 0.0, 0.0)),
        gradient_input(position - vec3f(0.0, 1.0, 0.0)),
        gradient_input(position - vec3f(0.0, 0.0, 1.0)),
    );
    return gradient_per_mm(above_rounding(here - beside, max(abs(beside), vec3f(abs(here)))));
}
