//! A jaw-like phantom: what the document's CT of a human jaw is to its figures. 12 bits, air 24, water 1024; seeded, the
//! same voxels on every machine.
//!
//! A head-shaped cut of the lower face, x to the left of the picture's viewer, front at y = 0, z up: skin and fat (930)
//! around muscle and tongue (1070), the arch of the lower jaw (spongy 1350 in a shell of 1900), rami, two rows of teeth
//! (dentine 2200, enamel 3000, three fillings 4000), a vertebra behind. Formulas: `docs/sim.md`.

use crate::Error;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use strahl_volume::{Grid, Metadata, Modality, Rescale, Samples, Volume};

const AIR: f64 = 24.0;
const FAT: f64 = 930.0;
const MUSCLE: f64 = 1070.0;
const SPONGY: f64 = 1350.0;
const CORTICAL: f64 = 1900.0;
const DENTINE: f64 = 2200.0;
const ENAMEL: f64 = 3000.0;
const FILLING: f64 = 4000.0;
/// Largest deviation of the noise: too small to carry fat over 1000, where the document's curve begins.
const NOISE: f64 = 14.0;

/// The jaw on a grid of `dims` voxels.
///
/// # Errors
/// If an axis has no voxel, or more than 1024.
pub fn jaw(dims: [usize; 3]) -> Result<Volume, Error> {
    if let Some(n) = dims.iter().find(|n| **n > 1024) {
        return Err(Error::field(
            "jaw dims",
            n,
            "an axis has at most 1024 voxels",
        ));
    }
    let grid = Grid::centered(dims, DVec3::ONE)?;
    let [nx, ny, nz] = dims;
    let scale = 2.0 / nx as f64;
    let at = |i: usize, n: usize| (i as f64 - 0.5 * (n as f64 - 1.0)) * scale;
    let words = (0..ny * nz)
        .into_par_iter()
        .flat_map_iter(|row| {
            let (y, z) = (row % ny, row / ny);
            (0..nx).map(move |x| {
                let p = DVec3::new(at(x, nx), at(y, ny), at(z, nz));
                let value = value(p, scale) + NOISE * noise([x, y, z]);
                value.round().clamp(0.0, 4095.0) as u16
            })
        })
        .collect();
    let metadata = Metadata {
        name: format!("jaw {nx}×{ny}×{nz}"),
        format: "phantom".to_owned(),
        modality: Some(Modality::Ct),
        time_points: 1,
        ..Metadata::default()
    };
    Ok(Volume::new(
        grid,
        Samples::U16(words),
        Rescale::IDENTITY,
        metadata,
    )?)
}

/// 1 well inside a body whose signed distance is `distance` (negative inside), 0 well outside, a slope of two voxels.
fn inside(distance: f64, voxel: f64) -> f64 {
    (0.5 - distance / (2.0 * voxel)).clamp(0.0, 1.0)
}

/// The value at a point; x from −1 to 1, y and z to the same scale.
fn value(p: DVec3, voxel: f64) -> f64 {
    let mut value = AIR;
    let mut lay = |material: f64, distance: f64| {
        let part = inside(distance, voxel);
        value += part * (material - value);
    };
    // Face: an ellipse that narrows towards the chin.
    let narrowing = 0.88 + 0.10 * (p.z + 0.5).min(1.0);
    let face = ellipse(
        DVec2::new(p.x, p.y - 0.12),
        DVec2::new(narrowing, 1.06 * narrowing),
    );
    lay(FAT, face);
    // Muscle and tongue below skin and fat.
    let depth = 0.07 + 0.03 * (3.0 * p.x).cos();
    lay(MUSCLE, face + depth);
    // The mouth's air above the tongue.
    let mouth =
        (DVec3::new(p.x / 0.34, (p.y + 0.10) / 0.38, (p.z - 0.30) / 0.14).length() - 1.0) * 0.14;
    lay(AIR, mouth);

    // Distance from the arch y = −0.62 + 2 x², in the plane.
    let arch = |offset: f64| {
        let x = p.x.abs();
        let slope = 4.0 * x;
        (p.y + 0.62 - 2.0 * x * x - offset) / (1.0 + slope * slope).sqrt()
    };
    let across = arch(0.0);
    let along_end = p.y - 0.46;
    // Body of the lower jaw.
    let height = 0.15;
    let body = ((across / 0.11).powi(2) + ((p.z + 0.24) / height).powi(2)).sqrt() - 1.0;
    let body = (body * 0.11).max(along_end);
    lay(CORTICAL, body);
    lay(SPONGY, body + 0.045);
    // Rami: plates that rise at the ends of the arch.
    let ramus = (across.abs() - 0.075)
        .max(0.20 - p.y)
        .max(along_end)
        .max(-0.40 - p.z);
    lay(CORTICAL, ramus);
    lay(SPONGY, ramus + 0.05);
    // Teeth along the arch, fourteen in each row.
    for i in -7i32..7 {
        let t = (f64::from(i) + 0.5) * 0.070;
        let at = DVec2::new(t, -0.62 + 2.0 * t * t);
        let size = 0.031 + 0.012 * f64::from((2 * i + 1).abs()) / 13.0;
        let radial = (DVec2::new(p.x, p.y) - at).length();
        for (low, high, crown_low) in [(-0.26, 0.115, -0.06), (0.125, 0.46, 0.125)] {
            let root = radial - size * 0.8;
            lay(DENTINE, root.max(low - p.z).max(p.z - high));
            let crown_high = crown_low + 0.175;
            lay(
                ENAMEL,
                (radial - size)
                    .max(crown_low - p.z)
                    .max(p.z - crown_high.min(high)),
            );
        }
        if matches!(i, -6 | 4 | 5) {
            lay(FILLING, (radial - 0.022).max(0.04 - p.z).max(p.z - 0.115));
        }
    }
    // Vertebra, with its canal.
    let vertebra = ellipse(DVec2::new(p.x, p.y - 0.72), DVec2::new(0.26, 0.20));
    lay(CORTICAL, vertebra);
    lay(SPONGY, vertebra + 0.05);
    lay(MUSCLE, (DVec2::new(p.x, p.y - 0.80)).length() - 0.07);
    // Airway.
    lay(
        AIR,
        ellipse(DVec2::new(p.x, p.y - 0.36), DVec2::new(0.13, 0.09)),
    );
    value
}

/// Roughly the distance from an ellipse about the origin.
fn ellipse(p: DVec2, radii: DVec2) -> f64 {
    ((p / radii).length() - 1.0) * radii.min_element()
}

/// −1 to 1, triangular, from a hash of the voxel (splitmix64 finaliser; the seed is the constant).
fn noise([x, y, z]: [usize; 3]) -> f64 {
    let mut h = 0x5EED_0004u64 ^ (x as u64) << 40 ^ (y as u64) << 20 ^ z as u64;
    h = h.wrapping_add(0x9E37_79B9_7F4A_7C15);
    h = (h ^ h >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    h = (h ^ h >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    h ^= h >> 31;
    let part = |bits: u64| (bits & 0xFFFF) as f64 / 65536.0;
    part(h) - part(h >> 16)
}
