use crate::doubles::{F64s, dot, splat};
use crate::levels::Level;
use crate::rays::Rays;
use strahl_scene::plan::ClipPlane;

/// Cuts to the half-space normal·p + offset ≥ 0.
#[inline(always)]
pub fn clip<S: Level>(plane: &ClipPlane, rays: &Rays<S>, [t0, t1]: [F64s<S>; 2]) -> [F64s<S>; 2] {
    let normal = splat(plane.normal);
    let (zero, far) = (F64s::splat(0.0), F64s::splat(f64::INFINITY));
    let height = dot(normal, rays.origin_mm) + F64s::splat(plane.offset_mm);
    let slope = dot(normal, rays.direction);
    let (rises, falls) = (zero.lt(slope), slope.lt(zero));
    let t = (-height).over((rises | falls).select(slope, F64s::splat(1.0)));
    // A parallel ray is on one side all along.
    let parallel = height.lt(zero).select(-far, far);
    [
        t0.max(rises.select(t, -far)),
        t1.min(falls.select(t, rises.select(far, parallel))),
    ]
}
