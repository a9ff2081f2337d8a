//! What the host computes: where rays start, how they step, how long they are; tiles (document §6.3, 7.6.2).

use crate::Error;
use crate::fixed_point::from_f64;
use crate::spec::{Projection, Spec};
use crate::stages::address::AddressGenerator;
use crate::stages::shade::ViewAxes;
use glam::DVec3;

/// Pixels of a picture: more than any volume that fits the words can fill.
const MOST_PIXELS: u64 = 1 << 26;

/// A ray in the parameter RAM.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ray {
    /// Position of the next sample.
    pub position: [i32; 3],
    /// From one sample to the next.
    pub step: [i32; 3],
    /// Samples left.
    pub remaining: u32,
    /// Steps from the image plane to the next sample.
    pub plane: u32,
    /// Where its result goes: index of the picture, rows from the bottom.
    pub pixel: u32,
}

/// The geometry of a picture: everything about rays that does not depend on voxels.
#[derive(Clone, Debug)]
pub struct RaySetup {
    /// Pixels per row and rows.
    pub size: [u32; 2],
    /// Tiles per row and rows of tiles.
    pub tiles: [u32; 2],
    /// The axes of the view in voxels.
    pub axes: ViewAxes,
    /// Bound of the components of every step of every ray, in voxels: what leaping may rely on.
    pub largest_step: f64,
    bundle: [u32; 2],
    dims: [usize; 3],
    position: [u32; 2],
    step_fraction: u32,
    length: u32,
    step: f64,
    pixel: f64,
    /// Centre of the picture on the image plane, which touches the nearest corner of the volume.
    centre: DVec3,
    /// Distance of the eye from the image plane in voxels; none for parallel rays.
    eye_distance: Option<f64>,
    /// Planes that are sampled, from the first to the one behind the last.
    planes: [u32; 2],
    /// Planes from the image plane to the farthest corner of everything that is drawn.
    plane_count: u32,
    /// Which cells of an axis are sampled, from the first to the one behind the last; none for all.
    cut: Option<(usize, [i32; 2])>,
    /// Which pixels still have a ray (rows from the bottom); none for all.
    alive: Option<Vec<bool>>,
    /// The rays, if they are not computed here.
    given: Option<Vec<Option<Ray>>>,
}

impl RaySetup {
    /// The rays of `spec.view` for a volume of `dims` voxels.
    ///
    /// # Errors
    /// If positions, steps, lengths or keys do not fit their words: which field, and what would fit.
    pub fn new(spec: &Spec, dims: [usize; 3]) -> Result<RaySetup, Error> {
        let view = &spec.view;
        let widths = &spec.widths;
        if let Some(n) = dims.iter().find(|n| **n > 1 << widths.position_integer) {
            return Err(Error::field(
                "widths.position_integer",
                widths.position_integer,
                format!(
                    "the volume has {n} voxels along an axis; at least {} bits are needed",
                    (n - 1).ilog2() + 1
                ),
            ));
        }
        let coarse = if view.is_moving { 2.0 } else { 1.0 };
        let step = view.step * coarse;
        let (sin_z, cos_z) = sin_cos_deg(view.rotate_z_deg);
        let (sin_x, cos_x) = sin_cos_deg(view.rotate_x_deg);
        let right = DVec3::new(cos_z, -sin_z, 0.0);
        let level = DVec3::new(sin_z, cos_z, 0.0);
        let forward = level * cos_x - DVec3::Z * sin_x;
        let up = DVec3::Z * cos_x + level * sin_x;
        let axes = ViewAxes { right, forward, up };

        // The hull of the voxel centres, seen from the view.
        let half = DVec3::from_array(dims.map(|n| 0.5 * (n as f64 - 1.0)));
        let reach = |axis: DVec3| axis.abs().dot(half);
        let front = -reach(forward);
        let width = 2.0 * reach(right) + 1.0;
        let height = 2.0 * reach(up) + 1.0;
        let (pixel, eye_distance) = match view.projection {
            Projection::Parallel => (view.pixel * coarse, None),
            Projection::Perspective { angle_deg } => {
                let tangent = (0.5 * angle_deg).to_radians().tan();
                let start = 1.0 / (2.0 * tangent + 1.0);
                (start * coarse, Some(0.5 * width.max(height) / tangent))
            }
        };
        // Rounding may not add a pixel: 128 rays for 128 voxels.
        let pixels = |length: f64| (length / pixel - 1e-9).ceil().clamp(1.0, 65535.0) as u32;
        let size = [pixels(width), pixels(height)];
        if u64::from(size[0]) * u64::from(size[1]) > MOST_PIXELS {
            return Err(Error::field(
                "view.pixel",
                view.pixel,
                format!(
                    "the picture would have {} × {} pixels; at most {MOST_PIXELS}",
                    size[0], size[1]
                ),
            ));
        }
        let bundle = spec.queue.bundle;
        let mut setup = RaySetup {
            size,
            tiles: [size[0].div_ceil(bundle[0]), size[1].div_ceil(bundle[1])],
            axes,
            largest_step: 0.0,
            bundle,
            dims,
            position: [widths.position_integer, widths.position_fraction],
            step_fraction: widths.step_fraction,
            length: widths.length,
            step,
            pixel,
            centre: half + forward * front,
            eye_distance,
            planes: [0, u32::MAX],
            plane_count: (2.0 * reach(forward) / step).floor() as u32 + 1,
            cut: None,
            alive: None,
            given: None,
        };
        // Components are linear in the place on the picture, so the corners are the extremes.
        for corner in 0..4 {
            let x = (corner & 1) * (size[0] - 1);
            let y = (corner >> 1) * (size[1] - 1);
            let delta = setup.direction(x, y) * step;
            if delta
                .to_array()
                .iter()
                .any(|c| from_f64(*c, widths.step_integer, widths.step_fraction).is_none())
            {
                return Err(Error::field(
                    "widths.step_integer",
                    widths.step_integer,
                    format!(
                        "a step of {:.3} voxels does not fit",
                        delta.abs().max_element()
                    ),
                ));
            }
            let rounding = 1.0 / f64::from(1u32 << widths.step_fraction);
            setup.largest_step = setup.largest_step.max(delta.abs().max_element() + rounding);
        }
        if setup.eye_distance.is_none() {
            // All steps are the same: the bound is what is stored.
            let delta = setup.fixed_step(forward * step);
            let most = delta.iter().map(|c| c.unsigned_abs()).max().unwrap_or(0);
            setup.largest_step = f64::from(most) / f64::from(1u32 << widths.position_fraction);
        }
        let most_steps = setup.plane_count;
        for (field, bits) in [("widths.length", widths.length), ("widths.key", widths.key)] {
            let largest = (1u32 << bits) - 1;
            // Lengths are bounded by the longest ray, keys by the depth of the picture.
            if most_steps > largest {
                let longest = setup.longest_ray();
                let needed = if field == "widths.length" {
                    longest
                } else {
                    most_steps
                };
                if needed > largest {
                    return Err(Error::field(
                        field,
                        bits,
                        format!(
                            "it holds at most {largest}, but this volume and view need {needed}: at least {} bits",
                            needed.ilog2() + 1
                        ),
                    ));
                }
            }
        }
        Ok(setup)
    }

    /// One tile of given rays, row after row; those that are none are not sent.
    pub(crate) fn of_rays(spec: &Spec, dims: [usize; 3], rays: Vec<Option<Ray>>) -> RaySetup {
        let bundle = spec.queue.bundle;
        let behind = rays.iter().flatten().map(|r| r.plane + r.remaining).max();
        let axes = ViewAxes {
            right: DVec3::X,
            forward: DVec3::Y,
            up: DVec3::Z,
        };
        RaySetup {
            size: bundle,
            tiles: [1, 1],
            axes,
            largest_step: 0.0,
            bundle,
            dims,
            position: [spec.widths.position_integer, spec.widths.position_fraction],
            step_fraction: spec.widths.step_fraction,
            length: spec.widths.length,
            step: 1.0,
            pixel: 1.0,
            centre: DVec3::ZERO,
            eye_distance: None,
            planes: [0, u32::MAX],
            plane_count: behind.unwrap_or(1),
            cut: None,
            alive: None,
            given: Some(rays),
        }
    }

    /// Number of tiles.
    pub fn tile_count(&self) -> usize {
        self.tiles[0] as usize * self.tiles[1] as usize
    }

    /// The part of the picture between two planes, with rays as dense as they have to be to lie `spacing` voxels apart at
    /// its back; and how many planes the whole picture has.
    pub(crate) fn slab(&self, planes: [u32; 2], spacing: f64) -> RaySetup {
        let mut slab = self.clone();
        slab.planes = planes;
        if let Some(distance) = self.eye_distance {
            let back = f64::from(planes[1] - 1) * self.step;
            let extent = self.size.map(|n| f64::from(n) * self.pixel);
            slab.pixel = spacing / (1.0 + back / distance);
            slab.size = extent
                .map(|length| ((length / slab.pixel - 1e-9).ceil()).clamp(1.0, 65535.0) as u32);
            slab.tiles = [
                slab.size[0].div_ceil(self.bundle[0]),
                slab.size[1].div_ceil(self.bundle[1]),
            ];
        }
        slab
    }

    /// Only the rays of these pixels (rows from the bottom) are sent.
    pub(crate) fn keep(&mut self, alive: Vec<bool>) {
        self.alive = Some(alive);
    }

    /// Planes from the image plane to the farthest corner of everything that is drawn.
    pub fn plane_count(&self) -> u32 {
        self.plane_count
    }

    /// The same rays through a volume that lies `at` in this one.
    pub(crate) fn within(&self, at: [i32; 3], dims: [usize; 3]) -> RaySetup {
        let mut part = self.clone();
        part.centre -= DVec3::from_array(at.map(f64::from));
        part.dims = dims;
        part
    }

    /// The same samples, but only those in some cells of an axis, in a volume that begins there.
    pub(crate) fn cut(&self, axis: usize, cells: [i32; 2]) -> RaySetup {
        let mut part = self.clone();
        part.cut = Some((axis, cells));
        part
    }

    /// Where a sample of a pixel lies across the view direction, to the right and up, in voxels.
    pub(crate) fn lateral(&self, pixel: u32, plane: u32) -> [f64; 2] {
        let spread = self.eye_distance.map_or(1.0, |distance| {
            1.0 + f64::from(plane) * self.step / distance
        });
        self.offset(pixel % self.size[0], pixel / self.size[0])
            .map(|c| c * spread)
    }

    /// Bound of the components of what lies between two samples of one plane in neighbouring columns, in voxels: their
    /// distance at the back, and the rounding of both.
    pub(crate) fn largest_light_step(&self) -> f64 {
        let planes = f64::from(self.plane_count);
        let spread = self
            .eye_distance
            .map_or(1.0, |distance| 1.0 + planes * self.step / distance);
        let rounding = 1.0 / f64::from(1u32 << self.position[1])
            + planes / f64::from(1u32 << self.step_fraction);
        self.pixel * spread * self.axes.right.abs().max_element() + rounding
    }

    /// Distance of samples along the view direction in voxels.
    pub(crate) fn step(&self) -> f64 {
        self.step
    }

    /// Planes from the image plane back to the eye, in voxels; none for parallel rays.
    pub(crate) fn eye_distance(&self) -> Option<f64> {
        self.eye_distance
    }

    /// Where the ray of a pixel crosses the image plane, and its direction, one voxel long along the view direction.
    pub(crate) fn line(&self, x: u32, y: u32) -> (DVec3, DVec3) {
        (self.start(x, y), self.direction(x, y))
    }

    /// Where on the picture a point of the volume is seen, in pixels; none at the eye and behind it.
    pub(crate) fn project(&self, point: DVec3) -> Option<[f64; 2]> {
        let from_centre = point - self.centre;
        let spread = match self.eye_distance {
            None => 1.0,
            Some(distance) => 1.0 + from_centre.dot(self.axes.forward) / distance,
        };
        let seen = |axis: DVec3, n: u32| {
            from_centre.dot(axis) / spread / self.pixel + 0.5 * (f64::from(n) - 1.0)
        };
        (spread > 1e-3).then(|| {
            [
                seen(self.axes.right, self.size[0]),
                seen(self.axes.up, self.size[1]),
            ]
        })
    }

    /// The tile of a pixel (rows from the bottom).
    pub fn tile_of(&self, pixel: usize) -> usize {
        let (x, y) = (pixel % self.size[0] as usize, pixel / self.size[0] as usize);
        x / self.bundle[0] as usize + y / self.bundle[1] as usize * self.tiles[0] as usize
    }

    /// Number of pixels.
    pub fn pixel_count(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    /// The rays of a tile that hit the volume, x fastest; tiles in raster order from the bottom left.
    pub fn tile(&self, index: usize) -> Vec<Ray> {
        let tx = index as u32 % self.tiles[0] * self.bundle[0];
        let ty = index as u32 / self.tiles[0] * self.bundle[1];
        let mut rays = Vec::with_capacity((self.bundle[0] * self.bundle[1]) as usize);
        for y in ty..(ty + self.bundle[1]).min(self.size[1]) {
            for x in tx..(tx + self.bundle[0]).min(self.size[0]) {
                rays.extend(self.ray(x, y));
            }
        }
        rays
    }

    /// The ray of a pixel (rows from the bottom), clipped to the volume; none if it misses.
    pub fn ray(&self, x: u32, y: u32) -> Option<Ray> {
        let pixel = y as usize * self.size[0] as usize + x as usize;
        if self.alive.as_ref().is_some_and(|alive| !alive[pixel]) {
            return None;
        }
        if let Some(rays) = &self.given {
            return rays[pixel];
        }
        let start = self.start(x, y);
        let delta = self.direction(x, y) * self.step;
        let (first, last) = self.clip(start, delta)?;
        let (first, last) = (first.max(self.planes[0]), last.min(self.planes[1] - 1));
        if first > last {
            return None;
        }
        let position = start + delta * f64::from(first);
        let [integer, fraction] = self.position;
        let fixed = |p: f64| from_f64(p, integer, fraction).unwrap_or(i32::MAX);
        let ray = Ray {
            position: position.to_array().map(fixed),
            step: self.fixed_step(delta),
            remaining: (last - first + 1).min((1 << self.length) - 1),
            plane: first,
            pixel: y * self.size[0] + x,
        };
        match self.cut {
            Some((axis, cells)) => self.part_of(ray, axis, cells),
            None => Some(ray),
        }
    }

    /// What of a ray lies in some cells of an axis, counted from the first of them. Words are advanced as the processor does
    /// it, so that parts of a ray have the very samples of the whole.
    fn part_of(&self, ray: Ray, axis: usize, [first, behind]: [i32; 2]) -> Option<Ray> {
        let fraction = self.position[1];
        let at = |k: u32| AddressGenerator::advance(ray.position, ray.step, k);
        let cell = |k: u32| at(k)[axis] >> fraction;
        let mut inside = (0..ray.remaining).skip_while(|k| !(first..behind).contains(&cell(*k)));
        let begin = inside.next()?;
        let rest = inside
            .take_while(|k| (first..behind).contains(&cell(*k)))
            .count() as u32;
        let mut position = at(begin);
        position[axis] -= first.max(0) << fraction;
        Some(Ray {
            position,
            remaining: 1 + rest,
            plane: ray.plane + begin,
            ..ray
        })
    }

    /// First and last sample of the lattice of planes that lie in the hull of the voxel centres.
    fn clip(&self, start: DVec3, delta: DVec3) -> Option<(u32, u32)> {
        // A position of less than half its last bit outside is inside.
        const SLACK: f64 = 1e-6;
        let (mut low, mut high) = (0.0f64, f64::INFINITY);
        for axis in 0..3 {
            let top = self.dims[axis] as f64 - 1.0 + SLACK;
            let (p, d) = (start[axis], delta[axis]);
            if d.abs() < 1e-12 {
                if p < -SLACK || p > top {
                    return None;
                }
                continue;
            }
            let (a, b) = ((-SLACK - p) / d, (top - p) / d);
            low = low.max(a.min(b));
            high = high.min(a.max(b));
        }
        let (first, last) = (low.ceil(), high.floor());
        (first <= last && last < 65536.0).then_some((first as u32, last as u32))
    }

    /// Where the ray of a pixel crosses the image plane.
    fn start(&self, x: u32, y: u32) -> DVec3 {
        let [u, v] = self.offset(x, y);
        self.centre + self.axes.right * u + self.axes.up * v
    }

    fn offset(&self, x: u32, y: u32) -> [f64; 2] {
        let at = |i: u32, n: u32| (f64::from(i) - 0.5 * (f64::from(n) - 1.0)) * self.pixel;
        [at(x, self.size[0]), at(y, self.size[1])]
    }

    /// The direction of the ray of a pixel, one voxel long along the view direction.
    fn direction(&self, x: u32, y: u32) -> DVec3 {
        match self.eye_distance {
            None => self.axes.forward,
            Some(distance) => {
                let [u, v] = self.offset(x, y);
                self.axes.forward + (self.axes.right * u + self.axes.up * v) / distance
            }
        }
    }

    fn fixed_step(&self, delta: DVec3) -> [i32; 3] {
        let shift = self.position[1] - self.step_fraction;
        delta
            .to_array()
            .map(|c| ((c * f64::from(1u32 << self.step_fraction)).round() as i32) << shift)
    }

    fn longest_ray(&self) -> u32 {
        let mut longest = 0;
        for y in 0..self.size[1] {
            for x in 0..self.size[0] {
                let clipped = self.clip(self.start(x, y), self.direction(x, y) * self.step);
                longest = longest.max(clipped.map_or(0, |(first, last)| last - first + 1));
            }
        }
        longest
    }
}

/// Sine and cosine with exact zeros and ones at multiples of 90°.
fn sin_cos_deg(angle: f64) -> (f64, f64) {
    match angle.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        angle => angle.to_radians().sin_cos(),
    }
}
