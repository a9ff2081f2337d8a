//! The voxel as it is stored, rescaled.
fn fetch(voxel: vec3i) -> f32 {
    return texel(voxel);
}
