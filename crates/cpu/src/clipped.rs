//! Bricks that clips leave nothing of.

use crate::brick_number::EDGE;
use crate::making::Making;
use std::sync::Arc;
use strahl_scene::plan::{ClipShape, Composite, Plan, SampleClip, Sampling};
use strahl_scene::visibility::dropped;
use strahl_volume::bricks::{Bricks, BricksKey};
use strahl_volume::{ContentId, Error, Grid, Key, Volume};

/// Of each brick whether every sample inside is dropped.
#[derive(Clone)]
pub struct ClippedBricks {
    pub of: ClippedBricksKey,
    bricks: Arc<Option<Vec<bool>>>,
}

/// All that it depends on.
#[derive(Clone, PartialEq)]
pub struct ClippedBricksKey {
    grid: Grid,
    clips: Vec<SampleClip>,
    /// Of each clip, if it is one.
    masks: Vec<Option<ContentId>>,
}

impl Key for ClippedBricksKey {
    /// `None` if nothing is dropped.
    type Value = Option<Vec<bool>>;

    const NAME: &str = "clipped bricks";

    fn bytes(&self, value: &Option<Vec<bool>>) -> usize {
        self.clips.len() * size_of::<SampleClip>() + value.as_ref().map_or(0, Vec::len)
    }
}

impl ClippedBricks {
    /// Those of object number `object`, of bricks like those of its volume; `None` if nothing is dropped, or what lies
    /// between the samples of dropped bricks may be seen all the same. The Plan's masks are among `masks`.
    pub fn new(
        making: &Making,
        masks: &[Volume],
        bricks: &Bricks,
        plan: &Plan,
        object: usize,
    ) -> Result<Option<ClippedBricks>, Error> {
        let is_projection = matches!(
            plan.technique().composite,
            Composite::Mip | Composite::Minip
        );
        let is_of_points = match plan.sampling {
            Sampling::Regular | Sampling::ByOpacity { .. } => true,
            // Of the largest value of a ray.
            Sampling::Refine { .. } => is_projection,
            _ => false,
        };
        let of_object = plan.sample_clips.iter().filter(|clip| clip.cuts(object));
        let clips: Vec<SampleClip> = of_object.copied().collect();
        if clips.is_empty() || !is_of_points {
            return Ok(None);
        }
        let mask = |clip: &SampleClip| match clip.shape {
            ClipShape::Mask { mask, .. } => Some(masks[mask].id()),
            _ => None,
        };
        let of = ClippedBricksKey {
            grid: plan.field_of(object).grid,
            masks: clips.iter().map(mask).collect(),
            clips,
        };
        let found = making.find(&of, || {
            let mut of_masks = Vec::new();
            for mask in masks {
                let make = || Bricks::under(mask, EDGE, 0, making.control);
                of_masks.push(making.find(&BricksKey::new(mask, EDGE, 0), make)?);
            }
            let mask = |mask: usize| (&masks[mask], &*of_masks[mask]);
            let (dims, edge) = (bricks.dims(), bricks.edge());
            Ok::<_, Error>(dropped(plan, object, dims, edge, mask, making.control)?)
        })?;
        let is_any = found.is_some();
        Ok(is_any.then_some(ClippedBricks { of, bricks: found }))
    }

    /// Of each brick, x fastest.
    pub fn bricks(&self) -> &[bool] {
        self.bricks.as_deref().unwrap_or_default()
    }
}
