//! Whether the surface lies before this sample, and the sample's place.
struct Params {
    /// The value of the surface.
    /// default 0.5
    threshold: f32,
}

/// value: value
/// lattice_point: lattice_point
fn hit_here(value: f32, lattice_point: f32) -> Hit {
    return Hit(lattice_point, value >= params.threshold);
}

struct Hit {
    /// lattice_point
    lattice_point: f32,
    hit: bool,
}
