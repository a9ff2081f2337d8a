//! Ray set-up: from pixels to a packet of lattices in voxel space.

use crate::doubles::{F64s, Mask64};
use crate::lanes::{F32s, LANES, PACKET, Vec3s, each, lanes};
use crate::levels::{Level, inlined, vectorized};
use crate::library::clip_ray;
use crate::library::jitter::Jitters;
use crate::line::{Line, MAX_POINTS};
use crate::raster::Raster;
use crate::rays::Rays;
use crate::scenery::Scenery;
use glam::DVec3;
use strahl_scene::plan::{Plan, Sampling};
use strahl_volume::Grid;

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

impl<S: Level> RayPacket<S> {
    /// A packet without rays for `objects` objects.
    pub fn empty(objects: usize) -> RayPacket<S> {
        RayPacket {
            lines: (0..objects).map(|_| Line::none()).collect(),
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

    /// Becomes the rays of the block of pixels with its `corner` at this column and row of `raster`, as far as
    /// it lies left of and above those of `end`, in picture number `frame`.
    #[inline(never)]
    pub fn aim(
        &mut self,
        scenery: &Scenery<S>,
        raster: Raster,
        corner: [u32; 2],
        end: [u32; 2],
        frame: u32,
    ) {
        vectorized::<S, _>(
            #[inline(always)]
            || self.aim_here(scenery, raster, corner, end, frame),
        );
    }

    #[inline(always)]
    fn aim_here(
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
                let color;
                (self.opaque_mm[lane], color) = scenery.meshes.behind(&rays.ray(lane), plan);
                for (channel, number) in behind.iter_mut().zip(color) {
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
            Jitters::Center => F32s::splat(0.5),
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
        let is_alone = plan.layers.len() == 1;
        for (layer, line) in self.lines.iter_mut().enumerate() {
            let grid = &plan.field_of(layer).grid;
            *line = Line::of_rays(grid, &rays, t_entry, plan.lattice.step_mm);
            line.end = self.count;
            if !is_alone {
                let [first, last] = self.intervals[layer];
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
    let diagonal = if plan.layers.len() == 1 {
        let corners = corners(&plan.field().grid);
        (0..4)
            .map(|i| corners[i].distance(corners[7 - i]))
            .fold(0.0, f64::max)
    } else {
        let all = plan.drawn_fields().flat_map(|field| corners(&field.grid));
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (lo, hi) = all.fold(start, |(lo, hi), c| (lo.min(c), hi.max(c)));
        lo.distance(hi)
    };
    diagonal / plan.lattice.step_mm
}
