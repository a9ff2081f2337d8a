/// A position moved along the ray by a share of a step.
/// position: position.voxel
/// result: position.voxel
fn jittered(position: vec3f, step: vec3f, share: f32) -> vec3f {
    return position + share * step;
}
