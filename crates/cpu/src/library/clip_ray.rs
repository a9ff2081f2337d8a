//! Slot clip_ray: which part of a ray is seen.

mod depth;
mod extent;
mod plane;

use crate::doubles::F64s;
use crate::levels::Level;
use crate::rays::Rays;
use strahl_scene::plan::Plan;

/// Where the rays enter and leave what is drawn of object number `object` in front of opaque
/// geometry at `opaque_mm`, in mm from their origins; a ray that leaves before it enters misses.
///
/// In double precision: this lays the lattice, and happens once per ray.
#[inline(always)]
pub fn interval<S: Level>(
    plan: &Plan,
    object: usize,
    rays: &Rays<S>,
    opaque_mm: F64s<S>,
) -> [F64s<S>; 2] {
    let grid = &plan.field_of(object).grid;
    let ahead = [F64s::splat(0.0), F64s::splat(f64::INFINITY)];
    let mut interval = extent::clip(grid, rays, ahead);
    for clip in &plan.ray_clips {
        if clip.layers >> object & 1 == 1 {
            interval = plane::clip(clip, rays, interval);
        }
    }
    depth::clip(opaque_mm, interval)
}
