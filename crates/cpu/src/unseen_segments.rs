//! Which bricks of a volume show nothing of the segments in them.

use crate::making::Making;
use crate::segments_of_bricks::SegmentsOfBricksKey;
use crate::skip::Skip;
use crate::technique_bricks::TechniqueBricks;
use std::collections::BTreeMap;
use std::sync::Arc;
use strahl_scene::plan::Plan;
use strahl_scene::visibility::ContributionKey;
use strahl_volume::{Cancelled, ContentId, Control, Key, LabelNumbers};

/// Where a ray need not look at segments.
pub struct UnseenSegments {
    /// Where no segment shows anything. Rays that have seen something of a run have to look whether it ends there.
    pub everywhere: Option<Skip>,
    /// Where all places lie in one segment, which shows nothing: for all rays, as soon as they are in that segment.
    pub in_one: Option<Skip>,
}

/// Key of the bricks in which segments show nothing.
#[derive(Clone, Debug, PartialEq)]
struct UnseenSegmentsKey {
    segments: SegmentsOfBricksKey,
    /// By the numbers of the segments, counted from 1; 0 where they are hidden.
    techniques: Vec<u32>,
    contributions: Vec<ContributionKey>,
    is_grouped: bool,
}

impl Key for UnseenSegmentsKey {
    type Value = UnseenSegments;

    const NAME: &str = "bricks of unseen segments";

    fn bytes(&self, value: &UnseenSegments) -> usize {
        let tables = self.contributions.iter().map(ContributionKey::table_bytes);
        let skips = [&value.everywhere, &value.in_one].into_iter().flatten();
        size_of_val(&self.techniques[..])
            + tables.sum::<usize>()
            + skips.map(Skip::bytes).sum::<usize>()
    }
}

/// What need not be looked at of the segments of `plan`, of whose techniques `known` tells where they show nothing; `None`
/// where nothing can be left out.
pub fn unseen_segments(
    making: &Making,
    plan: &Plan,
    known: &TechniqueBricks,
    (id, labels): (ContentId, &LabelNumbers),
) -> Result<Option<Arc<UnseenSegments>>, Cancelled> {
    let Some(labeled) = plan.labeled() else {
        return Ok(None);
    };
    let numbered = labeled.numbered(&labels.ids);
    let Some(segments) = SegmentsOfBricksKey::new(plan, id, numbered.outside) else {
        return Ok(None);
    };
    // Words are gathered at 32-bit offsets.
    let fits = segments.bricks().iter().product::<usize>() <= i32::MAX as usize / 8;
    let is_any = numbered.techniques.contains(&0) || !known.keys.is_empty();
    if !is_any || !fits {
        return Ok(None);
    }
    let key = UnseenSegmentsKey {
        segments,
        techniques: numbered.techniques,
        contributions: known.keys.clone(),
        is_grouped: !labeled.groups.is_empty(),
    };
    Ok(Some(making.find(&key, || key.make(making, known, labels))?))
}

impl UnseenSegmentsKey {
    fn make(
        &self,
        making: &Making,
        known: &TechniqueBricks,
        labels: &LabelNumbers,
    ) -> Result<UnseenSegments, Cancelled> {
        let (dims, control) = (self.segments.bricks(), making.control);
        let of_bricks = self.segments.find(making, labels)?;
        let is_quiet =
            |number: u32, brick: usize| known.is_quiet(self.techniques[number as usize], brick);
        // A group ends where another segment is met, so only hidden ones can be passed without looking.
        let is_unseen = |number: u32, brick: usize| {
            let is_hidden = self.techniques[number as usize] == 0;
            is_hidden || !self.is_grouped && is_quiet(number, brick)
        };
        let (mut visible, mut idle) = (Vec::new(), Vec::new());
        for (brick, numbers) in of_bricks.all().enumerate() {
            visible.push(!numbers.iter().all(|&number| is_unseen(number, brick)));
            idle.push(match *numbers {
                [one] if is_quiet(one, brick) => Some(one),
                _ => None,
            });
        }
        let is_any = visible.contains(&false);
        let everywhere = is_any.then(|| Skip::of_visible(dims, &visible, control));
        Ok(UnseenSegments {
            everywhere: everywhere.transpose()?,
            in_one: in_one(dims, &idle, control)?,
        })
    }
}

/// What can be left out of the bricks of one segment, which `idle` tells of each brick: cubes of bricks of the segment
/// that has the most, and the others one by one, as the next may be of another segment.
fn in_one(
    dims: [usize; 3],
    idle: &[Option<u32>],
    control: &Control,
) -> Result<Option<Skip>, Cancelled> {
    let mut bricks = BTreeMap::<u32, usize>::new();
    for segment in idle.iter().flatten() {
        *bricks.entry(*segment).or_default() += 1;
    }
    let Some((&most, _)) = bricks.iter().max_by_key(|(_, bricks)| **bricks) else {
        return Ok(None);
    };
    let visible: Vec<bool> = idle.iter().map(|segment| *segment != Some(most)).collect();
    let single: Vec<bool> = idle.iter().map(Option::is_some).collect();
    Skip::of_visible_and_single(dims, &visible, &single, control).map(Some)
}
