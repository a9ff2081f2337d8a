//! Which segment of a label volume rays are in.

use crate::lanes::{Affine, F32s, LANES, Mask, Vec3s, each};
use crate::levels::{Level, vectorized};
use crate::unseen_segments::UnseenSegments;
use std::sync::Arc;
use strahl_scene::plan::{GlobalRule, GradientMethod, NumberedSegments, Plan, SegmentGroup};
use strahl_volume::{BorderCells, LabelIds, LabelNumbers};

/// In voxels: what rounding may move a place beyond the extent.
const ROUNDING: f32 = 0.01;

/// Where a place lies among the voxels around it.
#[derive(Clone, Copy)]
struct Cell {
    first: [usize; 3],
    /// From the first voxel to the next along each axis, 0 to 1.
    share: [f32; 3],
}

impl Cell {
    /// Of its corners as trilinear interpolation weighs them, x fastest.
    #[inline(always)]
    fn weights(&self) -> [f32; 8] {
        let [x, y, z] = self.share.map(|share| [1.0 - share, share]);
        let mut weights = [0.0; 8];
        for (corner, weight) in weights.iter_mut().enumerate() {
            *weight = x[corner & 1] * y[corner >> 1 & 1] * z[corner >> 2];
        }
        weights
    }
}

/// The segments of the layer, by the numbers that voxels have in place of ids.
pub struct SegmentNumbers<'n> {
    numbers: &'n LabelIds,
    borders: &'n BorderCells,
    dims: [usize; 3],
    label_from_voxel: Affine,
    /// Whether the labels lie on the voxels of the field.
    is_grid_of_field: bool,
    segments: NumberedSegments,
    /// Where they show nothing, if that is known.
    pub unseen: Option<Arc<UnseenSegments>>,
    /// How runs become a pixel.
    pub rule: GlobalRule,
    /// Those of the segments.
    pub groups: Vec<SegmentGroup>,
    /// What full importance of a place is worth to its run.
    pub gain_of_places: f32,
    /// The largest importance of a run.
    pub most_important: f32,
}

impl<'n> SegmentNumbers<'n> {
    /// Those of `plan`, if it has segments.
    pub fn new(
        plan: &Plan,
        labels: &'n LabelNumbers,
        unseen: Option<Arc<UnseenSegments>>,
    ) -> Option<SegmentNumbers<'n>> {
        let labelled = plan.labelled()?;
        let segments = labelled.numbered(&labels.ids);
        let of_groups = labelled.groups.iter().map(|group| group.importance);
        let importances = segments.importances.iter().copied().chain(of_groups);
        let places = plan.importance.filter(|_| plan.weighs_runs());
        let gain_of_places = places.map_or(0.0, |places| places.gain_of_runs);
        Some(SegmentNumbers {
            numbers: &labels.numbers,
            borders: &labels.borders,
            dims: labelled.grid.dims(),
            is_grid_of_field: labelled.grid == plan.field().grid,
            label_from_voxel: Affine::new(labelled.label_from_voxel(plan.field())),
            gain_of_places,
            most_important: importances.fold(0.0, f32::max) + gain_of_places,
            segments,
            unseen,
            rule: plan.global_rule,
            groups: labelled.groups.clone(),
        })
    }

    /// The number of the segment at each `position` (voxel space of the field), counted from 1: that whose voxels around it
    /// have the largest weight as trilinear interpolation counts, the first of equals. There are at most 2^24 − 2 segments,
    /// so that each number is exact.
    #[inline(always)]
    pub fn at<S: Level>(&self, position: Vec3s<S>) -> F32s<S> {
        let cells = self.cells(self.label_from_voxel.point(position));
        let mut found = [0.0; LANES];
        for (found, cell) in found.iter_mut().zip(&cells) {
            let number = match cell {
                None => self.segments.outside,
                Some(cell) if !self.borders.has(cell.first) => self.number(cell.first),
                Some(cell) => self.heaviest(cell),
            };
            *found = (number + 1) as f32;
        }
        F32s::from_array(found)
    }

    /// The gradient, in voxel space of the field, of the weight that the segment with each of these numbers, counted from 1,
    /// has at each `position`, where `asked` and no tap lies beyond the border, and where that is; `None` for estimates and
    /// grids that have no way of their own.
    #[inline(always)]
    pub fn gradient<S: Level>(
        &self,
        method: GradientMethod,
        position: Vec3s<S>,
        segment: F32s<S>,
        asked: Mask<S>,
    ) -> Option<(Vec3s<S>, Mask<S>)> {
        let is_sobel = match method {
            GradientMethod::Central => false,
            GradientMethod::Sobel => true,
            _ => return None,
        };
        if !self.is_grid_of_field {
            return None;
        }
        let mut within = asked;
        for (place, dim) in position.iter().zip(self.dims) {
            let end = F32s::splat(dim as f32 - 1.5);
            within = within & F32s::splat(0.5).le(*place) & place.le(end);
        }
        let asked = within;
        let places = each!(position, |c| c.to_array());
        let (segment, asked) = (
            segment.to_array(),
            asked.select(F32s::splat(1.0), F32s::zero()).to_array(),
        );
        let mut gradients = [[0.0; LANES]; 3];
        for i in 0..LANES {
            // Those that nobody is in have number 0.
            let Some(number) = (segment[i] as u32)
                .checked_sub(1)
                .filter(|_| asked[i] > 0.0)
            else {
                continue;
            };
            let place = [places[0][i], places[1][i], places[2][i]];
            let gradient = self.gradient_at(is_sobel, place, number);
            for (of_axis, of_lane) in gradients.iter_mut().zip(gradient) {
                of_axis[i] = of_lane;
            }
        }
        let gradients = each!([0, 1, 2], |axis| F32s::from_array(gradients[axis]));
        Some((gradients, within))
    }

    /// Of the trilinear weight at a place in voxels, by central differences or Sobel's kernel over one voxel to each side.
    /// Voxels are 0 or 1, and all taps have the same shares: the kernels are four numbers wide along each axis.
    #[inline(never)]
    fn gradient_at(&self, is_sobel: bool, place: [f32; 3], number: u32) -> [f32; 3] {
        let (mut slopes, mut sides) = ([[0.0; 4]; 3], [[0.0; 4]; 3]);
        let mut low = [0i64; 3];
        for axis in 0..3 {
            let floor = place[axis].floor();
            let f = place[axis] - floor;
            low[axis] = floor as i64 - 1;
            slopes[axis] = [f - 1.0, -f, 1.0 - f, f];
            sides[axis] = match is_sobel {
                true => [1.0 - f, 2.0 - f, 1.0 + f, f],
                false => [0.0, 1.0 - f, f, 0.0],
            };
        }
        let mut sum = [0.0; 3];
        for z in 0..4 {
            for y in 0..4 {
                let (mut slope, mut side) = (0.0, 0.0);
                for x in 0..4 {
                    let voxel = [low[0] + x as i64, low[1] + y as i64, low[2] + z as i64];
                    if self.number_around(voxel) == number {
                        slope += slopes[0][x];
                        side += sides[0][x];
                    }
                }
                sum[0] += slope * sides[1][y] * sides[2][z];
                sum[1] += side * slopes[1][y] * sides[2][z];
                sum[2] += side * sides[1][y] * slopes[2][z];
            }
        }
        sum.map(|sum| sum * if is_sobel { 1.0 / 32.0 } else { 0.5 })
    }

    /// The number of a voxel, at the border that of the nearest one.
    #[inline(always)]
    fn number_around(&self, voxel: [i64; 3]) -> u32 {
        let mut inside = [0; 3];
        for axis in 0..3 {
            inside[axis] = voxel[axis].clamp(0, self.dims[axis] as i64 - 1) as usize;
        }
        self.number(inside)
    }

    /// The weight that the segment with each of these numbers, counted from 1, has at each `position`, 0 to 1.
    #[inline(never)]
    pub fn membership<S: Level>(&self, position: Vec3s<S>, segment: F32s<S>) -> F32s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let cells = self.cells(self.label_from_voxel.point(position));
                let segment = segment.to_array();
                let mut found = [0.0; LANES];
                for i in 0..LANES {
                    let is_here = |number: u32| (number + 1) as f32 == segment[i];
                    let is_whole = match &cells[i] {
                        None => is_here(self.segments.outside),
                        Some(cell) if !self.borders.has(cell.first) => {
                            is_here(self.number(cell.first))
                        }
                        Some(cell) => {
                            let (numbers, weights) = (self.numbers_around(cell), cell.weights());
                            for (number, weight) in numbers.into_iter().zip(weights) {
                                found[i] += if is_here(number) { weight } else { 0.0 };
                            }
                            continue;
                        }
                    };
                    found[i] = f32::from(u8::from(is_whole));
                }
                F32s::from_array(found)
            },
        )
    }

    /// The cells around places in voxels of the label volume; `None` beyond its extent.
    #[inline(always)]
    fn cells<S: Level>(&self, place: Vec3s<S>) -> [Option<Cell>; LANES] {
        let (zero, one) = (F32s::zero(), F32s::splat(1.0));
        let mut is_inside = !Mask::none();
        for (place, dim) in place.iter().zip(self.dims) {
            let end = dim as f32 - 0.5;
            let [low, high] = [-0.5 - ROUNDING, end + ROUNDING].map(F32s::splat);
            is_inside = is_inside & low.le(*place) & place.le(high);
        }
        let is_inside = is_inside.select(one, zero).to_array();
        let last = self.dims.map(|n| (n - 1) as f32);
        let inside = each!([0, 1, 2], |axis| {
            place[axis].max(zero).min(F32s::splat(last[axis]))
        });
        let floor = each!(inside, |c| c.floor());
        let first = each!(floor, |c| c.to_i32s().to_array());
        let share = each!([0, 1, 2], |axis| (inside[axis] - floor[axis]).to_array());
        let mut cells = [None; LANES];
        for (i, cell) in cells.iter_mut().enumerate() {
            if is_inside[i] > 0.0 {
                *cell = Some(Cell {
                    first: [first[0][i], first[1][i], first[2][i]].map(|n| n as usize),
                    share: [share[0][i], share[1][i], share[2][i]],
                });
            }
        }
        cells
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

    #[inline(always)]
    fn numbers_around(&self, cell: &Cell) -> [u32; 8] {
        let [x, y, z]: [[usize; 2]; 3] = [0, 1, 2].map(|axis| {
            let first = cell.first[axis];
            [first, (first + 1).min(self.dims[axis] - 1)]
        });
        let mut numbers = [0; 8];
        for (corner, number) in numbers.iter_mut().enumerate() {
            *number = self.number([x[corner & 1], y[corner >> 1 & 1], z[corner >> 2]]);
        }
        numbers
    }

    /// The number with the largest weight, the smallest of equals.
    #[inline(never)]
    fn heaviest(&self, cell: &Cell) -> u32 {
        let (numbers, weights) = (self.numbers_around(cell), cell.weights());
        // Mostly there are two, whose weights add up in the same order.
        let first = numbers[0];
        let second = numbers.into_iter().find(|&number| number != first);
        let second = second.unwrap_or(first);
        let (mut of_first, mut of_second, mut are_two) = (0.0, 0.0, true);
        for (number, weight) in numbers.into_iter().zip(weights) {
            let (is_first, is_second) = (number == first, number == second);
            of_first += if is_first { weight } else { 0.0 };
            of_second += if is_second { weight } else { 0.0 };
            are_two &= is_first | is_second;
        }
        if are_two {
            return match of_first.total_cmp(&of_second) {
                std::cmp::Ordering::Greater => first,
                std::cmp::Ordering::Less => second,
                std::cmp::Ordering::Equal => first.min(second),
            };
        }
        let (mut heaviest, mut largest) = (u32::MAX, 0.0);
        for number in numbers {
            let mut weight = 0.0;
            for (other, of_other) in numbers.iter().zip(weights) {
                weight += if *other == number { of_other } else { 0.0 };
            }
            if weight > largest || (weight == largest && number < heaviest) {
                (heaviest, largest) = (number, weight);
            }
        }
        heaviest
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

    /// The group of the segment with a number, both counted from 1; 0 without.
    #[inline(always)]
    pub fn group(&self, segment: f32) -> f32 {
        match (segment as usize).checked_sub(1) {
            Some(number) => self.segments.groups[number] as f32,
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
