//! Answers that are known as formulas.

use glam::DVec3;
use strahl_volume::Grid;

/// What passes through `length_mm` of a material of which `reference_mm` have `opacity`.
pub fn transmittance(opacity: f64, reference_mm: f64, length_mm: f64) -> f64 {
    (1.0 - opacity).powf(length_mm / reference_mm)
}

/// What passes through `length_mm` of a material whose opacity per `reference_mm` grows evenly from 0 to
/// `opacity` < 1: exp(∫ ln(1 − opacity·t/length) dt / reference).
pub fn transmittance_of_ramp(opacity: f64, reference_mm: f64, length_mm: f64) -> f64 {
    let rest = 1.0 - opacity;
    let integral = -(rest * rest.ln() + opacity) / opacity;
    (integral * length_mm / reference_mm).exp()
}

/// The length in mm of the part of a ray (unit direction) in a sphere that lies before its origin.
pub fn chord_in_sphere(origin: DVec3, direction: DVec3, center: DVec3, radius: f64) -> f64 {
    match sphere(origin, direction, center, radius) {
        Some([enter, leave]) => (leave.max(0.0) - enter.max(0.0)).max(0.0),
        None => 0.0,
    }
}

/// Where a ray (unit direction) enters and leaves a sphere, in mm from its origin.
pub fn sphere(origin: DVec3, direction: DVec3, center: DVec3, radius: f64) -> Option<[f64; 2]> {
    let to_center = center - origin;
    let middle = to_center.dot(direction);
    let off_axis = (to_center - middle * direction).length_squared();
    let half_squared = radius * radius - off_axis;
    (half_squared > 0.0).then(|| [middle - half_squared.sqrt(), middle + half_squared.sqrt()])
}

/// The length in mm of the part of a ray (unit direction) inside the sampled extent of `grid`, by where it
/// meets the six faces: each is a parallelogram, met by solving for two coordinates on it.
pub fn chord_in_grid(origin: DVec3, direction: DVec3, grid: &Grid) -> f64 {
    let corners = grid.corners_mm();
    let (base, far) = (corners[0], corners[7]);
    let edges = [corners[1] - base, corners[2] - base, corners[4] - base];
    let mut meets: Vec<f64> = Vec::new();
    for i in 0..3 {
        let (u, v) = (edges[(i + 1) % 3], edges[(i + 2) % 3]);
        for (corner, sign) in [(base, 1.0), (far, -1.0)] {
            // origin + t·direction = corner + a·u + b·v
            let system = glam::DMat3::from_cols(-direction, sign * u, sign * v);
            if system.determinant().abs() < 1e-12 * u.length() * v.length() {
                continue;
            }
            let [t, a, b] = (system.inverse() * (origin - corner)).to_array();
            let on_face = -1e-9..=1.0 + 1e-9;
            if on_face.contains(&a) && on_face.contains(&b) {
                meets.push(t.max(0.0));
            }
        }
    }
    let first = meets.iter().copied().fold(f64::INFINITY, f64::min);
    let last = meets.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (last - first).max(0.0)
}
