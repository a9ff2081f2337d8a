//! The phantoms that are one formula each. All but the ramp fill a cube of ±[`HALF_EDGE_MM`].

use super::number::Number;
use super::random::Random;
use super::solid::{Point, length};
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::OnceLock;

/// Half the edge of the cube in mm: formulas stated on −1 to 1 are stretched by this.
pub const HALF_EDGE_MM: f64 = 50.0;

/// Marschner and Lobb's test signal: f_M = 6, α = 0.25.
///
/// S. R. Marschner, R. J. Lobb: "An Evaluation of Reconstruction Filters for Volume Rendering",
/// IEEE Visualization 1994, section 5: on −1 ≤ x, y, z ≤ 1
///
/// ρ = (1 − sin(πz/2) + α(1 + ρ_r(√(x² + y²)))) / (2(1 + α)),  ρ_r(r) = cos(2π f_M cos(πr/2)).
///
/// 0 ≤ ρ ≤ 1. Sampled as there (40³) it is just below the Nyquist limit in the middle rings.
pub fn marschner_lobb<N: Number>(p: Point<N>) -> N {
    const F_M: f64 = 6.0;
    const ALPHA: f64 = 0.25;
    let [x, y, z] = p.map(|c| c * (1.0 / HALF_EDGE_MM));
    let r = (x.squared() + y.squared()).sqrt();
    let rings = ((r * (PI / 2.0)).cos() * (2.0 * PI * F_M)).cos();
    (-(z * (PI / 2.0)).sin() + 1.0 + (rings + 1.0) * ALPHA) * (0.5 / (1.0 + ALPHA))
}

/// Four nested shells, 0.25 at the outermost to 1 at the innermost; 0 between.
///
/// Radii 44, 33, 22, 11 mm; each is flat for 4 mm about its radius with smoothstep edges 2 mm wide.
pub fn shells<N: Number>(p: Point<N>) -> N {
    let r = length(p);
    let mut value = N::constant(0.0);
    for shell in 0..4 {
        let off = (r - 44.0 + 11.0 * f64::from(shell)).abs();
        value = value + (off - 3.0).cover(1.0) * (0.25 * f64::from(shell + 1));
    }
    value
}

/// Twelve shells thinner than a voxel of the default grid: what steps and skipping miss first.
///
/// value = Σ exp(−(r − r_k)² / 2σ²), r_k = 4, 8 … 48 mm, σ = 0.25 mm (0.6 mm wide at half height).
pub fn thin_shells<N: Number>(p: Point<N>) -> N {
    const SIGMA_MM: f64 = 0.25;
    let r = length(p);
    let mut value = N::constant(0.0);
    for shell in 1..=12 {
        let off = r - 4.0 * f64::from(shell);
        value = value + (off.squared() * (-0.5 / (SIGMA_MM * SIGMA_MM))).exp();
    }
    value
}

/// Fog that is thin everywhere: 24 wide Gaussian puffs, nowhere above 0.1.
///
/// value = Σ a_k exp(−|p − c_k|² / 2 s_k²), a_k 0.01 to 0.03, s_k 6 to 14 mm, c_k within 30 mm of the
/// center, from a fixed seed; the sum is scaled so that its bound Σ over overlapping puffs stays below 0.1.
pub fn fog<N: Number>(p: Point<N>) -> N {
    static PUFFS: OnceLock<[(DVec3, f64, f64); 24]> = OnceLock::new();
    let puffs = PUFFS.get_or_init(|| {
        let mut random = Random::new(24);
        std::array::from_fn(|_| {
            let center = random.direction() * (30.0 * random.unit().cbrt());
            let width_mm = random.between(6.0, 14.0);
            (
                center,
                -0.5 / (width_mm * width_mm),
                random.between(0.01, 0.03),
            )
        })
    });
    let mut value = N::constant(0.0);
    for &(center, falloff, height) in puffs {
        let q = [p[0] - center.x, p[1] - center.y, p[2] - center.z];
        let squared = q[0].squared() + q[1].squared() + q[2].squared();
        value = value + (squared * falloff).exp() * height;
    }
    value
}

/// A hydrogen atom, state n = 3, l = 2, m = 0 (3d z²): |ψ|² over its largest value.
///
/// |ψ|² ∝ (3z² − r²)² e^(−2r / 3a), here with a Bohr radius a of 2.5 mm; the largest value lies on the
/// z axis at r = 6a. (The volume called "hydrogen atom" in old papers is another one: that atom sits in a
/// strong magnetic field and has no closed form.)
pub fn hydrogen<N: Number>(p: Point<N>) -> N {
    const BOHR_RADIUS_MM: f64 = 2.5;
    const A4: f64 = BOHR_RADIUS_MM * BOHR_RADIUS_MM * BOHR_RADIUS_MM * BOHR_RADIUS_MM;
    let z2 = p[2].squared();
    let r2 = p[0].squared() + p[1].squared() + z2;
    let angular = (z2 * 3.0 - r2).squared() * (1.0 / (5184.0 * A4));
    angular * (r2.sqrt() * (-2.0 / (3.0 * BOHR_RADIUS_MM)) + 4.0).exp()
}

/// A linear ramp, different along each axis: 100 + x + 2y + 4z, p in mm.
pub fn ramp<N: Number>(p: Point<N>) -> N {
    p[0] + p[1] * 2.0 + p[2] * 4.0 + 100.0
}
