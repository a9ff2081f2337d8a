/// The largest value so far, and where it was.
/// value: value
/// lattice_point: lattice_point
/// best: value
/// best_point: lattice_point
fn larger(value: f32, lattice_point: f32, best: f32, best_point: f32, found: bool) -> Larger {
    if !found || value > best {
        return Larger(value, lattice_point, true);
    }
    return Larger(best, best_point, true);
}

struct Larger {
    /// value
    value: f32,
    /// lattice_point
    lattice_point: f32,
    found: bool,
}
