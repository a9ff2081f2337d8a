//! Which bricks of a volume hold only segments that are hidden, or whose techniques show nothing there.

use crate::brick_number::EDGE;
use crate::making::Making;
use crate::skip::Skip;
use crate::technique_bricks::TechniqueBricks;
use glam::{DAffine3, DVec3};
use std::sync::Arc;
use strahl_scene::plan::{Labelled, Plan};
use strahl_scene::visibility::ContributionKey;
use strahl_volume::{Cancelled, ContentId, Control, Key, LabelIds, LabelNumbers, cores};

/// Key of the bricks of a volume in which no segment shows anything.
#[derive(Clone, Debug, PartialEq)]
struct HiddenBricksKey {
    labels: ContentId,
    label_from_voxel: DAffine3,
    dims: [usize; 3],
    /// By the numbers of the segments, counted from 1; 0 where they are hidden.
    techniques: Vec<u32>,
    contributions: Vec<ContributionKey>,
}

impl Key for HiddenBricksKey {
    type Value = Skip;

    const NAME: &str = "bricks of hidden segments";

    fn bytes(&self, value: &Skip) -> usize {
        let tables = TechniqueBricks::key_bytes(&self.contributions);
        size_of_val(&self.techniques[..]) + tables + value.bytes()
    }
}

/// Which lattice points show nothing of any segment, whatever segments they lie in; `None` where there are none.
/// Rays that have seen something of a run have to look whether it ends there; with groups of segments, nothing is `known`
/// but which are hidden.
pub fn hidden_segments(
    making: &Making,
    plan: &Plan,
    known: &TechniqueBricks,
    labels: (ContentId, &LabelNumbers),
) -> Result<Option<Arc<Skip>>, Cancelled> {
    let Some(labelled) = plan.labelled() else {
        return Ok(None);
    };
    let field = plan.field();
    let segments = labelled.numbered(&labels.1.ids);
    let is_grouped = !labelled.groups.is_empty();
    // Bricks hold cells, of which there is one less than voxels.
    let bricks = field.grid.dims().map(|n| (n.max(2) - 1).div_ceil(EDGE));
    // Words are gathered at 32-bit offsets.
    let fits = bricks.iter().product::<usize>() <= i32::MAX as usize / 8;
    let is_any = segments.techniques.contains(&0) || !(is_grouped || known.keys.is_empty());
    if !is_any || !fits {
        return Ok(None);
    }
    let key = HiddenBricksKey {
        labels: labels.0,
        label_from_voxel: labelled.label_from_voxel(field),
        dims: field.grid.dims(),
        contributions: match is_grouped {
            true => Vec::new(),
            false => known.keys.clone(),
        },
        techniques: segments.techniques,
    };
    let is_nothing = |number: u32, brick: usize| {
        let technique = key.techniques[number as usize];
        technique == 0 || !is_grouped && known.is_quiet(technique, brick)
    };
    let make = || {
        let outside = segments.outside;
        let visible = visible_bricks(
            bricks,
            &key,
            (labelled, outside),
            labels.1,
            &is_nothing,
            making.control,
        )?;
        Skip::of_visible(bricks, &visible, making.control)
    };
    Ok(Some(making.find(&key, make)?))
}

/// For each of so many bricks whether a place in it may be in a segment of which something is shown there.
fn visible_bricks(
    [nx, ny, nz]: [usize; 3],
    key: &HiddenBricksKey,
    (labelled, outside): (&Labelled, u32),
    labels: &LabelNumbers,
    is_nothing: &(dyn Fn(u32, usize) -> bool + Sync),
    control: &Control,
) -> Result<Vec<bool>, Cancelled> {
    let label_dims = labelled.grid.dims();
    let shows = |brick: usize, low: [i64; 3], high: [i64; 3]| {
        let is_beyond = |axis: usize| low[axis] < 0 || high[axis] >= label_dims[axis] as i64;
        if !is_nothing(outside, brick) && (0..3).any(is_beyond) {
            return true;
        }
        let inside = |axis: usize| {
            let last = label_dims[axis] as i64 - 1;
            low[axis].clamp(0, last) as usize..high[axis].clamp(0, last) as usize + 1
        };
        let (xs, rows) = (inside(0), (inside(1), inside(2)));
        rows.1.into_iter().any(|z| {
            rows.0.clone().any(|y| {
                let first = label_dims[0] * (y + label_dims[1] * z);
                let row = first + xs.start..first + xs.end;
                match &labels.numbers {
                    LabelIds::U8(n) => any(&n[row], |n| !is_nothing(n, brick)),
                    LabelIds::U16(n) => any(&n[row], |n| !is_nothing(n, brick)),
                    LabelIds::U32(n) => any(&n[row], |n| !is_nothing(n, brick)),
                }
            })
        })
    };
    let mut visible = vec![false; nx * ny * nz];
    let slices = visible.chunks_mut(nx * ny).enumerate();
    cores::try_for_each(
        slices,
        || (),
        |(), (z, slice)| {
            control.check()?;
            for (i, visible) in slice.iter_mut().enumerate() {
                let (low, high) = around([i % nx, i / nx, z], &key.label_from_voxel, key.dims);
                *visible = shows(z * nx * ny + i, low, high);
            }
            Ok(())
        },
    )?;
    Ok(visible)
}

/// Whether one of the numbers of a row is such a number. Equal ones lie side by side.
fn any<T: Copy + PartialEq + Into<u32>>(row: &[T], is_such: impl Fn(u32) -> bool) -> bool {
    row.chunk_by(T::eq).any(|run| is_such(run[0].into()))
}

/// The label voxels that matter to a brick: those around the box that its cells make, a little enlarged, as positions
/// are rounded. The outermost bricks go on to the border of the volume.
pub fn around(
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
