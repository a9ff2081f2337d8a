/// Whether a lattice point lies in an interval of lattice coordinates, whose end does not belong to it.
/// lattice_point: lattice_point
fn in_interval(lattice_point: f32, interval: vec2f) -> bool {
    return lattice_point >= interval.x && lattice_point < interval.y;
}
