/// The place in the world of a position in the object's voxel space.
/// position: position.voxel
/// result: position.world
fn world_from_voxel(position: vec3f) -> vec3f {
    return place_mm(position);
}
