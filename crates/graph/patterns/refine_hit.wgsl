//! The first place between the sample before and this one where the value reaches the threshold, by 12
//! halvings.
struct Params {
    /// The value of the surface.
    /// default 0.5
    threshold: f32,
}

/// lattice_point: lattice_point
/// result: lattice_point
fn refine_hit(lattice_point: f32) -> f32 {
    // Before the first sample lies the entry, at which a ray may already be inside.
    var outside = max(lattice_point - 1.0, 0.0);
    var inside = lattice_point;
    if lattice_point < 1.0 && reached(0.0) {
        return 0.0;
    }
    for (var i = 0; i < 12; i++) {
        let middle = 0.5 * (outside + inside);
        if reached(middle) {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    return inside;
}

fn reached(lattice_point: f32) -> bool {
    let position = ray_position(lattice_point);
    let value = reconstruct(position);
    // What is infinite is no value, and reaches nothing.
    return is_finite(value) && value >= params.threshold && !clip_sample(place_mm(position));
}
