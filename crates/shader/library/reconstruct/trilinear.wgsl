//! Linear in x, y, z between the eight voxels around; clamped at the border.
fn reconstruct(position: vec3f) -> f32 {
    return linear(position);
}

fn linear(position: vec3f) -> f32 {
    // Clamped first: beyond the border the cell of the border goes on, with the border's value. The last cell
    // ends at the last voxel, and holds it.
    let clamped = clamp(position, vec3f(0.0), vec3f(dims() - 1));
    let cell = min(vec3i(clamped), max(dims() - 2, vec3i(0)));
    let part = clamped - vec3f(cell);
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
    // Not `mix`: between equal numbers this is exactly that number, so that constant parts have no gradient.
    let along_x = low + part.x * (high - low);
    let along_y = along_x.xz + part.y * (along_x.yw - along_x.xz);
    return along_y.x + part.z * (along_y.y - along_y.x);
}
