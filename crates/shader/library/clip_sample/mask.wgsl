//! Drops what lies where a mask is not above a threshold, or where it is. Outside the mask's extent,
//! and beside voxels without a value, is no mask.
struct Params {
    /// First row of the affine map from the world (mm) to the cube from -0.5 to 0.5 that the mask's extent is, then its shift.
    /// default (0.01, 0, 0, 0)
    unit_from_world_x: vec4f,
    /// Second row.
    /// default (0, 0.01, 0, 0)
    unit_from_world_y: vec4f,
    /// Third row.
    /// default (0, 0, 0.01, 0)
    unit_from_world_z: vec4f,
    /// Which of the masks.
    /// default 0, range 0 to 3
    mask: u32,
    /// Inside is above this, in numbers of the mask's texture.
    /// default 0.5
    threshold: f32,
    /// 1 keeps the inside, 0 the outside.
    /// default 1, range 0 to 1
    keep_inside: u32,
    /// Which objects it cuts: bit i stands for object i.
    /// default 4294967295
    objects: u32,
}

fn unit(place_mm: vec3f) -> vec3f {
    let p = vec4f(place_mm, 1.0);
    return vec3f(
        dot(params.unit_from_world_x, p),
        dot(params.unit_from_world_y, p),
        dot(params.unit_from_world_z, p),
    );
}

fn clip_sample(place_mm: vec3f) -> bool {
    if ((params.objects >> object()) & 1u) == 0u {
        return false;
    }
    let number = mask(params.mask, unit(place_mm) + 0.5);
    let inside = is_finite(number) && number > params.threshold;
    return inside != (params.keep_inside == 1u);
}
