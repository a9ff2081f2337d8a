use crate::doubles::{F64s, moved, turned};
use crate::levels::Level;
use crate::rays::Rays;
use strahl_volume::Grid;

/// Cuts to the sampled extent: the slab test in voxel space, so that oblique and sheared grids need
/// nothing more.
#[inline(always)]
pub fn clip<S: Level>(grid: &Grid, rays: &Rays<S>, [mut t0, mut t1]: [F64s<S>; 2]) -> [F64s<S>; 2] {
    let voxel_from_world = grid.voxel_from_world();
    let origin = moved(&voxel_from_world, rays.origin_mm);
    let direction = turned(&voxel_from_world, rays.direction);
    let (lo, hi) = grid.extent_in_voxels();
    let far = F64s::splat(f64::INFINITY);
    for axis in 0..3 {
        let (o, d) = (origin[axis], direction[axis]);
        let (lo, hi) = (F64s::splat(lo[axis]), F64s::splat(hi[axis]));
        // Less moves no point of a ray, and has no inverse.
        let moves = F64s::splat(1e-300).lt(d.abs());
        let inverse = F64s::splat(1.0).over(moves.select(d, F64s::splat(1.0)));
        let (a, b) = ((lo - o) * inverse, (hi - o) * inverse);
        // A parallel ray is inside or outside all along.
        let outside = o.lt(lo) | hi.lt(o);
        let parallel = outside.select(-far, far);
        t0 = t0.max(moves.select(a.min(b), -far));
        t1 = t1.min(moves.select(a.max(b), parallel));
    }
    [t0, t1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doubles::splat;
    use crate::levels::Portable;
    use glam::DVec3;

    #[test]
    fn rays_that_hardly_move_along_an_axis_are_parallel_to_it() {
        let grid = Grid::centered([4, 4, 4], DVec3::ONE).unwrap();
        let all = [F64s::<Portable>::splat(0.0), F64s::splat(f64::INFINITY)];
        for across in [0.0, 1e-310, -1e-310, 1e-290] {
            let met = |y: f64| {
                let rays = Rays {
                    origin_mm: splat(DVec3::new(-5.0, y, 0.0)),
                    direction: splat(DVec3::new(1.0, across, 0.0)),
                };
                clip(&grid, &rays, all).map(|t| t.lane(0))
            };
            assert_eq!(met(0.5), [3.0, 7.0], "{across}");
            let [first, last] = met(2.5);
            assert!(first >= last, "{across}: {first} to {last}");
            let on_the_face = met(2.0);
            assert!(!on_the_face.iter().any(|t| t.is_nan()), "{across}");
        }
    }
}
