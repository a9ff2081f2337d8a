//! Linear in x, y, z between the eight voxels around; clamped at the border.
fn reconstruct(position: vec3f) -> f32 {
    return linear(position);
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
