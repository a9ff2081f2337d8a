/// The first and last lattice coordinate of an interval of a lattice that begins at `entry_at_mm`.
/// interval_mm: length.mm
/// entry_at_mm: length.mm
fn interval_in_lattice(interval_mm: vec2f, entry_at_mm: f32) -> vec2f {
    return (interval_mm - entry_at_mm) / step_mm();
}
