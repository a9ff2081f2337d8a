//! Slot clip_ray: which part of a ray is seen.

mod depth;
mod extent;
mod plane;

use strahl_scene::plan::{Plan, Ray};

/// Where the ray enters and leaves what is drawn of object number `object` in front of opaque
/// geometry at `opaque_mm`, in mm from its origin; `None` if it misses.
///
/// In double precision: this lays the lattice, and happens once per ray.
pub fn interval(plan: &Plan, object: usize, ray: &Ray, opaque_mm: f64) -> Option<[f64; 2]> {
    let grid = &plan.objects[object].grid;
    let mut interval = extent::clip(grid, ray, [0.0, f64::INFINITY]);
    for clip in &plan.ray_clips {
        if clip.objects >> object & 1 == 1 {
            interval = plane::clip(clip, ray, interval);
        }
    }
    interval = depth::clip(opaque_mm, interval);
    (interval[0] < interval[1]).then_some(interval)
}
