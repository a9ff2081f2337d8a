//! Slot clip_sample: which samples of a ray are dropped.

mod boxes;

use crate::lanes::{Affine, Mask, Vec3s};
use strahl_scene::plan::Plan;

/// The sample clips of a Plan, in voxel space.
pub struct SampleClips(Vec<boxes::Box>);

impl SampleClips {
    /// The clips of `plan`.
    pub fn new(plan: &Plan) -> SampleClips {
        let world_from_voxel = plan.volume.grid.world_from_voxel();
        let boxes = plan.sample_clips.iter().map(|clip| boxes::Box {
            unit_from_voxel: Affine::new(clip.unit_from_world * world_from_voxel),
            keep_inside: clip.keep_inside,
        });
        SampleClips(boxes.collect())
    }

    /// Where a sample at `position` (voxel space) is kept.
    #[inline(always)]
    pub fn keep(&self, position: Vec3s, mut kept: Mask) -> Mask {
        for clip in &self.0 {
            kept = kept & clip.keep(position);
        }
        kept
    }
}
