//! Which segment of a label volume rays are in.

use crate::lanes::{Affine, F32s, LANES, Vec3s, each, lanes};
use crate::levels::Level;
use crate::skip::Skip;
use std::sync::Arc;
use strahl_scene::plan::{GlobalRule, NumberedSegments, Plan};
use strahl_volume::{BorderCells, LabelIds, LabelNumbers};

/// In voxels: what rounding may move a place beyond the extent.
const ROUNDING: f32 = 0.01;

/// Where a place lies among the voxels around it.
struct Cell {
    first: [usize; 3],
    /// From the first voxel to the next along each axis, 0 to 1.
    share: [f32; 3],
}

impl Cell {
    /// Of its corners as trilinear interpolation weighs them, x fastest.
    fn weights(&self) -> [f32; 8] {
        std::array::from_fn(|corner| {
            let [x, y, z] = std::array::from_fn(|axis| match corner >> axis & 1 {
                0 => 1.0 - self.share[axis],
                _ => self.share[axis],
            });
            x * y * z
        })
    }
}

/// The segments of the layer, by the numbers that voxels have in place of ids.
pub struct SegmentNumbers<'n> {
    numbers: &'n LabelIds,
    borders: &'n BorderCells,
    dims: [usize; 3],
    label_from_voxel: Affine,
    segments: NumberedSegments,
    /// Where all segments are hidden, if that is known.
    pub skip: Option<Arc<Skip>>,
    /// How runs become a pixel.
    pub rule: GlobalRule,
    /// The largest importance of a segment.
    pub most_important: f32,
}

impl<'n> SegmentNumbers<'n> {
    /// Those of `plan`, if it has segments.
    pub fn new(
        plan: &Plan,
        labels: &'n LabelNumbers,
        skip: Option<Arc<Skip>>,
    ) -> Option<SegmentNumbers<'n>> {
        let labelled = plan.labelled()?;
        let segments = labelled.numbered(&labels.ids);
        let importances = segments.importances.iter();
        Some(SegmentNumbers {
            numbers: &labels.numbers,
            borders: &labels.borders,
            dims: labelled.grid.dims(),
            label_from_voxel: Affine::new(labelled.label_from_voxel(plan.field())),
            most_important: importances.fold(0.0, |most, own| most.max(*own)),
            segments,
            skip,
            rule: plan.global_rule,
        })
    }

    /// The number of the segment at each `position` (voxel space of the field), counted from 1: that whose voxels around it
    /// have the largest weight as trilinear interpolation counts, the first of equals. There are at most 2^24 − 2 segments,
    /// so that each number is exact.
    #[inline(always)]
    pub fn at<S: Level>(&self, position: Vec3s<S>) -> F32s<S> {
        let places = each!(self.label_from_voxel.point(position), |c| c.to_array());
        let number = |i: usize| match self.cell([places[0][i], places[1][i], places[2][i]]) {
            None => self.segments.outside,
            Some(cell) if !self.borders.has(cell.first) => self.number(cell.first),
            Some(cell) => self.heaviest(&cell),
        };
        let numbers: [u32; LANES] = lanes(number);
        F32s::from_array(lanes(|i| (numbers[i] + 1) as f32))
    }

    /// The weight that the segment with each of these numbers, counted from 1, has at each `position`, 0 to 1.
    #[inline(always)]
    pub fn membership<S: Level>(&self, position: Vec3s<S>, segment: F32s<S>) -> F32s<S> {
        let places = each!(self.label_from_voxel.point(position), |c| c.to_array());
        let segment = segment.to_array();
        let weight = |i: usize| {
            let is_here = |number: u32| (number + 1) as f32 == segment[i];
            match self.cell([places[0][i], places[1][i], places[2][i]]) {
                None => f32::from(u8::from(is_here(self.segments.outside))),
                Some(cell) if !self.borders.has(cell.first) => {
                    f32::from(u8::from(is_here(self.number(cell.first))))
                }
                Some(cell) => {
                    let (numbers, weights) = (self.numbers_around(&cell), cell.weights());
                    let of = numbers.into_iter().zip(weights);
                    of.map(|(n, weight)| if is_here(n) { weight } else { 0.0 })
                        .sum()
                }
            }
        };
        F32s::from_array(lanes(weight))
    }

    /// The cell around a place in voxels of the label volume; `None` beyond its extent.
    #[inline(always)]
    fn cell(&self, place: [f32; 3]) -> Option<Cell> {
        let (mut first, mut share) = ([0; 3], [0.0; 3]);
        for axis in 0..3 {
            let (place, end) = (place[axis], self.dims[axis] as f32 - 0.5);
            if !(-0.5 - ROUNDING..=end + ROUNDING).contains(&place) {
                return None;
            }
            let inside = place.clamp(0.0, (self.dims[axis] - 1) as f32);
            let floor = inside.floor();
            (first[axis], share[axis]) = (floor as usize, inside - floor);
        }
        Some(Cell { first, share })
    }

    #[inline(always)]
    fn number(&self, [x, y, z]: [usize; 3]) -> u32 {
        let index = x + self.dims[0] * (y + self.dims[1] * z);
        match self.numbers {
            LabelIds::U8(numbers) => numbers[index].into(),
            LabelIds::U16(numbers) => numbers[index].into(),
            LabelIds::U32(numbers) => numbers[index],
        }
    }

    fn numbers_around(&self, cell: &Cell) -> [u32; 8] {
        std::array::from_fn(|corner| {
            self.number(std::array::from_fn(|axis| {
                (cell.first[axis] + (corner >> axis & 1)).min(self.dims[axis] - 1)
            }))
        })
    }

    /// The number with the largest weight, the smallest of equals.
    #[inline(never)]
    fn heaviest(&self, cell: &Cell) -> u32 {
        let (numbers, weights) = (self.numbers_around(cell), cell.weights());
        let mut best = (0.0, u32::MAX);
        for number in numbers {
            let of = numbers.iter().zip(weights);
            let weight: f32 = of.map(|(n, w)| if *n == number { w } else { 0.0 }).sum();
            if weight > best.0 || (weight == best.0 && number < best.1) {
                best = (weight, number);
            }
        }
        best.1
    }

    /// What the runs of the segment with a number, counted from 1, are multiplied by.
    #[inline(always)]
    pub fn factors(&self, segment: f32) -> [f32; 4] {
        match (segment as usize).checked_sub(1) {
            Some(number) => self.segments.factors[number],
            None => [0.0; 4],
        }
    }

    /// The importance of the segment with a number, counted from 1.
    #[inline(always)]
    pub fn importance(&self, segment: f32) -> f32 {
        match (segment as usize).checked_sub(1) {
            Some(number) => self.segments.importances[number],
            None => 0.0,
        }
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
