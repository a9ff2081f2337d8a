/// The position in the object's voxel space of a place in the world.
/// place_mm: position.world
/// result: position.voxel
fn voxel_from_world(place_mm: vec3f) -> vec3f {
    return voxel_of(place_mm);
}
