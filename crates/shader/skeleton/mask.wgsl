// By eight texels: masks are cut at a threshold, which shows the coarse weights of texture units.
fn mask(index: u32, place: vec3f) -> f32 {
    if any(place < vec3f(0.0)) || any(place > vec3f(1.0)) {
        return 0.0;
    }
    let last = mask_dims(index) - 1;
    let position = clamp(place * vec3f(last + 1) - 0.5, vec3f(0.0), vec3f(last));
    // The last voxel belongs to the last cell: its value may be none.
    let low = min(vec3i(position), max(last - 1, vec3i(0)));
    let high = min(low + 1, last);
    let part = position - vec3f(low);
    let near = mix(
        mix(mask_texel(index, low), mask_texel(index, vec3i(high.x, low.y, low.z)), part.x),
        mix(mask_texel(index, vec3i(low.x, high.y, low.z)), mask_texel(index, vec3i(high.x, high.y, low.z)), part.x),
        part.y,
    );
    let far = mix(
        mix(mask_texel(index, vec3i(low.x, low.y, high.z)), mask_texel(index, vec3i(high.x, low.y, high.z)), part.x),
        mix(mask_texel(index, vec3i(low.x, high.y, high.z)), mask_texel(index, high), part.x),
        part.y,
    );
    return mix(near, far, part.z);
}
