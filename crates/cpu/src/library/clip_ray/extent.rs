use strahl_scene::plan::Ray;
use strahl_volume::Grid;

/// Cuts to the sampled extent: the slab test in voxel space, so that oblique and sheared grids need
/// nothing more.
pub fn clip(grid: &Grid, ray: &Ray, [mut t0, mut t1]: [f64; 2]) -> [f64; 2] {
    let origin = grid.voxel_from_world().transform_point3(ray.origin_mm);
    let direction = grid.voxel_from_world().transform_vector3(ray.direction);
    let (lo, hi) = grid.extent_in_voxels();
    for axis in 0..3 {
        let (o, d) = (origin[axis], direction[axis]);
        if d == 0.0 {
            // 0/0 has no sign: a parallel ray is inside or outside all along.
            if o < lo[axis] || o > hi[axis] {
                t1 = f64::NEG_INFINITY;
            }
            continue;
        }
        let (a, b) = ((lo[axis] - o) / d, (hi[axis] - o) / d);
        t0 = t0.max(a.min(b));
        t1 = t1.min(a.max(b));
    }
    [t0, t1]
}
