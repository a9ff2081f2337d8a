fn linear_by_texels(position: vec3f) -> f32 {
    let clamped = clamp(position, vec3f(0.0), vec3f(dims() - 1));
    // The last cell ends at the last voxel, and holds it.
    let cell = min(vec3i(clamped), max(dims() - 2, vec3i(0)));
    let part = clamped - vec3f(cell);
    let low = vec4f(
        texel(cell),
        texel(cell + vec3i(0, 1, 0)),
        texel(cell + vec3i(0, 0, 1)),
        texel(cell + vec3i(0, 1, 1)),
    );
    let high = vec4f(
        texel(cell + vec3i(1, 0, 0)),
        texel(cell + vec3i(1, 1, 0)),
        texel(cell + vec3i(1, 0, 1)),
        texel(cell + vec3i(1, 1, 1)),
    );
    // Not `mix`: between equal numbers this is exactly that number, so that constant parts have no gradient.
    let along_x = low + part.x * (high - low);
    let along_y = along_x.xz + part.y * (along_x.yw - along_x.xz);
    return along_y.x + part.z * (along_y.y - along_y.x);
}
