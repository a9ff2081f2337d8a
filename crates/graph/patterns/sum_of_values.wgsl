/// Adds a value.
/// value: value
/// lattice_point: lattice_point
fn sum_of_values(value: f32, lattice_point: f32, sum: f32, number: f32) -> Sum {
    return Sum(sum + value, number + 1.0, lattice_point);
}

struct Sum {
    sum: f32,
    number: f32,
    /// lattice_point
    lattice_point: f32,
}
