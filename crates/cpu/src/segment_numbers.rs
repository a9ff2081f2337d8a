//! Which segment of a label volume rays are in.

use crate::label_bricks::{Corners, LabelBricks};
use crate::lanes::{Affine, F32s, I32s, LANES, Mask, Vec3s, each, lanes};
use crate::levels::{Level, Portable, vectorized};
use crate::library::fetch::Shape;
use crate::library::gradient::above_rounding;
use crate::unseen_segments::UnseenSegments;
use std::sync::Arc;
use strahl_scene::plan::{GlobalRule, GradientMethod, NumberedSegments, Plan, SegmentGroup};
use strahl_volume::{LabelIds, LabelNumbers};

/// In voxels: what rounding may move a place beyond the extent.
const ROUNDING: f32 = 0.01;

/// Cells of the label volume that places lie in.
#[derive(Clone, Copy)]
struct Cells<S: Level> {
    cell: [I32s<S>; 3],
    /// From the first voxel to the next along each axis, 0 to 1.
    share: Vec3s<S>,
    /// Which places lie within its extent.
    is_inside: Mask<S>,
}

impl<S: Level> Cells<S> {
    /// Of the corners as trilinear interpolation weighs them, x fastest.
    #[inline(always)]
    fn weights(&self) -> [F32s<S>; 8] {
        let one = F32s::splat(1.0);
        let [x, y, z] = each!(self.share, |share| [one - share, share]);
        let [a, b, c, d] = [x[0] * y[0], x[1] * y[0], x[0] * y[1], x[1] * y[1]];
        [
            a * z[0],
            b * z[0],
            c * z[0],
            d * z[0],
            a * z[1],
            b * z[1],
            c * z[1],
            d * z[1],
        ]
    }
}

/// The segments of the layer, by the numbers that voxels have in place of ids.
pub struct SegmentNumbers<'n> {
    numbers: &'n LabelIds,
    bricks: &'n LabelBricks,
    shape: Shape,
    dims: [usize; 3],
    label_from_voxel: Affine,
    /// Whether the labels lie on the voxels of the field.
    is_grid_of_field: bool,
    segments: NumberedSegments,
    number_of_ids: usize,
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
        bricks: &'n LabelBricks,
        unseen: Option<Arc<UnseenSegments>>,
    ) -> Option<SegmentNumbers<'n>> {
        let labeled = plan.labeled()?;
        let segments = labeled.numbered(&labels.ids);
        let of_groups = labeled.groups.iter().map(|group| group.importance);
        let importances = segments.importances.iter().copied().chain(of_groups);
        let places = plan.importance.filter(|_| plan.weighs_runs());
        let gain_of_places = places.map_or(0.0, |places| places.gain_of_runs);
        Some(SegmentNumbers {
            numbers: &labels.numbers,
            bricks,
            shape: Shape::new(&labeled.grid),
            dims: labeled.grid.dims(),
            is_grid_of_field: labeled.grid == plan.field().grid,
            label_from_voxel: Affine::new(labeled.label_from_voxel(plan.field())),
            number_of_ids: labels.ids.len(),
            gain_of_places,
            most_important: importances.fold(0.0, f32::max) + gain_of_places,
            segments,
            unseen,
            rule: plan.global_rule,
            groups: labeled.groups.clone(),
        })
    }

    /// The number of the segment at each `position` (voxel space of the field), counted from 1: that whose voxels around it
    /// have the largest weight as trilinear interpolation counts, the first of equals; anything where not `asked`. There are
    /// at most 2^24 − 2 segments, so that each number is exact.
    #[inline(always)]
    pub fn at<S: Level>(&self, position: Vec3s<S>, asked: Mask<S>) -> F32s<S> {
        self.of_cells(&self.cells(position), asked)
    }

    /// The same for positions in the `cell`s of the field, as far behind their first voxels as `share` says.
    #[inline(always)]
    pub fn at_points<S: Level>(
        &self,
        position: Vec3s<S>,
        (cell, share): ([I32s<S>; 3], Vec3s<S>),
        asked: Mask<S>,
    ) -> F32s<S> {
        if !self.is_grid_of_field {
            return self.at(position, asked);
        }
        let cells = Cells {
            cell,
            share,
            is_inside: !Mask::none(),
        };
        self.of_cells(&cells, asked)
    }

    #[inline(always)]
    fn of_cells<S: Level>(&self, cells: &Cells<S>, asked: Mask<S>) -> F32s<S> {
        let words = self.bricks.words(cells.cell);
        let is_mixed = asked & cells.is_inside & words.lt(I32s::splat(0));
        let mut found = words.to_f32s();
        if is_mixed.any() {
            found = is_mixed.select(self.heaviest(cells, words, is_mixed), found);
        }
        let outside = F32s::splat((self.segments.outside + 1) as f32);
        cells.is_inside.select(found, outside)
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
        // Weights are at most 1.
        let gradients = above_rounding(gradients, F32s::splat(1.0));
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
                let (zero, one) = (F32s::zero(), F32s::splat(1.0));
                let cells = self.cells(position);
                let words = self.bricks.words(cells.cell);
                let outside = F32s::splat((self.segments.outside + 1) as f32);
                let whole = cells.is_inside.select(words.to_f32s(), outside);
                let mut found = whole.eq(segment).select(one, zero);
                let is_mixed = cells.is_inside & words.lt(I32s::splat(0));
                if (is_mixed & LabelBricks::is_read(words)).any() {
                    let corners = self.bricks.corners(cells.cell, words);
                    let mut sum = zero;
                    for (number, weight) in corners.numbers().into_iter().zip(cells.weights()) {
                        let number = self.bricks.meant(&corners, number);
                        sum += number.eq(segment).select(weight, zero);
                    }
                    found = is_mixed.select(sum, found);
                }
                let of_many = is_mixed & !LabelBricks::is_read(words);
                if of_many.any() {
                    let weight = |numbers: [u32; 8], weights: [f32; 8], lane: usize| {
                        let own = numbers.into_iter().zip(weights);
                        let own =
                            own.filter(|(number, _)| (number + 1) as f32 == segment.lane(lane));
                        own.map(|(_, weight)| weight).sum()
                    };
                    found = of_many.select(self.one_by_one(&cells, of_many, weight), found);
                }
                found
            },
        )
    }

    /// The cells of the label volume around each `position`.
    #[inline(always)]
    fn cells<S: Level>(&self, position: Vec3s<S>) -> Cells<S> {
        let place = match self.is_grid_of_field {
            true => position,
            false => self.label_from_voxel.point(position),
        };
        let mut is_inside = !Mask::none();
        for (place, last) in place.iter().zip(self.shape.last) {
            let [low, high] = [-0.5 - ROUNDING, last + 0.5 + ROUNDING].map(F32s::splat);
            is_inside = is_inside & low.le(*place) & place.le(high);
        }
        let clamped = self.shape.clamp(place);
        let cell = self.shape.cell(clamped);
        Cells {
            cell,
            share: each!([0, 1, 2], |axis| clamped[axis] - cell[axis].to_f32s()),
            is_inside,
        }
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

    /// The number, counted from 1, with the largest weight, the smallest of equals, where `asked`; the bricks are not of one
    /// number and have these `words`.
    #[inline(never)]
    fn heaviest<S: Level>(&self, cells: &Cells<S>, words: I32s<S>, asked: Mask<S>) -> F32s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let corners = self.bricks.corners(cells.cell, words);
                let weights = cells.weights();
                let is_read = LabelBricks::is_read(words);
                let mut heavier = is_second_heavier(&corners, &weights);
                let of_more = asked & is_read & LabelBricks::has_more_than_two(words);
                if of_more.any() {
                    let numbers = corners.numbers();
                    let (of_two, are_two) = heavier_of_two(&numbers, &weights);
                    heavier = of_more.select(of_two, heavier);
                    let of_more = of_more & !are_two;
                    if of_more.any() {
                        heavier = of_more.select(heaviest_of_eight(&numbers, &weights), heavier);
                    }
                }
                let found = self.bricks.meant(&corners, heavier);
                let of_many = asked & !is_read;
                if !of_many.any() {
                    return found;
                }
                let heaviest = |numbers: [u32; 8], weights: [f32; 8], _| {
                    let numbers =
                        numbers.map(|number| F32s::<Portable>::splat((number + 1) as f32));
                    heaviest_of_eight(&numbers, &weights.map(F32s::splat)).lane(0)
                };
                of_many.select(self.one_by_one(cells, of_many, heaviest), found)
            },
        )
    }

    /// What `of` makes of the numbers, counted from 0, and the weights of the voxels around a place, and of its lane, where
    /// `asked`: for bricks of very many numbers.
    #[cold]
    #[inline(never)]
    fn one_by_one<S: Level>(
        &self,
        cells: &Cells<S>,
        asked: Mask<S>,
        of: impl Fn([u32; 8], [f32; 8], usize) -> f32,
    ) -> F32s<S> {
        let asked = asked.select(F32s::splat(1.0), F32s::zero());
        let weights = cells.weights();
        let found = lanes(|lane| {
            if asked.lane(lane) == 0.0 {
                return 0.0;
            }
            let first = [0, 1, 2].map(|axis: usize| cells.cell[axis].lane(lane) as usize);
            let numbers = [0, 1, 2, 3, 4, 5, 6, 7].map(|corner: usize| {
                let at =
                    |axis: usize| (first[axis] + (corner >> axis & 1)).min(self.dims[axis] - 1);
                self.number([at(0), at(1), at(2)])
            });
            of(
                numbers,
                [0, 1, 2, 3, 4, 5, 6, 7].map(|i: usize| weights[i].lane(lane)),
                lane,
            )
        });
        F32s::from_array(found)
    }

    /// How each is drawn.
    pub fn looks(&self) -> &NumberedSegments {
        &self.segments
    }

    /// Technique and factors of the segments that places can be in: those beyond the extent of the labels only where these
    /// do not lie on the voxels of the field.
    pub fn drawn(&self) -> impl Iterator<Item = (&u32, &[f32; 4])> + Clone {
        let all = self.segments.techniques.iter().zip(&self.segments.factors);
        let number = match self.is_grid_of_field {
            true => self.number_of_ids,
            false => self.segments.techniques.len(),
        };
        all.take(number)
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

/// Of two numbers, 0 and 1, the heavier one, the smaller of equals. Weights add up in the order of the corners.
#[inline(always)]
fn is_second_heavier<S: Level>(corners: &Corners<S>, weights: &[F32s<S>; 8]) -> F32s<S> {
    let (zero, one) = (F32s::zero(), F32s::splat(1.0));
    let (mut of_first, mut of_second) = (zero, zero);
    for (is_second, weight) in corners.are_second().into_iter().zip(weights) {
        of_first += is_second.select(zero, *weight);
        of_second += is_second.select(*weight, zero);
    }
    of_first.lt(of_second).select(one, zero)
}

/// Of the numbers of eight corners the heavier one, the smaller of equals, and where there are two at most. Weights add
/// up in the order of the corners.
#[inline(always)]
fn heavier_of_two<S: Level>(numbers: &[F32s<S>; 8], weights: &[F32s<S>; 8]) -> (F32s<S>, Mask<S>) {
    let zero = F32s::zero();
    let first = numbers[0];
    let mut second = first;
    for number in numbers {
        second = first.eq(*number).select(second, *number);
    }
    let (mut of_first, mut of_second, mut are_two) = (zero, zero, !Mask::none());
    for (number, weight) in numbers.iter().zip(weights) {
        let (is_first, is_second) = (first.eq(*number), second.eq(*number));
        of_first += is_first.select(*weight, zero);
        of_second += is_second.select(*weight, zero);
        are_two = are_two & (is_first | is_second);
    }
    let lighter = of_first.lt(of_second) | (of_first.eq(of_second) & second.lt(first));
    (lighter.select(second, first), are_two)
}

/// Of the numbers of eight corners the heaviest one, the smallest of equals.
#[inline(always)]
fn heaviest_of_eight<S: Level>(numbers: &[F32s<S>; 8], weights: &[F32s<S>; 8]) -> F32s<S> {
    let zero = F32s::zero();
    let (mut heaviest, mut largest) = (numbers[0], zero);
    for number in numbers {
        let mut weight = zero;
        for (other, of_other) in numbers.iter().zip(weights) {
            weight += number.eq(*other).select(*of_other, zero);
        }
        let better = largest.lt(weight) | (weight.eq(largest) & number.lt(heaviest));
        heaviest = better.select(*number, heaviest);
        largest = better.select(weight, largest);
    }
    heaviest
}
