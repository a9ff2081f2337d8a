//! The nearest voxel; halfway between two, the one with the higher index.
fn reconstruct(position: vec3f) -> f32 {
    return fetch(vec3i(floor(position + 0.5)));
}
