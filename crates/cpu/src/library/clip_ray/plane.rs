use strahl_scene::plan::{ClipPlane, Ray};

/// Cuts to the half-space normal·p + offset ≥ 0.
pub fn clip(plane: &ClipPlane, ray: &Ray, [t0, t1]: [f64; 2]) -> [f64; 2] {
    let height = plane.normal.dot(ray.origin_mm) + plane.offset_mm;
    let slope = plane.normal.dot(ray.direction);
    if slope == 0.0 {
        return if height >= 0.0 {
            [t0, t1]
        } else {
            [t0, f64::NEG_INFINITY]
        };
    }
    let t = -height / slope;
    if slope > 0.0 {
        [t0.max(t), t1]
    } else {
        [t0, t1.min(t)]
    }
}
