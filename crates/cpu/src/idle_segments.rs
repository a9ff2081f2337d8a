//! Which bricks of a volume lie in one segment whose technique shows nothing there.

use crate::hidden_segments::around;
use crate::making::Making;
use crate::skip::Skip;
use crate::technique_bricks::TechniqueBricks;
use glam::DAffine3;
use std::sync::Arc;
use strahl_scene::plan::{Labelled, Plan};
use strahl_scene::visibility::ContributionKey;
use strahl_volume::{Cancelled, ContentId, Control, Key, LabelIds, LabelNumbers, cores};

/// The number of a brick's segment where there are several.
const MIXED: u32 = u32::MAX;

/// Key of the segments of bricks.
#[derive(Clone, Debug, PartialEq)]
struct SegmentsOfBricksKey {
    labels: ContentId,
    label_from_voxel: DAffine3,
    dims: [usize; 3],
    outside: u32,
}

impl Key for SegmentsOfBricksKey {
    type Value = Vec<u32>;

    const NAME: &str = "segments of bricks";

    fn bytes(&self, value: &Vec<u32>) -> usize {
        size_of_val(&value[..])
    }
}

/// Key of the bricks in which a segment shows nothing.
#[derive(Clone, Debug, PartialEq)]
struct IdleBricksKey {
    segments: SegmentsOfBricksKey,
    /// By the number of the segment; 0 if it is hidden.
    techniques: Vec<u32>,
    contributions: Vec<ContributionKey>,
}

impl Key for IdleBricksKey {
    type Value = Option<Skip>;

    const NAME: &str = "bricks of idle segments";

    fn bytes(&self, value: &Option<Skip>) -> usize {
        size_of_val(&self.techniques[..])
            + TechniqueBricks::key_bytes(&self.contributions)
            + value.as_ref().map_or(0, Skip::bytes)
    }
}

/// Where all lattice points lie in one segment, that of the point where the ray is, and its technique shows none of them.
/// What the ray has seen does not change there, but for the end of a run in another segment. `None` if there is no such place.
pub fn idle_segments(
    making: &Making,
    plan: &Plan,
    (bricks, known): ([usize; 3], &TechniqueBricks),
    labels: (ContentId, &LabelNumbers),
) -> Result<Option<Arc<Option<Skip>>>, Cancelled> {
    let Some(labelled) = plan.labelled() else {
        return Ok(None);
    };
    // Words are gathered at 32-bit offsets.
    let fits = bricks.iter().product::<usize>() <= i32::MAX as usize / 8;
    if !fits || known.keys.is_empty() {
        return Ok(None);
    }
    let (field, segments) = (plan.field(), labelled.numbered(&labels.1.ids));
    let key = IdleBricksKey {
        segments: SegmentsOfBricksKey {
            labels: labels.0,
            label_from_voxel: labelled.label_from_voxel(field),
            dims: field.grid.dims(),
            outside: segments.outside,
        },
        contributions: known.keys.clone(),
        techniques: segments.techniques,
    };
    let make = || {
        let of_bricks = making.find(&key.segments, || {
            segments_of_bricks(bricks, &key.segments, labelled, labels.1, making.control)
        })?;
        let is_idle = |(brick, segment): (usize, &u32)| {
            let technique = key.techniques.get(*segment as usize);
            technique.is_some_and(|technique| known.is_quiet(*technique, brick))
        };
        let is_idle: Vec<bool> = of_bricks.iter().enumerate().map(is_idle).collect();
        skip(bricks, &of_bricks, &is_idle, making.control)
    };
    Ok(Some(making.find(&key, make)?))
}

/// What can be left out: cubes of bricks of the segment that is idle most often, and other idle bricks one by one, as
/// the next may be of another segment.
fn skip(
    dims: [usize; 3],
    of_bricks: &[u32],
    is_idle: &[bool],
    control: &Control,
) -> Result<Option<Skip>, Cancelled> {
    let mut numbers = std::collections::BTreeMap::<u32, usize>::new();
    for (segment, _) in of_bricks.iter().zip(is_idle).filter(|(_, idle)| **idle) {
        *numbers.entry(*segment).or_default() += 1;
    }
    let Some((&most, _)) = numbers.iter().max_by_key(|(_, number)| **number) else {
        return Ok(None);
    };
    let of_most = of_bricks.iter().zip(is_idle);
    let visible: Vec<bool> = of_most
        .map(|(segment, idle)| !idle || *segment != most)
        .collect();
    Skip::of_visible_and_single(dims, &visible, is_idle, control).map(Some)
}

/// For each of so many bricks the number of the segment in which all places in it lie, or [`MIXED`].
fn segments_of_bricks(
    [nx, ny, nz]: [usize; 3],
    key: &SegmentsOfBricksKey,
    labelled: &Labelled,
    labels: &LabelNumbers,
    control: &Control,
) -> Result<Vec<u32>, Cancelled> {
    let label_dims = labelled.grid.dims();
    let number = |index: usize| match &labels.numbers {
        LabelIds::U8(numbers) => u32::from(numbers[index]),
        LabelIds::U16(numbers) => u32::from(numbers[index]),
        LabelIds::U32(numbers) => numbers[index],
    };
    let is_all = |row: std::ops::Range<usize>, number: u32| match &labels.numbers {
        LabelIds::U8(numbers) => numbers[row].iter().all(|&n| u32::from(n) == number),
        LabelIds::U16(numbers) => numbers[row].iter().all(|&n| u32::from(n) == number),
        LabelIds::U32(numbers) => numbers[row].iter().all(|&n| n == number),
    };
    let segment = |low: [i64; 3], high: [i64; 3]| {
        let inside = |axis: usize| {
            let last = label_dims[axis] as i64 - 1;
            low[axis].clamp(0, last) as usize..high[axis].clamp(0, last) as usize + 1
        };
        let (xs, ys, zs) = (inside(0), inside(1), inside(2));
        let row = |y: usize, z: usize| label_dims[0] * (y + label_dims[1] * z);
        let first = number(row(ys.start, zs.start) + xs.start);
        let is_beyond = |axis: usize| low[axis] < 0 || high[axis] >= label_dims[axis] as i64;
        if first != key.outside && (0..3).any(is_beyond) {
            return MIXED;
        }
        let is_one = zs
            .into_iter()
            .all(|z| (ys.clone()).all(|y| is_all(row(y, z) + xs.start..row(y, z) + xs.end, first)));
        if is_one { first } else { MIXED }
    };
    let mut segments = vec![MIXED; nx * ny * nz];
    cores::try_for_each(
        segments.chunks_mut(nx * ny).enumerate(),
        || (),
        |(), (z, slice)| {
            control.check()?;
            for (i, of_brick) in slice.iter_mut().enumerate() {
                let (low, high) = around([i % nx, i / nx, z], &key.label_from_voxel, key.dims);
                *of_brick = segment(low, high);
            }
            Ok(())
        },
    )?;
    Ok(segments)
}
