//! Bricks that clips leave nothing of.

use crate::brick_number::EDGE;
use crate::kept::Kept;
use std::sync::{Arc, OnceLock};
use strahl_scene::plan::{Composite, Plan, SampleClip, Sampling};
use strahl_scene::visibility::dropped;
use strahl_volume::bricks::Bricks;
use strahl_volume::{Grid, Volume};

/// Of each brick whether every sample inside is dropped.
#[derive(Clone)]
pub struct Clipped(Arc<Option<Vec<bool>>>);

/// Only what was found once, for the same question, is the same.
impl PartialEq for Clipped {
    fn eq(&self, other: &Clipped) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// What was found for the Plans drawn last.
pub type RecentClipped = Kept<Asked, Option<Vec<bool>>>;

/// All that it depends on.
#[derive(PartialEq)]
pub struct Asked {
    grid: Grid,
    clips: Vec<SampleClip>,
}

impl Clipped {
    /// Those of object number `object`, of bricks like those of its volume; `None` if nothing is dropped, or what lies
    /// between the samples of dropped bricks may be seen all the same.
    pub fn new(
        recent: &RecentClipped,
        masks: &Masks,
        bricks: &Bricks,
        plan: &Plan,
        object: usize,
    ) -> Option<Clipped> {
        let is_projection = matches!(
            plan.technique().composite,
            Composite::Mip | Composite::MinIp
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
            return None;
        }
        let asked = Asked {
            grid: plan.field_of(object).grid,
            clips,
        };
        let found = recent.find(asked, 2 * plan.layers.len(), |_| {
            let mask = |mask| masks.get(mask);
            Some(dropped(plan, object, bricks.dims(), bricks.edge(), mask))
        })?;
        found.is_some().then_some(Clipped(found))
    }

    /// Of each brick, x fastest.
    pub fn bricks(&self) -> &[bool] {
        self.0.as_deref().unwrap_or_default()
    }
}

/// Masks with their bricks, which are made when a Plan first asks for them.
pub struct Masks<'v>(Vec<(&'v Volume, OnceLock<Bricks>)>);

impl<'v> Masks<'v> {
    pub fn new(masks: &[&'v Volume]) -> Masks<'v> {
        Masks(masks.iter().map(|mask| (*mask, OnceLock::new())).collect())
    }

    fn get(&self, mask: usize) -> (&Volume, &Bricks) {
        let (volume, bricks) = &self.0[mask];
        let bricks = bricks.get_or_init(|| Bricks::with_edge(volume, EDGE));
        (volume, bricks)
    }
}
