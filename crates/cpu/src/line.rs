//! The lattice of a packet of rays in the voxel space of one object.

use crate::doubles::{self, F64s};
use crate::lanes::{F32s, I32s, Vec3s, along, each};
use crate::levels::{Level, inlined};
use crate::rays::Rays;
use strahl_volume::Grid;

/// Further than any lattice reaches, as a number of steps.
pub const NEVER: f32 = 1e9;

/// Lattice points that a ray can have: f32 counts them exactly up to here.
pub const MAX_POINTS: f64 = 16_777_216.0;

/// The lattice in the voxel space of one object. Lattice point k lies at
/// `entry_in_voxel + (k + jitter)·step_in_voxel`: positions come from the entry by one product, so
/// that their error does not grow along the ray and is a few ulps of the grid's size, however far
/// away the eye is.
#[derive(Clone, Copy)]
pub struct Line<S: Level> {
    /// Where the lattice begins (t_entry).
    pub entry_in_voxel: Vec3s<S>,
    /// From one lattice point to the next.
    pub step_in_voxel: Vec3s<S>,
    /// One over each component of the step; 0 where it is too short to leave a brick.
    pub inverse_step: Vec3s<S>,
    /// 0, or [`NEVER`] where the step is too short.
    pub stays: Vec3s<S>,
    /// 1 towards larger coordinates, −1 towards smaller ones.
    pub sign: Vec3s<S>,
    /// How far a position may be off by rounding, in voxels, against the direction: 8 times the bound of
    /// the product, the sum and the quotient that it comes from.
    pub margin: Vec3s<S>,
    /// Bit i is set where axis i is walked towards smaller coordinates.
    pub octant: I32s<S>,
    /// The first lattice point inside the object …
    pub first: F32s<S>,
    /// … and the one after the last.
    pub end: F32s<S>,
}

impl<S: Level> Line<S> {
    /// That of no ray.
    pub fn none() -> Line<S> {
        Line {
            entry_in_voxel: [F32s::zero(); 3],
            step_in_voxel: [F32s::zero(); 3],
            inverse_step: [F32s::zero(); 3],
            stays: [F32s::zero(); 3],
            sign: [F32s::zero(); 3],
            margin: [F32s::zero(); 3],
            octant: I32s::splat(0),
            first: F32s::zero(),
            end: F32s::zero(),
        }
    }

    /// The position of lattice coordinate `s` = k + jitter in voxel space.
    #[inline(always)]
    pub fn position(&self, s: F32s<S>) -> Vec3s<S> {
        along(self.entry_in_voxel, self.step_in_voxel, s)
    }

    /// The lattice of rays that begin at `t_entry` (mm) in the voxel space of `grid`.
    #[inline(always)]
    pub fn of_rays(grid: &Grid, rays: &Rays<S>, t_entry: F64s<S>, step_mm: f64) -> Line<S> {
        let voxel_from_world = grid.voxel_from_world();
        let start = doubles::along(rays.origin_mm, rays.direction, t_entry);
        let entry = doubles::moved(&voxel_from_world, start);
        let step_mm = F64s::splat(step_mm);
        let step = each!(doubles::turned(&voxel_from_world, rays.direction), |d| d
            * step_mm,);
        let inverse = inlined(
            #[inline(always)]
            |step: F32s<S>| {
                // A step so short moves less than the margin of skipping in MAX_POINTS steps.
                let moves = F32s::splat(1e-20).lt(step.abs());
                let inverse = F32s::splat(1.0).over(moves.select(step, F32s::splat(1.0)));
                moves.select(inverse, F32s::zero())
            },
        );
        let step_in_voxel = each!(step, |c| F64s::to_single(c));
        let inverse_step = each!(step_in_voxel, |c| inverse(c));
        let zero = F32s::zero();
        let sign = inlined(
            #[inline(always)]
            |inverse: F32s<S>| inverse.lt(zero).select(F32s::splat(-1.0), F32s::splat(1.0)),
        );
        let sign = each!(inverse_step, |c| sign(c));
        let stays = inlined(
            #[inline(always)]
            |inverse: F32s<S>| inverse.eq(zero).select(F32s::splat(NEVER), zero),
        );
        let bit = inlined(
            #[inline(always)]
            |axis: usize| {
                let bit = F32s::splat((1 << axis) as f32);
                inverse_step[axis].lt(zero).select(bit, zero)
            },
        );
        let margin =
            |axis: usize| sign[axis] * F32s::splat(grid.dims()[axis] as f32 / (1 << 20) as f32);
        Line {
            entry_in_voxel: each!(entry, |c| F64s::to_single(c)),
            step_in_voxel,
            inverse_step,
            stays: each!(inverse_step, |c| stays(c)),
            sign,
            margin: [margin(0), margin(1), margin(2)],
            octant: (bit(0) + bit(1) + bit(2)).to_i32s(),
            first: F32s::zero(),
            end: F32s::zero(),
        }
    }
}

/// How many lattice points, that at `position` included, lie in a block with this middle, and `reach` from
/// there to its face.
#[inline(always)]
pub fn points_to_face<S: Level>(
    line: &Line<S>,
    position: Vec3s<S>,
    middle: Vec3s<S>,
    reach: F32s<S>,
) -> F32s<S> {
    let mut points = F32s::splat(NEVER);
    for axis in 0..3 {
        let face = middle[axis] + reach * line.sign[axis] - line.margin[axis];
        let steps = (face - position[axis]) * line.inverse_step[axis] + line.stays[axis];
        points = points.min(steps);
    }
    points.max(F32s::zero()).to_i32s().to_f32s() + F32s::splat(1.0)
}
