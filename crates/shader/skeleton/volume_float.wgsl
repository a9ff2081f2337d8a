
// ---- the volume: a texture of floats, or of fractions of a whole number ----
@group(0) @binding(2) var volume: texture_3d<f32>;

fn texel(voxel: vec3i) -> f32 {
    let inside = clamp(voxel, vec3i(0), dims() - 1);
    return textureLoad(volume, inside, 0).r * frame.slope + frame.intercept;
}

fn texel_linear(position: vec3f) -> f32 {
    let place = (position + 0.5) / vec3f(frame.dims);
    return textureSampleLevel(volume, volume_sampler, place, 0.0).r * frame.slope + frame.intercept;
}
