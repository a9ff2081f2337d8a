//! Which segment of a label volume rays are in.

use crate::lanes::{Affine, F32s, LANES, Vec3s, each, lanes};
use crate::levels::Level;
use strahl_scene::plan::{Composite, NumberedSegments, Plan};
use strahl_volume::{LabelIds, LabelNumbers};

/// In voxels: what rounding may move a place beyond the extent.
const ROUNDING: f32 = 0.01;

/// The segments of the layer, by the numbers that voxels have in place of ids.
pub struct SegmentNumbers<'n> {
    numbers: &'n LabelIds,
    dims: [usize; 3],
    label_from_voxel: Affine,
    segments: NumberedSegments,
    /// A ray ends when less of what is behind would come through.
    pub stop_at_transmittance: f32,
}

impl<'n> SegmentNumbers<'n> {
    /// Those of `plan`, if it has segments.
    pub fn new(plan: &Plan, labels: &'n LabelNumbers) -> Option<SegmentNumbers<'n>> {
        let labelled = plan.labelled()?;
        let stop_at_transmittance = match plan.global_composite {
            Composite::EmissionAbsorption {
                stop_at_transmittance,
            } => stop_at_transmittance,
            _ => 0.0,
        };
        Some(SegmentNumbers {
            numbers: &labels.numbers,
            dims: labelled.grid.dims(),
            label_from_voxel: Affine::new(labelled.label_from_voxel(plan.field())),
            segments: labelled.numbered(&labels.ids),
            stop_at_transmittance,
        })
    }

    /// The number of the segment at each `position` (voxel space of the field), counted from 1: that of the nearest
    /// voxel. There are at most 2^24 − 2 segments, so that each number is exact.
    #[inline(always)]
    pub fn at<S: Level>(&self, position: Vec3s<S>) -> F32s<S> {
        let place = self.label_from_voxel.point(position);
        let half = F32s::splat(0.5);
        let places = each!(place, |c| c.to_array());
        let voxels = each!(place, |c| (c + half).floor().to_i32s().to_array());
        let number = |i: usize| {
            let mut index = 0;
            for axis in [2, 1, 0] {
                let (place, end) = (places[axis][i], self.dims[axis] as f32 - 0.5);
                if !(-0.5 - ROUNDING..=end + ROUNDING).contains(&place) {
                    return self.segments.outside;
                }
                let voxel = (voxels[axis][i].max(0) as usize).min(self.dims[axis] - 1);
                index = index * self.dims[axis] + voxel;
            }
            match self.numbers {
                LabelIds::U8(numbers) => numbers[index].into(),
                LabelIds::U16(numbers) => numbers[index].into(),
                LabelIds::U32(numbers) => numbers[index],
            }
        };
        let numbers: [u32; LANES] = lanes(number);
        F32s::from_array(lanes(|i| (numbers[i] + 1) as f32))
    }

    /// The technique of the segment with a number, both counted from 1; 0 if it is hidden or there is none.
    #[inline(always)]
    pub fn technique(&self, segment: f32) -> f32 {
        match (segment as usize).checked_sub(1) {
            Some(number) => self.segments.techniques[number] as f32,
            None => 0.0,
        }
    }
}
