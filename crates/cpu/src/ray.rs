//! Ray set-up: from pixels to a packet of lattices in voxel space.

use crate::lanes::{F32s, LANES, PACKET, Vec3s, along};
use crate::library::{clip_ray, jitter};
use strahl_scene::plan::Plan;

/// Lattice points that a ray can have: f32 counts them exactly up to here.
pub const MAX_POINTS: f64 = 16_777_216.0;

/// The lattices of a packet of rays. Lattice point k lies in voxel space at
/// `entry_in_voxel + (k + jitter)·step_in_voxel`: positions come from the entry by one product, so
/// that their error does not grow along the ray and is a few ulps of the grid's size, however far
/// away the eye is.
#[derive(Clone, Copy, Debug)]
pub struct RayPacket {
    /// Where the ray enters (t_entry).
    pub entry_in_voxel: Vec3s,
    /// From one lattice point to the next.
    pub step_in_voxel: Vec3s,
    /// One over each component of the step; 0 where it is too short to leave a brick.
    pub inverse_step: Vec3s,
    /// World space, unit length.
    pub direction: Vec3s,
    /// In [0, 1).
    pub jitter: F32s,
    /// Number of lattice points: whole, 0 for a ray that misses and a lane without a pixel.
    pub count: F32s,
    /// Lanes that have a pixel.
    pub pixels: [bool; LANES],
}

impl RayPacket {
    /// The position of lattice coordinate `s` = k + jitter in voxel space.
    #[inline(always)]
    pub fn position(&self, s: F32s) -> Vec3s {
        along(self.entry_in_voxel, self.step_in_voxel, s)
    }

    /// The rays of the block of pixels with its corner at column `x0`, row `y0`, as far as it lies
    /// left of column `x_end` and above row `y_end`.
    pub fn new(plan: &Plan, x0: u32, y0: u32, x_end: u32, y_end: u32) -> RayPacket {
        let mut packet = RayPacket {
            entry_in_voxel: [F32s::ZERO; 3],
            step_in_voxel: [F32s::ZERO; 3],
            inverse_step: [F32s::ZERO; 3],
            direction: [F32s::ZERO; 3],
            jitter: F32s::ZERO,
            count: F32s::ZERO,
            pixels: [false; LANES],
        };
        for lane in 0..LANES {
            let x = x0 + (lane % PACKET[0]) as u32;
            let y = y0 + (lane / PACKET[0]) as u32;
            if x < x_end && y < y_end {
                packet.pixels[lane] = true;
                packet.set(lane, plan, x, y);
            }
        }
        packet
    }

    fn set(&mut self, lane: usize, plan: &Plan, x: u32, y: u32) {
        let ray = plan.camera.ray(x, y, plan.width, plan.height);
        let Some([t_entry, t_exit]) = clip_ray::interval(plan, &ray) else {
            return;
        };
        let jitter = jitter::of(plan.lattice.jitter, x, y);
        let step_mm = plan.lattice.step_mm;
        let count = ((t_exit - t_entry) / step_mm - f64::from(jitter)).ceil();
        if count <= 0.0 {
            return;
        }
        let voxel_from_world = plan.volume.grid.voxel_from_world();
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
            self.direction[axis].0[lane] = ray.direction[axis] as f32;
        }
        self.jitter.0[lane] = jitter;
        self.count.0[lane] = count.min(MAX_POINTS) as f32;
    }
}

/// The largest number of lattice points that a ray of `plan` may have.
pub fn most_points(plan: &Plan) -> f64 {
    // No ray is longer inside the volume than its longest diagonal.
    let corners = plan.volume.grid.corners_mm();
    let diagonal = (0..4)
        .map(|i| corners[i].distance(corners[7 - i]))
        .fold(0.0, f64::max);
    diagonal / plan.lattice.step_mm
}
