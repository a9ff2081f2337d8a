//! Keeps the side of a plane that its normal points to: normal · p + offset_mm ≥ 0.
struct Params {
    /// Towards the side that stays; world space, length 1.
    /// default (0, 0, 1), range -1 to 1
    normal: vec3f,
    /// Signed distance of the world's origin from the plane.
    /// default 0, unit mm
    offset_mm: f32,
    /// Which objects it cuts: bit i stands for object i.
    /// default 4294967295
    objects: u32,
}

fn clip_ray(ray: Ray, interval_mm: vec2f) -> vec2f {
    if ((params.objects >> object()) & 1u) == 0u {
        return interval_mm;
    }
    let height = dot(params.normal, ray.origin_mm) + params.offset_mm;
    let slope = dot(params.normal, ray.direction);
    if slope == 0.0 {
        // Along the plane: all or nothing.
        return select(vec2f(interval_mm.x, interval_mm.x - 1.0), interval_mm, height >= 0.0);
    }
    let crossing = -height / slope;
    if slope > 0.0 {
        return vec2f(max(interval_mm.x, crossing), interval_mm.y);
    }
    return vec2f(interval_mm.x, min(interval_mm.y, crossing));
}
