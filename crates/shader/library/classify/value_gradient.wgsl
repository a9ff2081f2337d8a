//! A two-dimensional transfer function: color and opacity by value and gradient magnitude, freely drawn (J. Kniss, G. Kindlmann and
//! C. Hansen 2001). Without rows it is the transfer function of the value.
struct Params {
    /// The gradient magnitude of the last row; the first is that of no gradient.
    /// default 100, range 1e-30 to 1e30
    full_per_mm: f32,
    /// Entries of a row.
    /// default 0, range 0 to 65536
    columns: u32,
    /// Rows of the table.
    /// default 0, range 0 to 65536
    rows: u32,
}

fn classify(value: f32, position: vec3f) -> Surface {
    // The largest opacities of all rows.
    let most = table(value);
    if params.rows < 2u || most.opacity <= 0.0 {
        return most;
    }
    let share = magnitude(gradient(position)) / params.full_per_mm;
    return table_2d(value, share, vec2u(params.columns, params.rows));
}
