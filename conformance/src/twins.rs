//! How alike the two forms of a function are: WGSL, as a program runs it, and its Rust twin.

/// How alike the two forms of a function have to be.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    /// Largest difference of a linear channel, where 1 is white.
    pub tolerance: f32,
    /// Share of the pixels that may be off by more, because a decision falls the other way.
    pub flips: f64,
}

const fn alike(tolerance: f32, flips: f64) -> Tolerance {
    Tolerance { tolerance, flips }
}

/// Arithmetic in single precision, in another order.
const ROUNDING: f32 = 1e-5;
/// The same of values from 0 to 255, whose digits differences use up.
const CANCELLED: f32 = 3e-5;
/// Normals: where a gradient is small, its rounding turns them; highlights and mirrors enlarge that.
const TURNED: f32 = 1e-3;
/// Texture units of hardware have weights of 8 bits, up to 1/512 off in each axis, of the whole range of
/// values; those of software adapters are exact. A gradient has them twice.
pub const HARDWARE_WEIGHTS: f32 = 6.0 / 512.0;

/// How alike the functions of a slot are unless [`EXCEPTIONS`] has the function.
fn of_slot(slot: &str) -> Tolerance {
    match slot {
        // A sample that lies on a face is on either side of it.
        "clip_ray" | "clip_sample" => alike(ROUNDING, 0.005),
        // Opacity by value: what is nearly transparent is divided by little.
        "classify" | "gradient_input" | "gradient" => alike(CANCELLED, 0.0),
        "light" | "illuminate" | "shade" | "illustrate" => alike(TURNED, 0.002),
        _ => alike(ROUNDING, 0.0),
    }
}

/// The functions that are alike in another way than their slot, by slot and name.
pub const EXCEPTIONS: &[(&str, Tolerance)] = &[
    // Triangles are drawn on one, and met by rays on the other: edges.
    ("clip_ray/depth", alike(ROUNDING, 0.01)),
    // The sine of a large number, whose last bits the shift is made of.
    ("jitter/sine_hash", alike(3e-3, 0.02)),
    // Half way between two voxels.
    ("reconstruct/nearest", alike(ROUNDING, 0.005)),
    // A value at the threshold is on either side of it.
    ("classify/threshold", alike(CANCELLED, 0.005)),
    // A place at the border of two segments is in either.
    ("gradient_input/segment", alike(CANCELLED, 0.005)),
    ("shade/gradient_opacity", alike(CANCELLED, 0.0)),
    ("composite/mida", alike(CANCELLED, 0.0)),
    // Whether the value crosses the threshold, and where.
    ("composite/first_hit", alike(CANCELLED, 0.005)),
    ("composite/gmip", alike(CANCELLED, 0.0)),
    // The first sample that is seen.
    ("composite/depth", alike(CANCELLED, 0.005)),
    ("composite/gradient_magnitude", alike(CANCELLED, 0.005)),
    ("composite/normal", alike(TURNED, 0.005)),
    // In values per mm, up to 255, not from 0 to 1.
    ("composite/gradient_raw", alike(TURNED, 0.005)),
    // A sample more or less where the ray leaves.
    ("composite/sample_count", alike(ROUNDING, 0.005)),
];

/// How alike the two forms of a function, slot and name, have to be.
pub fn alike_of(slot: &str, function: &str) -> Tolerance {
    let is_it = |of: &str| of.split_once('/') == Some((slot, function));
    let found = EXCEPTIONS.iter().find(|(of, _)| is_it(of));
    found.map_or(of_slot(slot), |(_, alike)| *alike)
}
