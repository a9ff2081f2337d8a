/// A direction in the axes of the camera: right, up, towards the eye.
/// way: direction.world
fn camera_from_world(way: vec3f) -> vec3f {
    return in_camera(way);
}
