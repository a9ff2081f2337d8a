/// The lattice coordinate of sample `k`.
/// result: lattice_point
fn lattice_point(k: f32, jitter_of_ray: f32) -> f32 {
    return k + jitter_of_ray;
}
