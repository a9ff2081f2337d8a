//! Which bricks clips leave nothing of.

use super::values;
use crate::plan::{ClipShape, Plan, SampleClip};
use glam::{DAffine3, DVec3};
use std::ops::Range;
use strahl_volume::bricks::{BrickRange, Bricks};
use strahl_volume::{Cancelled, Control, Volume};

/// For each brick of layer number `layer`, x fastest, whether the Plan's clips drop every sample inside, wherever they
/// are; `None` if there is no such brick. There are `dims` bricks of `edge`³ cells, as
/// [`Bricks`] has them. `mask` gives the masks of the Plan, with bricks of any size.
///
/// # Errors
/// `control` was cancelled.
pub fn dropped<'m>(
    plan: &Plan,
    layer: usize,
    dims: [usize; 3],
    edge: usize,
    mask: impl Fn(usize) -> (&'m Volume, &'m Bricks),
    control: &'m Control,
) -> Result<Option<Vec<bool>>, Cancelled> {
    let grid = &plan.field_of(layer).grid;
    let clips: Vec<Clip> = plan
        .sample_clips
        .iter()
        .filter(|clip| clip.cuts(layer))
        .map(|clip| Clip::new(clip, grid.world_from_voxel(), &mask))
        .collect();
    if clips.is_empty() {
        return Ok(None);
    }
    let mut bricks = BrickWalk {
        clips,
        dims,
        edge,
        voxels: grid.dims(),
        dropped: vec![false; dims.iter().product()],
        control,
    };
    bricks.look_at(dims.map(|n| 0..n))?;
    let BrickWalk { dropped, .. } = bricks;
    Ok(dropped.contains(&true).then_some(dropped))
}

/// How much of a box lies inside a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    None,
    /// Or not known.
    Some,
    All,
}

impl Part {
    fn of(is_all: bool, is_none: bool) -> Part {
        match (is_all, is_none) {
            (true, _) => Part::All,
            (_, true) => Part::None,
            _ => Part::Some,
        }
    }

    /// Of what lies inside both, where this is the part inside one.
    fn and(self, other: impl FnOnce() -> Part) -> Part {
        match self {
            Part::None => Part::None,
            Part::All => other(),
            Part::Some => match other() {
                Part::None => Part::None,
                _ => Part::Some,
            },
        }
    }
}

/// A box in the space of the unit cube: its middle, and from there to its faces. What rounding in single precision can
/// move a point by is part of it.
struct UnitBox {
    middle: DVec3,
    reach: DVec3,
    /// What rounding can move a point by, along each axis.
    rounding: DVec3,
}

impl UnitBox {
    fn nearest(&self) -> DVec3 {
        (self.middle.abs() - self.reach).max(DVec3::ZERO)
    }

    fn furthest(&self) -> DVec3 {
        self.middle.abs() + self.reach
    }

    fn part_of_cube(&self) -> Part {
        Part::of(
            self.furthest().max_element() <= 0.5,
            self.nearest().max_element() > 0.5,
        )
    }
}

struct Clip<'m> {
    unit_from_voxel: DAffine3,
    keep_inside: bool,
    shape: Shape<'m>,
}

enum Shape<'m> {
    Box,
    Ellipsoid,
    Cylinder,
    Mask(Mask<'m>),
}

struct Mask<'m> {
    volume: &'m Volume,
    bricks: &'m Bricks,
    threshold: f32,
    /// Whether every voxel has a value.
    is_whole: bool,
    /// From the smallest stored number to the largest.
    width: f64,
}

impl<'m> Clip<'m> {
    fn new(
        clip: &SampleClip,
        world_from_voxel: DAffine3,
        mask: &impl Fn(usize) -> (&'m Volume, &'m Bricks),
    ) -> Clip<'m> {
        let shape = match clip.shape {
            ClipShape::Box => Shape::Box,
            ClipShape::Ellipsoid => Shape::Ellipsoid,
            ClipShape::Cylinder => Shape::Cylinder,
            ClipShape::Mask {
                mask: index,
                threshold,
            } => {
                let (volume, bricks) = mask(index);
                Shape::Mask(Mask::new(volume, bricks, threshold))
            }
        };
        Clip {
            unit_from_voxel: clip.unit_from_world * world_from_voxel,
            keep_inside: clip.keep_inside,
            shape,
        }
    }

    /// How much of the box between two corners in voxel space is kept.
    fn kept(&self, low: DVec3, high: DVec3) -> Part {
        let matrix = self.unit_from_voxel.matrix3;
        let absolute = glam::DMat3::from_cols(
            matrix.x_axis.abs(),
            matrix.y_axis.abs(),
            matrix.z_axis.abs(),
        );
        // Renderers work with the matrix in single precision: some six operations of 2⁻²⁴ each.
        let size = absolute * low.abs().max(high.abs()) + self.unit_from_voxel.translation.abs();
        let rounding = size / f64::from(1 << 20);
        let unit = UnitBox {
            middle: self.unit_from_voxel.transform_point3((low + high) * 0.5),
            reach: absolute * ((high - low) * 0.5) + rounding,
            rounding,
        };
        // Such numbers may overflow there.
        let fits = size.max_element() < 1e15;
        if !fits {
            return Part::Some;
        }
        match (self.inside(&unit), self.keep_inside) {
            (Part::Some, _) => Part::Some,
            (Part::All, true) | (Part::None, false) => Part::All,
            (Part::None, true) | (Part::All, false) => Part::None,
        }
    }

    fn inside(&self, unit: &UnitBox) -> Part {
        // Squares are rounded, too.
        let (less, more) = (0.25 - 1e-6, 0.25 + 1e-6);
        match &self.shape {
            Shape::Box => unit.part_of_cube(),
            Shape::Ellipsoid => Part::of(
                unit.furthest().length_squared() < less,
                unit.nearest().length_squared() > more,
            ),
            Shape::Cylinder => unit.part_of_cube().and(|| {
                Part::of(
                    unit.furthest().truncate().length_squared() < less,
                    unit.nearest().truncate().length_squared() > more,
                )
            }),
            Shape::Mask(mask) => unit.part_of_cube().and(|| mask.above(unit)),
        }
    }
}

impl Mask<'_> {
    fn new<'m>(volume: &'m Volume, bricks: &'m Bricks, threshold: f32) -> Mask<'m> {
        let all = bricks.ranges().fold(BrickRange::EMPTY, BrickRange::joined);
        Mask {
            volume,
            bricks,
            threshold,
            is_whole: volume.statistics().not_finite == 0,
            width: (f64::from(all.hi) - f64::from(all.lo)).max(0.0),
        }
    }

    /// Where in a box, as far as it lies in the mask's extent, its values are above the threshold.
    fn above(&self, unit: &UnitBox) -> Part {
        let dims = self.volume.grid().dims().map(|n| n as f64);
        let edge = self.bricks.edge();
        let mut blurred = 0.0;
        let bricks: [Range<usize>; 3] = std::array::from_fn(|axis| {
            let (n, reach) = (dims[axis], unit.reach[axis]);
            let voxel = |unit: f64| (unit + 0.5) * n - 0.5;
            // Where a box ends on a face between two cells, rounding must not add the next one: values are continuous,
            // what they change by on such a way is added instead.
            let rounding = n * (unit.rounding[axis] + 1.0 / f64::from(1 << 20));
            blurred += 2.0 * rounding;
            let cell = |position: f64| position.clamp(0.0, (n - 2.0).max(0.0)) as usize;
            let first = cell(voxel(unit.middle[axis] - reach) + rounding);
            let last = cell(voxel(unit.middle[axis] + reach) - rounding);
            first.min(last) / edge..first.max(last) / edge + 1
        });
        let mut range = BrickRange::EMPTY;
        for z in bricks[2].clone() {
            for y in bricks[1].clone() {
                for x in bricks[0].clone() {
                    range = range.joined(self.bricks.range([x, y, z]));
                }
            }
        }
        if range.is_empty() {
            // Nothing but NaN, which is above nothing.
            return Part::None;
        }
        let by = (self.width * blurred) as f32;
        let (lo, hi) = values(
            BrickRange {
                lo: range.lo - by,
                hi: range.hi + by,
            },
            self.volume.rescale(),
        );
        Part::of(self.is_whole && lo > self.threshold, hi <= self.threshold)
    }
}

/// The bricks on the way to their answers.
struct BrickWalk<'m> {
    clips: Vec<Clip<'m>>,
    dims: [usize; 3],
    edge: usize,
    voxels: [usize; 3],
    dropped: Vec<bool>,
    control: &'m Control,
}

impl BrickWalk<'_> {
    /// Finds those of a block of bricks: at once if they are alike, half by half if not.
    fn look_at(&mut self, block: [Range<usize>; 3]) -> Result<(), Cancelled> {
        self.control.check()?;
        match self.kept(&block) {
            Part::All => {}
            Part::None => {
                let [nx, ny, _] = self.dims;
                for z in block[2].clone() {
                    for y in block[1].clone() {
                        let row = nx * (y + ny * z);
                        self.dropped[row..][block[0].clone()].fill(true);
                    }
                }
            }
            Part::Some => {
                let longest = (0..3).max_by_key(|&axis| block[axis].len());
                let longest = longest.expect("there are three axes");
                let Range { start, end } = block[longest];
                if end - start <= 1 {
                    return Ok(());
                }
                let middle = (start + end) / 2;
                for half in [start..middle, middle..end] {
                    let mut block = block.clone();
                    block[longest] = half;
                    self.look_at(block)?;
                }
            }
        }
        Ok(())
    }

    fn kept(&self, block: &[Range<usize>; 3]) -> Part {
        let corner = |of_axis: &dyn Fn(usize) -> f64| DVec3::from_array([0, 1, 2].map(of_axis));
        // The outer ones have what lies beyond the outer voxels as well: half a voxel, and a little where rays begin.
        let low = corner(&|axis| match block[axis].start {
            0 => -0.75,
            first => (first * self.edge) as f64,
        });
        let high = corner(&|axis| {
            if block[axis].end < self.dims[axis] {
                (block[axis].end * self.edge) as f64
            } else {
                self.voxels[axis] as f64 - 0.25
            }
        });
        let mut kept = Part::All;
        for clip in &self.clips {
            kept = match clip.kept(low, high) {
                Part::None => return Part::None,
                Part::Some => Part::Some,
                Part::All => kept,
            };
        }
        kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Scene, resolve};
    use strahl_volume::{Grid, Metadata, Rescale, Samples};

    const DIMS: [usize; 3] = [18, 17, 5];

    fn volume_of(of_voxel: impl Fn([usize; 3]) -> u8) -> Volume {
        let [nx, ny, nz] = DIMS;
        let voxel = |i: usize| of_voxel([i % nx, i / nx % ny, i / (nx * ny)]);
        let samples = Samples::U8((0..nx * ny * nz).map(voxel).collect());
        let grid = Grid::centered(DIMS, DVec3::splat(2.0)).unwrap();
        Volume::new(grid, samples, Rescale::IDENTITY, Metadata::default()).unwrap()
    }

    /// The plan of a volume with one clip, whose cube covers the voxels between two corners of voxel space.
    fn clipped(shape: ClipShape, low: [f64; 3], high: [f64; 3], keep_inside: bool) -> Plan {
        let volume = volume_of(|_| 1);
        let scene = Scene::parse("scene", "{}").unwrap();
        let mut plan = resolve(&scene, &volume.header(), None).unwrap();
        let (low, high) = (DVec3::from_array(low), DVec3::from_array(high));
        let voxel_from_unit =
            DAffine3::from_translation((low + high) * 0.5) * DAffine3::from_scale(high - low);
        plan.sample_clips = vec![SampleClip {
            shape,
            unit_from_world: (volume.grid().world_from_voxel() * voxel_from_unit).inverse(),
            keep_inside,
            layers: 1,
        }];
        plan
    }

    /// The numbers of the bricks that are dropped.
    fn found(plan: &Plan, mask: &Volume) -> Vec<usize> {
        let bricks = Bricks::with_edge(mask, 4);
        assert_eq!(bricks.dims(), [5, 4, 1]);
        let of_mask = |_| (mask, &bricks);
        let dropped = dropped(plan, 0, bricks.dims(), 4, of_mask, &Control::NONE).unwrap();
        let dropped = dropped.unwrap_or_default();
        (0..dropped.len()).filter(|&i| dropped[i]).collect()
    }

    #[test]
    fn bricks_inside_a_box_and_outside() {
        let mask = volume_of(|_| 1);
        // From the corner of brick (1, 1) to almost that of (4, 3).
        let (low, high) = ([3.9, 3.9, -9.0], [15.9, 12.1, 9.0]);
        let inside = clipped(ClipShape::Box, low, high, false);
        assert_eq!(found(&inside, &mask), [6, 7, 11, 12]);
        let outside = clipped(ClipShape::Box, low, high, true);
        assert_eq!(found(&outside, &mask), [4, 9, 14, 19]);
    }

    #[test]
    fn round_shapes_leave_what_is_in_the_corners_of_their_cube() {
        let mask = volume_of(|_| 1);
        let (low, high) = ([-0.5, -0.5, -9.0], [17.5, 16.5, 9.0]);
        let cylinder = found(&clipped(ClipShape::Cylinder, low, high, false), &mask);
        assert_eq!(cylinder, [6, 7, 8, 11, 12, 13]);
        // A ball that leaves out the corners of its cube, and does not hold the middle in all of its height.
        let (low, high) = ([2.5, 2.5, -1.0], [13.5, 13.5, 5.0]);
        assert!(found(&clipped(ClipShape::Ellipsoid, low, high, false), &mask).is_empty());
        let outside = found(&clipped(ClipShape::Ellipsoid, low, high, true), &mask);
        assert_eq!(outside, [0, 3, 4, 9, 14, 15, 18, 19]);
    }

    #[test]
    fn a_mask_on_the_same_grid_drops_its_own_bricks() {
        // Above the threshold from voxel 8 on, so that brick 1 (cells 4 to 7, voxels 4 to 8) is partly inside.
        let mask = volume_of(|[x, ..]| u8::from(x >= 8));
        let of = |threshold: f32, keep_inside| {
            let shape = ClipShape::Mask { mask: 0, threshold };
            let (low, high) = ([-0.5; 3], DIMS.map(|n| n as f64 - 0.5));
            found(&clipped(shape, low, high, keep_inside), &mask)
        };
        assert_eq!(of(0.5, true), [0, 5, 10, 15]);
        // Outer bricks reach beyond the mask's extent by as much as rounding may: never all of them is inside.
        assert_eq!(of(0.5, false), Vec::<usize>::new());
        assert_eq!(of(1.5, true), (0..20).collect::<Vec<usize>>());
    }
}
