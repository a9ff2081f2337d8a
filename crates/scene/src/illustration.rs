//! What functions of the slot illustrate are told of the scene, where it does not set it.

use crate::FunctionUse;
use crate::plan::{Illustrate, Plan, Technique};
use std::collections::BTreeMap;

/// Lines of contours are as wide as so many voxels.
const LINE_VOXELS: f64 = 1.5;
/// Normals for curvature are taken as far apart as so many voxels.
const REACH_VOXELS: f64 = 2.0;
/// Halos are as wide as so many voxels …
const HALO_VOXELS: f64 = 4.0;
/// … and fall on what lies up to so many voxels behind.
const HALO_REACH_VOXELS: f64 = 80.0;

/// The functions that a scene, or a technique of it, names.
type Functions = BTreeMap<String, FunctionUse>;

/// Gives `parameter` of slot illustrate this value unless `functions` set it.
fn give(functions: &Functions, name: &str, parameter: &mut f32, value: f64) {
    let function = functions.get("illustrate");
    if !function.is_some_and(|function| function.params.contains_key(name)) {
        *parameter = value as f32;
    }
}

/// Fits the illustration of all techniques of `plan` to its voxels and its camera, and to a gradient magnitude that counts
/// as steep.
pub(crate) fn fit(plan: &mut Plan, functions: &Functions, steep_per_mm: f64) {
    let depths = depths_mm(plan);
    let spacings = plan.drawn_fields().map(|field| field.grid.min_spacing_mm());
    let voxel_mm = spacings.fold(f64::INFINITY, f64::min);
    for technique in &mut plan.techniques {
        // The function has no effect then, which is noted.
        if !technique.composite.function().has_place {
            technique.illustrate = Illustrate::Plain;
        }
        fit_to_data(technique, functions, voxel_mm, steep_per_mm);
        fit_to_depths(technique, functions, depths);
    }
}

/// Fits the illustration of `technique` to voxels of this size and to a gradient magnitude that counts as steep.
fn fit_to_data(technique: &mut Technique, functions: &Functions, voxel_mm: f64, steep_per_mm: f64) {
    match &mut technique.illustrate {
        Illustrate::Silhouette { full_per_mm, .. } => {
            give(functions, "full_per_mm", full_per_mm, steep_per_mm);
        }
        Illustrate::ContourLines {
            width_mm, reach_mm, ..
        } => {
            give(functions, "width_mm", width_mm, LINE_VOXELS * voxel_mm);
            give(functions, "reach_mm", reach_mm, REACH_VOXELS * voxel_mm);
        }
        Illustrate::Halo {
            width_mm, reach_mm, ..
        } => {
            give(functions, "width_mm", width_mm, HALO_VOXELS * voxel_mm);
            give(
                functions,
                "reach_mm",
                reach_mm,
                HALO_REACH_VOXELS * voxel_mm,
            );
        }
        Illustrate::DepthCue { .. } | Illustrate::Plain => {}
    }
}

/// Fits it to the depths at which what is drawn begins and ends.
pub(crate) fn fit_to_depths(technique: &mut Technique, functions: &Functions, depths: [f64; 2]) {
    if let Illustrate::DepthCue {
        nearest_mm,
        farthest_mm,
        ..
    } = &mut technique.illustrate
    {
        give(functions, "nearest_mm", nearest_mm, depths[0]);
        give(functions, "farthest_mm", farthest_mm, depths[1]);
    }
}

/// How far in front of the eye the fields that are drawn begin and end, along the direction of view.
pub(crate) fn depths_mm(plan: &Plan) -> [f64; 2] {
    let (eye, forward) = (plan.camera.eye_mm, plan.camera.forward);
    let corners = plan
        .drawn_fields()
        .flat_map(|field| field.grid.corners_mm());
    let depths = corners.map(|corner| (corner - eye).dot(forward));
    let [near, far] = depths.fold([f64::INFINITY, f64::NEG_INFINITY], |[near, far], depth| {
        [near.min(depth), far.max(depth)]
    });
    let near = near.max(0.0);
    [near, far.max(near + 1e-3)]
}
