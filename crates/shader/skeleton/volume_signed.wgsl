
// ---- the volume: a texture of signed whole numbers, which no texture unit interpolates ----
@group(0) @binding(2) var volume: texture_3d<i32>;

fn texel(voxel: vec3i) -> f32 {
    let inside = clamp(voxel, vec3i(0), dims() - 1);
    return f32(textureLoad(volume, inside, 0).r) * frame.slope + frame.intercept;
}

fn texel_linear(position: vec3f) -> f32 {
    let clamped = clamp(position, vec3f(0.0), vec3f(frame.dims - 1u));
    let cell = vec3i(floor(clamped));
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
