//! How far the ray of a pixel may be off that is found in single precision.
//!
//! The CPU finds rays in double precision: only the places on them are rounded. A linked program has camera,
//! maps and clip planes as f32, and computes with f32. Each number is then off by a few half ulps of the largest
//! numbers on the way to it, which cancel: a ray that starts 500 voxels from the volume, or from where its grid has the
//! world's origin, is off by some 1e-4 voxels wherever it goes. For every operation, and for every number that
//! was rounded to f32, half an ulp (2⁻²⁴ of the result) is counted, as in N. Higham, "Accuracy and Stability of
//! Numerical Algorithms", 2002, section 3.1: a sum of n products is off by no more than n half ulps of the
//! sum of their sizes.

use super::range::Range;
use glam::DVec3;
use strahl_scene::plan::{Plan, Projection};

/// Half an ulp of 1 in single precision.
const HALF_ULP: f64 = 0.5 * f32::EPSILON as f64;

/// A place that may be farther off than this, in voxels, says nothing of what is seen there.
const MOST_VOXELS: f64 = 0.02;

/// How far a ray in single precision may be off.
pub struct SetUp {
    /// Any place on it in voxel space, along each axis.
    pub place: DVec3,
    /// The way from the entry to the exit.
    pub length_mm: f64,
}

impl SetUp {
    /// Of the ray from `origin` along `direction`; `None` where it may do anything: along a face, or at one so
    /// flat that nobody can say where it is met.
    pub fn new(plan: &Plan, origin: DVec3, direction: DVec3) -> Option<SetUp> {
        let ray = RoundedRay::new(plan, origin, direction);
        let grid = &plan.field().grid;
        let map = grid.voxel_from_world();
        let mut part = Part {
            entry: Range::exactly(0.0),
            exit: Range::exactly(f64::INFINITY),
        };
        let [mut start, mut start_doubt, mut way, mut way_doubt] = [DVec3::ZERO; 4];
        for axis in 0..3 {
            let [from, along] = ray.plane(map.matrix3.row(axis), map.translation[axis]);
            start[axis] = from.middle().abs();
            start_doubt[axis] = from.half_width();
            way[axis] = along.middle().abs();
            way_doubt[axis] = along.half_width();
            let end = grid.dims()[axis] as f64 - 0.5;
            let rounding = HALF_ULP * (start[axis] + end);
            let above_first = Range {
                lo: from.lo + 0.5,
                hi: from.hi + 0.5,
            };
            let below_last = Range {
                lo: end - from.hi,
                hi: end - from.lo,
            };
            let back = Range {
                lo: -along.hi,
                hi: -along.lo,
            };
            part.cut([above_first.widened(rounding), along])?;
            part.cut([below_last.widened(rounding), back])?;
        }
        for clip in &plan.ray_clips {
            part.cut(ray.plane(clip.normal, clip.offset_mm))?;
        }
        let Part { entry, exit } = part;
        if entry.lo > exit.hi {
            // It misses the volume, whatever is rounded.
            return Some(SetUp {
                place: DVec3::ZERO,
                length_mm: 0.0,
            });
        }
        // On the way to a place the start and the way to the entry are rounded, and cancel. Where the ray enters moves
        // every sample along it.
        let farthest_mm = exit.hi;
        let entry_mm = entry.hi - entry.lo;
        let place = start_doubt
            + farthest_mm * way_doubt
            + HALF_ULP * (2.0 * start + 3.0 * farthest_mm * way)
            + entry_mm * way;
        // The number of samples is a difference, divided by the step.
        let length_mm = entry_mm + (exit.hi - exit.lo) + 8.0 * HALF_ULP * farthest_mm;
        let is_known = place.is_finite() && place.max_element() <= MOST_VOXELS;
        is_known.then_some(SetUp { place, length_mm })
    }
}

/// A ray, and what each component of its start and direction may be off by.
struct RoundedRay {
    origin: DVec3,
    direction: DVec3,
    origin_doubt: DVec3,
    direction_doubt: DVec3,
}

impl RoundedRay {
    fn new(plan: &Plan, origin: DVec3, direction: DVec3) -> RoundedRay {
        let camera = &plan.camera;
        let aspect = f64::from(plan.width) / f64::from(plan.height);
        let (is_perspective, half_height) = match camera.projection {
            Projection::Perspective { tan_half_height } => (true, tan_half_height),
            Projection::Orthographic { half_height_mm } => (false, half_height_mm),
        };
        // The way from the middle of the picture: at most eight operations and rounded numbers, on the way to numbers up
        // to twice as large as at its border.
        let size = half_height * (aspect * camera.right.abs() + camera.up.abs());
        let offset = 16.0 * HALF_ULP * size;
        let (origin_doubt, direction_doubt) = if is_perspective {
            // `forward` has length 1 and stands upright on the offset, so that the sum is not shorter than 1,
            // and its doubt not larger once it is divided by its length; but that length is off, too.
            let sum = offset + HALF_ULP * (2.0 * camera.forward.abs() + size);
            let length = sum.length() + 4.0 * HALF_ULP;
            (
                HALF_ULP * camera.eye_mm.abs(),
                sum + length * direction.abs(),
            )
        } else {
            let eye = HALF_ULP * (camera.eye_mm.abs() + origin.abs());
            (eye + offset, HALF_ULP * direction.abs())
        };
        RoundedRay {
            origin,
            direction,
            origin_doubt,
            direction_doubt,
        }
    }

    /// normal·p + offset at the start, and how it changes per mm. The numbers of the plane are rounded, and three or
    /// four products added up.
    fn plane(&self, normal: DVec3, offset: f64) -> [Range; 2] {
        let size = normal.abs();
        let height = normal.dot(self.origin) + offset;
        let height_doubt = size.dot(self.origin_doubt)
            + 6.0 * HALF_ULP * (size.dot(self.origin.abs()) + offset.abs());
        let slope = normal.dot(self.direction);
        let slope_doubt =
            size.dot(self.direction_doubt) + 5.0 * HALF_ULP * size.dot(self.direction.abs());
        [
            Range::exactly(height).widened(height_doubt),
            Range::exactly(slope).widened(slope_doubt),
        ]
    }
}

/// The part of a ray above all planes so far, in mm from its start.
struct Part {
    entry: Range,
    exit: Range,
}

impl Part {
    /// Cut by a plane with this height and slope along the ray; `None` if it may lie in the plane.
    fn cut(&mut self, [height, slope]: [Range; 2]) -> Option<()> {
        let steepest = slope.lo.abs().max(slope.hi.abs());
        if slope.lo > 0.0 || slope.hi < 0.0 {
            let crossings = [height.lo, height.hi].map(|h| [-h / slope.lo, -h / slope.hi]);
            let crossings = crossings.into_iter().flatten().map(Range::exactly);
            let crossing = crossings.fold(Range::EMPTY, Range::hull);
            let size = crossing.lo.abs().max(crossing.hi.abs());
            let crossing = crossing.widened(3.0 * HALF_ULP * size);
            if slope.lo > 0.0 {
                self.entry.lo = self.entry.lo.max(crossing.lo);
                self.entry.hi = self.entry.hi.max(crossing.hi);
            } else {
                self.exit.lo = self.exit.lo.min(crossing.lo);
                self.exit.hi = self.exit.hi.min(crossing.hi);
            }
        } else if height.lo > 0.0 {
            // Above the plane, it may meet it far away.
            self.exit.lo = self.exit.lo.min(height.lo / steepest);
        } else if height.hi < 0.0 {
            // Below it, it may come above it far away, or never.
            self.entry.lo = self.entry.lo.max(-height.hi / steepest);
            self.entry.hi = f64::INFINITY;
        } else {
            return None;
        }
        Some(())
    }
}
