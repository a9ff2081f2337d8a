fn linear_by_texels(position: vec3f) -> f32 {
    let clamped = clamp(position, vec3f(0.0), vec3f(dims() - 1));
    // The last cell ends at the last voxel, and holds it.
    let cell = min(vec3i(clamped), max(dims() - 2, vec3i(0)));
    let part = clamped - vec3f(cell);
    let near = mix(
        mix(texel(cell), texel(cell + vec3i(1, 0, 0)), part.x),
        mix(texel(cell + vec3i(0, 1, 0)), texel(cell + vec3i(1, 1, 0)), part.x),
        part.y,
    );
    let far = mix(
        mix(texel(cell + vec3i(0, 0, 1)), texel(cell + vec3i(1, 0, 1)), part.x),
        mix(texel(cell + vec3i(0, 1, 1)), texel(cell + vec3i(1, 1, 1)), part.x),
        part.y,
    );
    return mix(near, far, part.z);
}
