/// The position in voxel space of a place in the sampled extent, 0 to 1.
/// position: position.texture
/// result: position.voxel
fn voxel_from_texture(position: vec3f) -> vec3f {
    return position * vec3f(dims()) - 0.5;
}
