//! Which segments lie in each brick of a volume.

use crate::brick_number::EDGE;
use crate::making::Making;
use glam::{DAffine3, DVec3};
use std::ops::Range;
use std::sync::Arc;
use strahl_scene::plan::Plan;
use strahl_volume::{Cancelled, ContentId, Control, Key, LabelIds, LabelNumbers, cores};

/// The numbers of the segments in which places of each brick lie.
pub struct SegmentsOfBricks {
    /// Where the numbers of each brick begin, then where those of the last one end.
    starts: Vec<usize>,
    numbers: Vec<u32>,
}

/// Key of the segments of bricks.
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentsOfBricksKey {
    labels: ContentId,
    label_from_voxel: DAffine3,
    dims: [usize; 3],
    label_dims: [usize; 3],
    /// The segment beyond the extent of the labels.
    outside: u32,
}

impl Key for SegmentsOfBricksKey {
    type Value = SegmentsOfBricks;

    const NAME: &str = "segments of bricks";

    fn bytes(&self, value: &SegmentsOfBricks) -> usize {
        size_of_val(&value.starts[..]) + size_of_val(&value.numbers[..])
    }
}

impl SegmentsOfBricksKey {
    /// That of the labels of `plan`, if it has some, whose voxels have the content `labels`.
    pub fn new(plan: &Plan, labels: ContentId, outside: u32) -> Option<SegmentsOfBricksKey> {
        let (labeled, field) = (plan.labeled()?, plan.field());
        Some(SegmentsOfBricksKey {
            labels,
            label_from_voxel: labeled.label_from_voxel(field),
            dims: field.grid.dims(),
            label_dims: labeled.grid.dims(),
            outside,
        })
    }

    /// The number of bricks along each axis. Bricks hold cells, of which there is one less than voxels.
    pub fn bricks(&self) -> [usize; 3] {
        self.dims.map(|n| (n.max(2) - 1).div_ceil(EDGE))
    }

    /// The segments of all bricks.
    pub fn find(
        &self,
        making: &Making,
        labels: &LabelNumbers,
    ) -> Result<Arc<SegmentsOfBricks>, Cancelled> {
        making.find(self, || self.make(labels, making.control))
    }

    fn make(
        &self,
        labels: &LabelNumbers,
        control: &Control,
    ) -> Result<SegmentsOfBricks, Cancelled> {
        let [nx, ny, nz] = self.bricks();
        // Of each slice of bricks how many numbers each brick has, and the numbers.
        let mut slices = vec![(Vec::new(), Vec::new()); nz];
        cores::try_for_each(
            slices.iter_mut().enumerate(),
            || (),
            |(), (z, (ends, numbers))| {
                control.check()?;
                for i in 0..nx * ny {
                    let first = numbers.len();
                    self.append([i % nx, i / nx, z], labels, numbers);
                    ends.push(numbers.len() - first);
                }
                Ok(())
            },
        )?;
        let mut all = SegmentsOfBricks {
            starts: vec![0],
            numbers: Vec::new(),
        };
        let mut end = 0;
        for (of_bricks, numbers) in slices {
            all.numbers.extend(numbers);
            all.starts.extend(of_bricks.into_iter().map(|number| {
                end += number;
                end
            }));
        }
        Ok(all)
    }

    /// Appends the numbers in a brick, each once.
    fn append(&self, brick: [usize; 3], labels: &LabelNumbers, to: &mut Vec<u32>) {
        let first = to.len();
        let mut add = |number: u32| {
            if !to[first..].contains(&number) {
                to.push(number);
            }
        };
        let (low, high) = around(brick, &self.label_from_voxel, self.dims);
        let dims = self.label_dims;
        if (0..3).any(|axis| low[axis] < 0 || high[axis] >= dims[axis] as i64) {
            add(self.outside);
        }
        let inside = |axis: usize| {
            let last = dims[axis] as i64 - 1;
            low[axis].clamp(0, last) as usize..high[axis].clamp(0, last) as usize + 1
        };
        let (xs, ys, zs) = (inside(0), inside(1), inside(2));
        for (y, z) in zs.flat_map(|z| ys.clone().map(move |y| (y, z))) {
            let row = dims[0] * (y + dims[1] * z);
            let row = row + xs.start..row + xs.end;
            match &labels.numbers {
                LabelIds::U8(numbers) => of_row(numbers, row, &mut add),
                LabelIds::U16(numbers) => of_row(numbers, row, &mut add),
                LabelIds::U32(numbers) => of_row(numbers, row, &mut add),
            }
        }
    }
}

impl SegmentsOfBricks {
    /// The numbers of the segments of every brick, at least one.
    pub fn all(&self) -> impl Iterator<Item = &[u32]> {
        self.starts
            .windows(2)
            .map(|ends| &self.numbers[ends[0]..ends[1]])
    }
}

/// The numbers of a row. Equal ones lie side by side.
fn of_row<T: Copy + PartialEq + Into<u32>>(
    numbers: &[T],
    row: Range<usize>,
    mut add: impl FnMut(u32),
) {
    for run in numbers[row].chunk_by(T::eq) {
        add(run[0].into());
    }
}

/// The label voxels that matter to a brick: those around the box that its cells make, a little enlarged, as positions
/// are rounded. The outermost bricks go on to the border of the volume.
fn around(
    brick: [usize; 3],
    label_from_voxel: &DAffine3,
    dims: [usize; 3],
) -> ([i64; 3], [i64; 3]) {
    const MARGIN: f64 = 0.05;
    let edges = |axis: usize| {
        let low = (brick[axis] * EDGE) as f64;
        let end = dims[axis] as f64 - 0.5;
        let high = low + EDGE as f64;
        let low = if brick[axis] == 0 { -0.5 } else { low };
        let high = if high >= (dims[axis] - 1) as f64 {
            end
        } else {
            high
        };
        [low - MARGIN, high + MARGIN]
    };
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for corner in 0..8 {
        let at = |axis: usize| edges(axis)[corner >> axis & 1];
        let place = label_from_voxel.transform_point3(DVec3::new(at(0), at(1), at(2)));
        (low, high) = (low.min(place), high.max(place));
    }
    // A voxel that positions reach by less than an eighth never has the largest of eight weights.
    let whole = |v: f64| v.clamp(-1e15, 1e15) as i64;
    let low = (low + MARGIN).floor().to_array().map(whole);
    let high = (high - MARGIN).ceil().to_array().map(whole);
    (low, high)
}
