/// 0 to 1 over the sampled extent of the object.
/// position: position.voxel
/// result: position.texture
fn texture_from_voxel(position: vec3f) -> vec3f {
    return (position + 0.5) / vec3f(dims());
}
