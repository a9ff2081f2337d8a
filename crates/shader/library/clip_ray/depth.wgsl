//! Ends rays at opaque geometry.
fn clip_ray(ray: Ray, interval_mm: vec2f) -> vec2f {
    return vec2f(interval_mm.x, min(interval_mm.y, opaque_mm()));
}
