/// How far a lattice point lies from the start of its ray.
/// lattice_point: lattice_point
/// result: length.mm
fn distance_of(lattice_point: f32) -> f32 {
    return distance_mm(lattice_point);
}
