/// The lattice coordinate of the `k`th sample from the end.
/// result: lattice_point
fn lattice_point_from_end(k: f32, count: f32, jitter_of_ray: f32) -> f32 {
    return count - 1.0 - k + jitter_of_ray;
}
