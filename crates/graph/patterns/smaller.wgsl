/// The smallest value so far, and where it was.
/// value: value
/// lattice_point: lattice_point
/// best: value
/// best_point: lattice_point
fn smaller(value: f32, lattice_point: f32, best: f32, best_point: f32, found: bool) -> Smaller {
    if !found || value < best {
        return Smaller(value, lattice_point, true);
    }
    return Smaller(best, best_point, true);
}

struct Smaller {
    /// value
    value: f32,
    /// lattice_point
    lattice_point: f32,
    found: bool,
}
