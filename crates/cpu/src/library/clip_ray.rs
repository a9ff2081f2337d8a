//! Slot clip_ray: which part of a ray is seen.

mod extent;
mod plane;

use strahl_scene::plan::{Plan, Ray};

/// Where the ray enters and leaves what is drawn, in mm from its origin; `None` if it misses.
///
/// In double precision: this lays the lattice, and happens once per ray.
pub fn interval(plan: &Plan, ray: &Ray) -> Option<[f64; 2]> {
    let mut interval = extent::clip(&plan.volume.grid, ray, [0.0, f64::INFINITY]);
    for clip in &plan.ray_clips {
        interval = plane::clip(clip, ray, interval);
    }
    (interval[0] < interval[1]).then_some(interval)
}
