//! The distance of samples along a ray.

use crate::Scene;
use crate::problem::{Checker, Number};
use strahl_volume::Grid;

/// Twice the samples of the longest ray through the largest cube of isotropic voxels at the default
/// step; a ray with more of them is a slip of the pen.
pub const MAX_SAMPLES_PER_RAY: f64 = 8_388_608.0;

/// The distance of samples along a ray, in the unit that it was said in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Step {
    Mm(f64),
    /// Smallest voxel spacings.
    Voxels(f64),
}

impl Step {
    pub fn settled(scene: &Scene, checker: &mut Checker) -> Step {
        match (scene.step_mm, scene.step_voxels) {
            (Some(mm), voxels) => {
                if let Some(voxels) = voxels {
                    checker.add("step_voxels", voxels, "either step_mm or step_voxels");
                }
                Step::Mm(mm)
            }
            (None, voxels) => Step::Voxels(voxels.unwrap_or(0.5)),
        }
    }

    /// In mm, for rays through `framed`; one that makes no sense is a problem.
    pub fn plan(self, framed: &Grid, spacing_mm: f64, checker: &mut Checker) -> f64 {
        let (key, given, step_mm) = match self {
            Step::Mm(mm) => ("step_mm", mm, mm),
            Step::Voxels(voxels) => ("step_voxels", voxels, voxels * spacing_mm),
        };
        let (lo, hi) = framed.bounds_mm();
        let longest_mm = lo.distance(hi);
        let smallest_mm = longest_mm / MAX_SAMPLES_PER_RAY;
        // NaN is in no interval.
        if (smallest_mm..=longest_mm).contains(&step_mm) && step_mm > 0.0 {
            return step_mm;
        }
        let unit = match self {
            Step::Mm(_) => 1.0,
            Step::Voxels(_) => 1.0 / spacing_mm,
        };
        checker.add(
            key,
            Number(given),
            &format!(
                "{:.3e} (a ray of {MAX_SAMPLES_PER_RAY} samples) to {:.2} (the diagonal of the volume)",
                smallest_mm * unit,
                longest_mm * unit
            ),
        );
        step_mm
    }
}
