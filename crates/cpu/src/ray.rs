//! Ray set-up: from pixels to a packet of lattices in voxel space.

use crate::doubles::{self, F64s, Mask64, Points};
use crate::lanes::{F32s, I32s, LANES, PACKET, Vec3s, along, each, lanes};
use crate::levels::{Level, inlined};
use crate::library::clip_ray;
use crate::library::jitter::Jitters;
use crate::scenery::Scenery;
use crate::tiles::Raster;
use glam::DVec3;
use strahl_scene::plan::{Plan, Projection, Ray, Sampling};
use strahl_volume::Grid;

/// Further than any lattice reaches, as a number of steps.
pub const NEVER: f32 = 1e9;

/// Lattice points that a ray can have: f32 counts them exactly up to here.
pub const MAX_POINTS: f64 = 16_777_216.0;

/// The lattices of a packet of rays, and where each object lies along them.
#[derive(Clone)]
pub struct RayPacket<S: Level> {
    /// One per object of the Plan.
    pub lines: Vec<Line<S>>,
    /// Where each object begins and ends, in mm from the ray's start.
    intervals: Vec<[F64s<S>; 2]>,
    /// World space, unit length.
    pub direction: Vec3s<S>,
    /// Where the lattice begins, in mm from the ray's start.
    pub entry_mm: F64s<S>,
    /// In [0, 1).
    pub jitter: F32s<S>,
    /// Number of lattice points: whole, 0 for a ray that misses and a lane without a pixel.
    pub count: F32s<S>,
    /// Between the last lattice point and where the ray leaves: where steps have parts, how many of them lie there;
    /// where they are integrated, the share of a step, from the point before the ray if there is none on it. 0 elsewhere.
    pub tail: F32s<S>,
    /// Lanes that have a pixel.
    pub pixels: [bool; LANES],
    /// What is behind: opaque geometry, or the background. Premultiplied.
    pub behind: [F32s<S>; 4],
    /// How far away the opaque geometry is, in mm; infinite without.
    pub opaque_mm: [f64; LANES],
}

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
    fn none() -> Line<S> {
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
    fn of_rays(grid: &Grid, rays: &Rays<S>, t_entry: F64s<S>, step_mm: f64) -> Line<S> {
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

/// Rays in world space; points are `origin_mm + t · direction`, t ≥ 0 in mm.
pub struct Rays<S: Level> {
    /// t = 0.
    pub origin_mm: Points<S>,
    /// Unit length.
    pub direction: Points<S>,
}

impl<S: Level> Rays<S> {
    /// The rays through the centres of the pixels in these columns and rows, with the arithmetic of
    /// [`PlanCamera::ray`].
    ///
    /// [`PlanCamera::ray`]: strahl_scene::plan::PlanCamera::ray
    #[inline(always)]
    fn of_camera(plan: &Plan, columns: [u32; PACKET[0]], rows: [u32; PACKET[1]]) -> Rays<S> {
        let camera = &plan.camera;
        let (width, height) = (f64::from(plan.width), f64::from(plan.height));
        let aspect = width / height;
        let (mut across, mut upward) = ([0.0; PACKET[0]], [0.0; PACKET[1]]);
        for (across, x) in across.iter_mut().zip(columns) {
            *across = (2.0 * (f64::from(x) + 0.5) / width - 1.0) * aspect;
        }
        for (upward, y) in upward.iter_mut().zip(rows) {
            *upward = 1.0 - 2.0 * (f64::from(y) + 0.5) / height;
        }
        let across = F64s::from_array(lanes(|lane| across[lane % PACKET[0]]));
        let upward = F64s::from_array(lanes(|lane| upward[lane / PACKET[0]]));
        let one = F64s::splat(1.0);
        let (right, up) = (doubles::splat(camera.right), doubles::splat(camera.up));
        let forward = doubles::splat(camera.forward);
        let offset = inlined(
            #[inline(always)]
            |axis: usize| right[axis] * across + up[axis] * upward,
        );
        let offset = [offset(0), offset(1), offset(2)];
        let eye = doubles::splat(camera.eye_mm);
        match camera.projection {
            Projection::Perspective { tan_half_height } => {
                let long = doubles::along(forward, offset, F64s::splat(tan_half_height));
                let shorter = one.over(doubles::dot(long, long).sqrt());
                Rays {
                    origin_mm: eye,
                    direction: each!(long, |d| d * shorter),
                }
            }
            Projection::Orthographic { half_height_mm } => Rays {
                origin_mm: doubles::along(eye, offset, F64s::splat(half_height_mm)),
                direction: forward,
            },
        }
    }

    fn ray(&self, lane: usize) -> Ray {
        let vector = |v: &Points<S>| DVec3::new(v[0].lane(lane), v[1].lane(lane), v[2].lane(lane));
        Ray {
            origin_mm: vector(&self.origin_mm),
            direction: vector(&self.direction),
        }
    }
}

impl<S: Level> RayPacket<S> {
    /// A packet without rays for `objects` objects.
    pub fn empty(objects: usize) -> RayPacket<S> {
        RayPacket {
            lines: vec![Line::none(); objects],
            intervals: vec![[F64s::splat(0.0); 2]; objects],
            direction: [F32s::zero(); 3],
            entry_mm: F64s::splat(0.0),
            jitter: F32s::zero(),
            count: F32s::zero(),
            tail: F32s::zero(),
            pixels: [false; LANES],
            behind: [F32s::zero(); 4],
            opaque_mm: [f64::INFINITY; LANES],
        }
    }

    /// Becomes the rays of the block of pixels with its corner at column `x0`, row `y0` of `raster`, as far as
    /// it lies left of column `x_end` and above row `y_end` of it, in picture number `frame`.
    #[inline(always)]
    pub fn aim(
        &mut self,
        scenery: &Scenery<S>,
        raster: Raster,
        [x0, y0]: [u32; 2],
        [x_end, y_end]: [u32; 2],
        frame: u32,
    ) {
        let plan = scenery.plan;
        let Raster { first, stride } = raster;
        let (mut columns, mut rows) = ([0; PACKET[0]], [0; PACKET[1]]);
        for (x, column) in (x0..).zip(&mut columns) {
            *column = first[0] + x * stride[0];
        }
        for (y, row) in (y0..).zip(&mut rows) {
            *row = first[1] + y * stride[1];
        }
        self.pixels = lanes(|lane| {
            let (x, y) = (lane % PACKET[0], lane / PACKET[0]);
            x0 + (x as u32) < x_end && y0 + (y as u32) < y_end
        });
        let rays = Rays::of_camera(plan, columns, rows);
        self.direction = each!(rays.direction, |c| F64s::to_single(c));
        if plan.meshes.is_empty() {
            self.opaque_mm = [f64::INFINITY; LANES];
            let [r, g, b, a] = plan.background;
            self.behind = [
                F32s::splat(r),
                F32s::splat(g),
                F32s::splat(b),
                F32s::splat(a),
            ];
        } else {
            let mut behind = [[0.0; LANES]; 4];
            for lane in (0..LANES).filter(|&lane| self.pixels[lane]) {
                let colour;
                (self.opaque_mm[lane], colour) = scenery.meshes.behind(&rays.ray(lane), plan);
                for (channel, number) in behind.iter_mut().zip(colour) {
                    channel[lane] = number;
                }
            }
            let [r, g, b, a] = behind;
            self.behind = [
                F32s::from_array(r),
                F32s::from_array(g),
                F32s::from_array(b),
                F32s::from_array(a),
            ];
        }
        self.jitter = match scenery.jitters {
            Jitters::Centre => F32s::splat(0.5),
            _ => F32s::from_array(lanes(|lane| {
                let (x, y) = (lane % PACKET[0], lane / PACKET[0]);
                scenery.jitters.at(columns[x], rows[y], frame)
            })),
        };
        let opaque_mm = F64s::from_array(self.opaque_mm);
        let (zero, far) = (F64s::splat(0.0), F64s::splat(f64::INFINITY));
        let (mut t_entry, mut t_exit) = (far, -far);
        for (object, interval) in self.intervals.iter_mut().enumerate() {
            *interval = clip_ray::interval(plan, object, &rays, opaque_mm);
            let [first, last] = *interval;
            let met = first.lt(last);
            t_entry = t_entry.min(met.select(first, far));
            t_exit = t_exit.max(met.select(last, -far));
        }
        let met = t_entry.lt(t_exit) & Mask64::from_array(self.pixels);
        if !met.any() {
            (self.count, self.tail) = (F32s::zero(), F32s::zero());
            return;
        }
        let t_entry = met.select(t_entry, zero);
        let step_mm = F64s::splat(plan.lattice.step_mm);
        let jitter = F64s::from_single(self.jitter);
        // The number of lattice points before t.
        let points = inlined(
            #[inline(always)]
            |met: Mask64<S>, t: F64s<S>| {
                let count = ((t - t_entry).over(step_mm) - jitter).ceil();
                let count = count.max(zero).min(F64s::splat(MAX_POINTS));
                met.select(count, zero).to_single()
            },
        );
        self.entry_mm = t_entry;
        self.count = points(met, t_exit);
        // One alone begins and ends with the rays.
        let is_alone = plan.objects.len() == 1;
        for (object, line) in self.lines.iter_mut().enumerate() {
            let grid = &plan.objects[object].grid;
            *line = Line::of_rays(grid, &rays, t_entry, plan.lattice.step_mm);
            line.end = self.count;
            if !is_alone {
                let [first, last] = self.intervals[object];
                let met = met & first.lt(last);
                line.first = points(met, first);
                line.end = points(met, last);
            }
        }
        let parts = plan.sampling.parts();
        if parts > 1 {
            let (one, parts) = (F64s::splat(1.0), F64s::splat(f64::from(parts)));
            let last = F64s::from_single(self.count) - one + jitter;
            let beyond = (t_exit - t_entry).over(step_mm) - last;
            let tail = (beyond * parts).ceil() - one;
            let tail = tail.max(zero).min(parts - one);
            self.tail = met.select(tail, zero).to_single();
        } else if plan.sampling == Sampling::Integrated {
            let one = F64s::splat(1.0);
            let last = F64s::from_single(self.count) - one + jitter;
            let tail = (t_exit - t_entry).over(step_mm) - last;
            self.tail = met.select(tail.max(zero).min(one), zero).to_single();
        }
    }
}

/// The largest number of lattice points that a ray of `plan` may have.
pub fn most_points(plan: &Plan) -> f64 {
    // No ray is longer inside than the diagonal of the volume, or of the box around several.
    let corners = |grid: &Grid| grid.corners_mm();
    let diagonal = if let [object] = &plan.objects[..] {
        let corners = corners(&object.grid);
        (0..4)
            .map(|i| corners[i].distance(corners[7 - i]))
            .fold(0.0, f64::max)
    } else {
        let all = plan.objects.iter().flat_map(|object| corners(&object.grid));
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (lo, hi) = all.fold(start, |(lo, hi), c| (lo.min(c), hi.max(c)));
        lo.distance(hi)
    };
    diagonal / plan.lattice.step_mm
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::levels::Portable;
    use strahl_scene::{Scene, resolve};
    use strahl_volume::Phantom;

    #[test]
    fn rays_are_those_of_the_camera() {
        let volume = Phantom::Tree.volume([8, 8, 8]).unwrap();
        for projection in ["perspective", "orthographic"] {
            let scene = format!(
                r#"{{ "size": [37, 23], "camera": {{ "projection": "{projection}", "azimuth_deg": 31 }} }}"#
            );
            let scene = Scene::parse("scene", &scene).unwrap();
            let plan = resolve(&scene, &volume.header(), None).unwrap();
            let columns = std::array::from_fn(|i| 8 + i as u32);
            let rows = std::array::from_fn(|i| 4 + i as u32);
            let rays = Rays::<Portable>::of_camera(&plan, columns, rows);
            for lane in 0..LANES {
                let (x, y) = (8 + lane % PACKET[0], 4 + lane / PACKET[0]);
                let ray = plan.camera.ray(x as u32, y as u32, plan.width, plan.height);
                assert_eq!(rays.ray(lane), ray, "{projection}, lane {lane}");
            }
        }
    }
}
