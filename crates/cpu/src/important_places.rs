//! How important places are, by the values of a mask.

use crate::lanes::{Affine, F32s, Vec3s, each};
use crate::levels::{Level, vectorized};
use crate::library::clip_sample::in_box;
use crate::library::reconstruct::Values;
use strahl_scene::plan::{Plan, PlanImportance};

/// The importance volume of a Plan, in the voxel space of its first layer: the only one of whoever asks.
pub struct ImportantPlaces<'v, S: Level> {
    mask: &'v dyn Values<S>,
    /// Voxel space → the cube from −0.5 to 0.5 that holds the mask.
    unit_from_voxel: Affine,
    low: f32,
    high: f32,
}

impl<'v, S: Level> ImportantPlaces<'v, S> {
    /// Those of `plan`, if it has some.
    pub fn new(
        plan: &Plan,
        masks: &'v [Box<dyn Values<S> + 'v>],
    ) -> Option<ImportantPlaces<'v, S>> {
        let PlanImportance {
            mask,
            unit_from_world,
            low,
            high,
            ..
        } = plan.importance?;
        let world_from_voxel = plan.field().grid.world_from_voxel();
        Some(ImportantPlaces {
            mask: &*masks[mask],
            unit_from_voxel: Affine::new(unit_from_world * world_from_voxel),
            low,
            high,
        })
    }

    /// The importance of each `position` (voxel space), 0 to 1.
    #[inline(never)]
    pub fn at(&self, position: Vec3s<S>) -> F32s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let (zero, one) = (F32s::zero(), F32s::splat(1.0));
                let unit = self.unit_from_voxel.point(position);
                let last = self.mask.shape().last;
                // The cube is the extent, which reaches half a voxel beyond the voxel centers.
                let place = each!([0, 1, 2], |axis| {
                    (unit[axis] + F32s::splat(0.5)) * F32s::splat(last[axis] + 1.0)
                        - F32s::splat(0.5)
                });
                let value = self.mask.at(place);
                let share = (value - F32s::splat(self.low)).over(F32s::splat(self.high - self.low));
                let is_known = in_box(unit) & share.is_finite();
                is_known.select(share.max(zero).min(one), zero)
            },
        )
    }
}
