//! Ambient light, multiplied by the surface color, and all lights of the scene. Without a normal the color
//! stays as it is.
struct Params {
    /// Share of the color that is there without light.
    /// default 0.25, range 0 to 10
    ambient: f32,
}

/// color: color.linear
/// normal: direction.world, turned to the eye
/// position: position.voxel
/// to_eye: direction.world
/// result: color.linear
fn lit(color: vec3f, normal: vec3f, position: vec3f, to_eye: vec3f) -> vec3f {
    var seen = color;
    if dot(normal, normal) > 0.0 {
        seen = params.ambient * color + lighting(color, normal, position, to_eye);
    }
    return seen;
}
