//! Ray set-up: from pixels to a packet of lattices in voxel space.

use crate::lanes::{F32s, LANES, PACKET, Vec3s, along};
use crate::library::clip_ray;
use crate::scenery::Scenery;
use glam::DVec3;
use strahl_scene::plan::{MOST_OBJECTS, Plan, Ray};
use strahl_volume::Grid;

/// Lattice points that a ray can have: f32 counts them exactly up to here.
pub const MAX_POINTS: f64 = 16_777_216.0;

/// The lattices of a packet of rays, and where each object lies along them.
#[derive(Clone, Debug)]
pub struct RayPacket {
    /// One per object of the Plan.
    pub lines: Vec<Line>,
    /// World space, unit length.
    pub direction: Vec3s,
    /// Where the lattice begins, in mm from the ray's start.
    pub entry_mm: [f64; LANES],
    /// In [0, 1).
    pub jitter: F32s,
    /// Number of lattice points: whole, 0 for a ray that misses and a lane without a pixel.
    pub count: F32s,
    /// Lanes that have a pixel.
    pub pixels: [bool; LANES],
    /// What is behind: opaque geometry, or the background. Premultiplied.
    pub behind: [[f32; 4]; LANES],
    /// How far away the opaque geometry is, in mm; infinite without.
    pub opaque_mm: [f64; LANES],
}

/// The lattice in the voxel space of one object. Lattice point k lies at
/// `entry_in_voxel + (k + jitter)·step_in_voxel`: positions come from the entry by one product, so
/// that their error does not grow along the ray and is a few ulps of the grid's size, however far
/// away the eye is.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Where the lattice begins (t_entry).
    pub entry_in_voxel: Vec3s,
    /// From one lattice point to the next.
    pub step_in_voxel: Vec3s,
    /// One over each component of the step; 0 where it is too short to leave a brick.
    pub inverse_step: Vec3s,
    /// The first lattice point inside the object …
    pub first: F32s,
    /// … and the one after the last.
    pub end: F32s,
}

impl Line {
    const NONE: Line = Line {
        entry_in_voxel: [F32s::ZERO; 3],
        step_in_voxel: [F32s::ZERO; 3],
        inverse_step: [F32s::ZERO; 3],
        first: F32s::ZERO,
        end: F32s::ZERO,
    };

    /// The position of lattice coordinate `s` = k + jitter in voxel space.
    #[inline(always)]
    pub fn position(&self, s: F32s) -> Vec3s {
        along(self.entry_in_voxel, self.step_in_voxel, s)
    }

    fn set(&mut self, lane: usize, grid: &Grid, ray: &Ray, t_entry: f64, step_mm: f64) {
        let voxel_from_world = grid.voxel_from_world();
        let entry = voxel_from_world.transform_point3(ray.origin_mm + t_entry * ray.direction);
        let step = voxel_from_world.transform_vector3(ray.direction) * step_mm;
        for axis in 0..3 {
            self.entry_in_voxel[axis].0[lane] = entry[axis] as f32;
            self.step_in_voxel[axis].0[lane] = step[axis] as f32;
            // A step so short moves less than the margin of skipping in MAX_POINTS steps.
            let moves = step[axis].abs() > 1e-20;
            self.inverse_step[axis].0[lane] = if moves {
                step[axis].recip() as f32
            } else {
                0.0
            };
        }
    }
}

impl RayPacket {
    /// A packet without rays for `objects` objects.
    pub fn empty(objects: usize) -> RayPacket {
        RayPacket {
            lines: vec![Line::NONE; objects],
            direction: [F32s::ZERO; 3],
            entry_mm: [0.0; LANES],
            jitter: F32s::ZERO,
            count: F32s::ZERO,
            pixels: [false; LANES],
            behind: [[0.0; 4]; LANES],
            opaque_mm: [f64::INFINITY; LANES],
        }
    }

    /// Becomes the rays of the block of pixels with its corner at column `x0`, row `y0`, as far as it
    /// lies left of column `x_end` and above row `y_end`, in picture number `frame`.
    pub fn aim(
        &mut self,
        scenery: &Scenery,
        [x0, y0]: [u32; 2],
        [x_end, y_end]: [u32; 2],
        frame: u32,
    ) {
        self.pixels = [false; LANES];
        self.count = F32s::ZERO;
        self.jitter = F32s::ZERO;
        self.lines.fill(Line::NONE);
        for lane in 0..LANES {
            let x = x0 + (lane % PACKET[0]) as u32;
            let y = y0 + (lane / PACKET[0]) as u32;
            if x < x_end && y < y_end {
                self.pixels[lane] = true;
                self.set(lane, scenery, x, y, frame);
            }
        }
    }

    fn set(&mut self, lane: usize, scenery: &Scenery, x: u32, y: u32, frame: u32) {
        let plan = scenery.plan;
        let ray = plan.camera.ray(x, y, plan.width, plan.height);
        let (opaque_mm, behind) = scenery.meshes.behind(&ray, plan);
        self.opaque_mm[lane] = opaque_mm;
        self.behind[lane] = behind;
        for axis in 0..3 {
            self.direction[axis].0[lane] = ray.direction[axis] as f32;
        }
        let mut intervals = [None; MOST_OBJECTS];
        let (mut t_entry, mut t_exit) = (f64::INFINITY, f64::NEG_INFINITY);
        for (object, interval) in intervals[..plan.objects.len()].iter_mut().enumerate() {
            *interval = clip_ray::interval(plan, object, &ray, opaque_mm);
            if let Some([first, last]) = *interval {
                t_entry = t_entry.min(first);
                t_exit = t_exit.max(last);
            }
        }
        if t_entry >= t_exit {
            return;
        }
        let step_mm = plan.lattice.step_mm;
        let jitter = scenery.jitters.at(x, y, frame);
        // The number of lattice points before t.
        let points = |t: f64| {
            let count = ((t - t_entry) / step_mm - f64::from(jitter)).ceil();
            count.clamp(0.0, MAX_POINTS) as f32
        };
        for (object, line) in self.lines.iter_mut().enumerate() {
            if let Some([first, last]) = intervals[object] {
                line.set(lane, &plan.objects[object].grid, &ray, t_entry, step_mm);
                line.first.0[lane] = points(first);
                line.end.0[lane] = points(last);
            }
        }
        self.entry_mm[lane] = t_entry;
        self.jitter.0[lane] = jitter;
        self.count.0[lane] = points(t_exit);
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
