//! Half the difference of the voxels on either side: 6 reads.
fn gradient(position: vec3f) -> vec3f {
    let ahead = vec3f(
        gradient_input(position + vec3f(1.0, 0.0, 0.0)),
        gradient_input(position + vec3f(0.0, 1.0, 0.0)),
        gradient_input(position + vec3f(0.0, 0.0, 1.0)),
    );
    let behind = vec3f(
        gradient_input(position - vec3f(1.0, 0.0, 0.0)),
        gradient_input(position - vec3f(0.0, 1.0, 0.0)),
        gradient_input(position - vec3f(0.0, 0.0, 1.0)),
    );
    return gradient_per_mm(above_rounding(0.5 * (ahead - behind), max(abs(ahead), abs(behind))));
}
