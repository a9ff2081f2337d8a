//! Leaving out lattice points that cannot change a pixel.
//!
//! Only whole lattice points are left out, and only those whose single-precision position falls
//! into a brick that provably gives nothing: pictures have the same bytes with skipping and without.

use crate::brick_number::{EDGE, SHIFT, brick_number, brick_number_of};
use crate::clipped::{ClippedBricks, ClippedBricksKey};
use crate::lanes::{F32s, I32s, LANES, Vec3s, each, words_inside};
use crate::levels::Level;
use crate::library::fetch::Shape;
use crate::line::{Line, points_to_face};
use crate::making::Making;
use std::sync::Arc;
use strahl_scene::plan::{Composite, Plan};
use strahl_scene::visibility::{Contribution, ContributionKey};
use strahl_volume::bricks::Bricks;
use strahl_volume::{Cancelled, Control, Key, cores};

/// What is known of the bricks of a volume under a Plan.
pub struct Skip {
    /// Number of bricks along each axis.
    dims: [i32; 3],
    bricks: Arc<Knowledge>,
}

enum Knowledge {
    /// Nothing can be left out.
    Nothing,
    /// For each octant of directions, and each brick: 0 if it may show something; r if the cube of r³
    /// bricks shows nothing whose corner it is and that lies ahead. Three bytes more, so that a word can
    /// be read anywhere.
    Cubes(Vec<u8>),
    /// Upper bounds of values, for rules that keep the largest or the smallest.
    Bounds(Bounds),
}

/// The cubes of [`Knowledge::Cubes`] for the directions of a packet.
pub struct Cubes<'k, S: Level> {
    cubes: &'k [u8],
    /// Number of bricks along each axis.
    dims: [i32; 3],
    /// Where those of its octant begin.
    octant: I32s<S>,
}

impl<S: Level> Cubes<'_, S> {
    /// The edge, in bricks, of the cube of nothing that begins with the brick around each cell and lies ahead.
    #[inline(always)]
    pub fn at(&self, cell: [I32s<S>; 3]) -> I32s<S> {
        let index = brick_number(self.dims, cell) + self.octant;
        words_inside(self.cubes, index).and(0xFF)
    }

    /// How many lattice points, that at `position` in `cell` included, lie in a cube of an edge of at least 1.
    #[inline(always)]
    pub fn points(
        &self,
        cube: I32s<S>,
        cell: [I32s<S>; 3],
        position: Vec3s<S>,
        line: &Line<S>,
    ) -> F32s<S> {
        let (half, edge) = (F32s::splat(0.5), F32s::splat(EDGE as f32));
        // Half a brick, and the bricks behind it.
        let reach = (cube.to_f32s() - half) * edge;
        let middle = each!(cell, |c| {
            (c.shifted_down(SHIFT).to_f32s() + half) * edge
        });
        points_to_face(line, position, middle, reach)
    }
}

/// Upper bounds of the values, or of the values' negatives, in all blocks of 2³ bricks. The bricks are those of the volume,
/// or, in large volumes, as many of them as it takes for the bounds to fit the cache.
pub struct Bounds {
    /// Number of bricks along each axis.
    dims: [i32; 3],
    /// Of a cell's number, to that of its brick.
    shift: u32,
    /// For each brick as the lowest of a block: the upper half of the bound's bits, rounded up, which half
    /// the cache holds. One number more, so that a word can be read anywhere.
    largest: Vec<u16>,
    is_negative: bool,
}

impl Bounds {
    /// From those of single bricks.
    fn new(mut dims: [usize; 3], mut of_bricks: Vec<f32>, is_negative: bool) -> Bounds {
        let mut shift = SHIFT;
        while dims.iter().any(|&n| n > MOST_BRICKS) {
            of_bricks = largest_of_eight(dims, &of_bricks);
            dims = dims.map(|n| n.div_ceil(2));
            shift += 1;
        }
        let (row, slice) = (dims[0], dims[0] * dims[1]);
        let mut largest = vec![0; of_bricks.len() + 1];
        let blocks = largest[..of_bricks.len()].chunks_exact_mut(slice);
        cores::for_each(blocks.enumerate(), |(z, blocks)| {
            let mut bounds = of_bricks[z * slice..][..slice].to_vec();
            if let Some(behind) = of_bricks[z * slice..].chunks_exact(slice).nth(1) {
                larger(&mut bounds, behind);
            }
            for y in 0..dims[1] {
                let (here, behind) = bounds[y * row..].split_at_mut(row);
                if y + 1 < dims[1] {
                    larger(here, &behind[..row]);
                }
                for x in 0..row {
                    let next = here[(x + 1).min(row - 1)];
                    blocks[y * row + x] = rounded_up(here[x].max(next));
                }
            }
        });
        Bounds {
            dims: dims.map(|n| n as i32),
            shift,
            largest,
            is_negative,
        }
    }

    /// Whether these are bounds of the negatives.
    pub fn is_negative(&self) -> bool {
        self.is_negative
    }

    /// How many lattice points in a row, at least one, lie in at most two bricks along each axis, wherever
    /// they are.
    #[inline(always)]
    pub fn points_of_run<S: Level>(&self, line: &Line<S>) -> f32 {
        let step = each!(line.step_in_voxel, |step| step.abs());
        let steps = step[0].max(step[1]).max(step[2]);
        let longest = (0..LANES).fold(0.0, |longest, lane| steps.lane(lane).max(longest));
        // From the first to the last less than the edge of a brick: positions are off by an eighth of a
        // voxel at the most.
        (((1 << self.shift) as f32 - 0.25) / longest)
            .min(MOST_POINTS - 1.0)
            .floor()
            + 1.0
    }

    /// Bounds of the values at the lattice points between the two `ends` of such a run.
    #[inline(always)]
    pub fn of_run<S: Level>(&self, shape: &Shape, [first, last]: [Vec3s<S>; 2]) -> F32s<S> {
        // Single-precision positions are monotonous along a ray: the points between lie between.
        let lowest = [
            first[0].min(last[0]),
            first[1].min(last[1]),
            first[2].min(last[2]),
        ];
        let cell = shape.cell(shape.clamp(lowest));
        let index = brick_number_of(self.dims, self.shift, cell);
        let words = words_inside(bytemuck::cast_slice(&self.largest), index.shifted_up(1));
        words.shifted_up(16).as_bits()
    }
}

/// The largest number of each 2³ bricks.
fn largest_of_eight(dims: [usize; 3], of_bricks: &[f32]) -> Vec<f32> {
    let half = dims.map(|n| n.div_ceil(2));
    let mut largest = vec![f32::NEG_INFINITY; half.iter().product()];
    let slices = largest.chunks_exact_mut(half[0] * half[1]);
    cores::for_each(slices.enumerate(), |(z, slice)| {
        for z in 2 * z..(2 * z + 2).min(dims[2]) {
            for y in 0..dims[1] {
                let row = &of_bricks[dims[0] * (y + dims[1] * z)..][..dims[0]];
                let to = &mut slice[half[0] * (y / 2)..][..half[0]];
                for (to, pair) in to.iter_mut().zip(row.chunks(2)) {
                    *to = pair.iter().fold(*to, |most, value| most.max(*value));
                }
            }
        }
    });
    largest
}

/// The most bricks along an axis of [`Bounds`].
const MOST_BRICKS: usize = 128;

/// Each number or `other`, whichever is larger.
fn larger(numbers: &mut [f32], other: &[f32]) {
    for (number, other) in numbers.iter_mut().zip(other) {
        *number = number.max(*other);
    }
}

/// The upper half of the bits of the least number that is not below `bound` and has zeros in the lower half.
pub fn rounded_up(bound: f32) -> u16 {
    let bits = bound.to_bits();
    let up = if bound.is_sign_negative() { 0 } else { 0xFFFF };
    (bits.saturating_add(up) >> 16) as u16
}

/// The most points of a run: more would be sampled where few matter.
const MOST_POINTS: f32 = 16.0;

/// All that [`Knowledge`] depends on.
#[derive(Clone, PartialEq)]
struct KnowledgeKey {
    contribution: ContributionKey,
    clipped: Option<ClippedBricksKey>,
}

impl Key for KnowledgeKey {
    type Value = Knowledge;

    const NAME: &str = "cubes of bricks";

    fn bytes(&self, value: &Knowledge) -> usize {
        let own = self.contribution.table_bytes();
        own + value.bytes()
    }
}

impl Knowledge {
    fn bytes(&self) -> usize {
        match self {
            Knowledge::Nothing => 0,
            Knowledge::Cubes(cubes) => cubes.len(),
            Knowledge::Bounds(bounds) => 2 * bounds.largest.len(),
        }
    }

    fn of_visible(
        dims: [usize; 3],
        visible: &[bool],
        control: &Control,
    ) -> Result<Knowledge, Cancelled> {
        let number = visible.len();
        let mut cubes = vec![0; 8 * number + 3];
        // For all directions: whoever turns the camera makes nothing anew.
        let pairs = cubes[..8 * number].chunks_exact_mut(2 * number);
        cores::try_for_each(
            pairs.enumerate(),
            || (),
            |(), (pair, cubes)| find_cubes(dims, visible, pair, cubes, control),
        )?;
        Ok(Knowledge::Cubes(cubes))
    }

    fn new(
        bricks: &Bricks,
        contribution: Contribution,
        control: &Control,
    ) -> Result<Knowledge, Cancelled> {
        let dims = bricks.dims();
        Ok(match contribution {
            Contribution::Every => Knowledge::Nothing,
            Contribution::Visible(visible) => Knowledge::of_visible(dims, &visible, control)?,
            Contribution::Largest(values) => Knowledge::Bounds(Bounds::new(dims, values, false)),
            Contribution::Smallest(values) => {
                let negatives = values.into_iter().map(|value| -value).collect();
                Knowledge::Bounds(Bounds::new(dims, negatives, true))
            }
        })
    }
}

/// What bricks can give where they are not `clipped`.
fn unclipped(contribution: Contribution, clipped: Option<&[bool]>) -> Contribution {
    let Some(clipped) = clipped else {
        return contribution;
    };
    fn put<T: Copy>(mut numbers: Vec<T>, clipped: &[bool], nothing: T) -> Vec<T> {
        for (number, _) in numbers
            .iter_mut()
            .zip(clipped)
            .filter(|(_, clipped)| **clipped)
        {
            *number = nothing;
        }
        numbers
    }
    match contribution {
        Contribution::Every => {
            Contribution::Visible(put(vec![true; clipped.len()], clipped, false))
        }
        Contribution::Visible(visible) => Contribution::Visible(put(visible, clipped, false)),
        Contribution::Largest(values) => {
            Contribution::Largest(put(values, clipped, f32::NEG_INFINITY))
        }
        Contribution::Smallest(values) => {
            Contribution::Smallest(put(values, clipped, f32::INFINITY))
        }
    }
}

impl Skip {
    /// What can be left out of object number `object`, also where it is `clipped`; `None` if the rule needs, or its loop
    /// visits, every sample.
    pub fn new(
        making: &Making,
        contribution: &ContributionKey,
        bricks: &Bricks,
        (plan, object): (&Plan, usize),
        clipped: Option<&ClippedBricks>,
    ) -> Result<Option<Skip>, Cancelled> {
        assert_eq!(bricks.edge(), EDGE);
        // Words are gathered at 32-bit offsets.
        let fits = bricks.number() <= i32::MAX as usize / 8;
        if plan.technique().composite == Composite::BackToFront || !fits {
            return Ok(None);
        }
        let control = making.control;
        let key = KnowledgeKey {
            contribution: contribution.clone(),
            clipped: clipped.map(|clipped| clipped.of.clone()),
        };
        let knowledge = making.find(&key, || {
            let visible = making.find(contribution, || {
                Contribution::of(plan, object, bricks, control)
            })?;
            let clipped = clipped.map(ClippedBricks::bricks);
            let contribution = unclipped(Contribution::clone(&visible), clipped);
            Knowledge::new(bricks, contribution, control)
        })?;
        let is_any = !matches!(*knowledge, Knowledge::Nothing);
        Ok(is_any.then(|| Skip {
            dims: bricks.dims().map(|n| n as i32),
            bricks: knowledge,
        }))
    }

    /// Leaves out all bricks but the `visible` ones; there are `dims` of them.
    pub fn of_visible(
        dims: [usize; 3],
        visible: &[bool],
        control: &Control,
    ) -> Result<Skip, Cancelled> {
        Ok(Skip {
            dims: dims.map(|n| n as i32),
            bricks: Arc::new(Knowledge::of_visible(dims, visible, control)?),
        })
    }

    /// Leaves out all bricks but the `visible` ones, and of those the `single` ones without what lies ahead of them.
    pub fn of_visible_and_single(
        dims: [usize; 3],
        visible: &[bool],
        single: &[bool],
        control: &Control,
    ) -> Result<Skip, Cancelled> {
        let mut bricks = Knowledge::of_visible(dims, visible, control)?;
        if let Knowledge::Cubes(cubes) = &mut bricks {
            for octant in cubes.chunks_exact_mut(visible.len()).take(8) {
                let single = octant.iter_mut().zip(single).filter(|(_, single)| **single);
                single.for_each(|(cube, _)| *cube = (*cube).max(1));
            }
        }
        Ok(Skip {
            dims: dims.map(|n| n as i32),
            bricks: Arc::new(bricks),
        })
    }

    /// How much memory it takes.
    pub fn bytes(&self) -> usize {
        self.bricks.bytes()
    }

    /// Whether what is known are cubes.
    pub fn has_cubes(&self) -> bool {
        matches!(*self.bricks, Knowledge::Cubes(_))
    }

    /// The cubes in the directions of `line`, if that is what is known.
    #[inline(always)]
    pub fn cubes<S: Level>(&self, line: &Line<S>) -> Option<Cubes<'_, S>> {
        let Knowledge::Cubes(cubes) = &*self.bricks else {
            return None;
        };
        let number = self.dims[0] * self.dims[1] * self.dims[2];
        Some(Cubes {
            cubes,
            dims: self.dims,
            octant: line.octant * I32s::splat(number),
        })
    }

    /// What values cannot exceed, for rules that keep the largest or the smallest.
    pub fn bounds(&self) -> Option<&Bounds> {
        match &*self.bricks {
            Knowledge::Bounds(bounds) => Some(bounds),
            _ => None,
        }
    }

    /// How many lattice points, this one at `position` included, show nothing for certain; 0 where
    /// this one has to be looked at.
    #[inline(always)]
    pub fn jump<S: Level>(&self, shape: &Shape, line: &Line<S>, position: Vec3s<S>) -> F32s<S> {
        let Some(cubes) = self.cubes(line) else {
            return F32s::zero();
        };
        let cell = shape.cell(shape.clamp(position));
        let cube = cubes.at(cell);
        let empty = I32s::splat(0).lt(cube);
        if !empty.any() {
            return F32s::zero();
        }
        empty.select(cubes.points(cube, cell, position, line), F32s::zero())
    }
}

/// For each brick the edge (at most 255) of the largest cube of bricks that are not `visible`, whose
/// corner it is and that lies ahead. (The largest square of ones with a given corner, by dynamic programming, in three
/// dimensions.) Bricks outside show nothing. `cubes` are those of the octants 2·`pair` and 2·`pair` + 1, which differ
/// in their direction along x: neither waits for the other, so that both take hardly longer than one.
fn find_cubes(
    dims: [usize; 3],
    visible: &[bool],
    pair: usize,
    cubes: &mut [u8],
    control: &Control,
) -> Result<(), Cancelled> {
    let [nx, ny, nz] = dims;
    // From the far end: what lies ahead is known.
    let turned = |i: usize, n: usize, axis: usize| {
        if (2 * pair) >> axis & 1 == 1 {
            i
        } else {
            n - 1 - i
        }
    };
    let (down, up) = cubes.split_at_mut(visible.len());
    // Of each row that is done: the smaller one of each brick and the next ahead.
    let mut pairs = [(); 2].map(|()| vec![u8::MAX; visible.len()]);
    let mut least = [(); 2].map(|()| vec![u8::MAX; nx]);
    for z in 0..nz {
        control.check()?;
        for y in 0..ny {
            let row_at = |y: usize, z: usize| nx * (turned(y, ny, 1) + ny * turned(z, nz, 2));
            let start = row_at(y, z);
            for (least, pairs) in least.iter_mut().zip(&pairs) {
                least.fill(u8::MAX);
                let mut look_at = |other: usize| {
                    for (least, pair) in least.iter_mut().zip(&pairs[other..other + nx]) {
                        *least = (*least).min(*pair);
                    }
                };
                if y > 0 {
                    look_at(row_at(y - 1, z));
                }
                if z > 0 {
                    look_at(row_at(y, z - 1));
                }
                if y > 0 && z > 0 {
                    look_at(row_at(y - 1, z - 1));
                }
            }
            let row = start..start + nx;
            let visible = &visible[row.clone()];
            let rows = [&mut down[row.clone()], &mut up[row.clone()]];
            let [pairs_down, pairs_up] = &mut pairs;
            let pairs = [&mut pairs_down[row.clone()], &mut pairs_up[row]];
            let mut ahead = [u8::MAX; 2];
            for i in 0..nx {
                for (side, x) in [nx - 1 - i, i].into_iter().enumerate() {
                    let cube = least[side][x].min(ahead[side]).saturating_add(1);
                    let cube = if visible[x] { 0 } else { cube };
                    rows[side][x] = cube;
                    pairs[side][x] = cube.min(ahead[side]);
                    ahead[side] = cube;
                }
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn bounds_are_those_of_blocks_rounded_up(
            dims in [1usize..7, 1usize..7, 1usize..7],
            numbers in proptest::collection::vec(any::<f32>(), 216),
        ) {
            let [nx, ny, nz] = dims;
            let numbers = numbers[..nx * ny * nz].iter().map(|n| if n.is_nan() { 0.0 } else { *n });
            let numbers: Vec<f32> = numbers.collect();
            let bounds = Bounds::new(dims, numbers.clone(), false);
            for (i, &found) in bounds.largest[..numbers.len()].iter().enumerate() {
                let place = [i % nx, i / nx % ny, i / (nx * ny)];
                let mut largest = f32::NEG_INFINITY;
                for corner in 0..8 {
                    let at = [0, 1, 2].map(|axis| (place[axis] + (corner >> axis & 1)).min(dims[axis] - 1));
                    largest = largest.max(numbers[at[0] + nx * (at[1] + ny * at[2])]);
                }
                let found = f32::from_bits(u32::from(found) << 16);
                prop_assert!(found >= largest, "{found} for {largest}");
                let by = 0.01 * largest.abs() + f32::MIN_POSITIVE;
                prop_assert!(found - by <= largest || found.is_infinite() && largest > 3.3e38);
            }
        }

        #[test]
        fn eight_bricks_are_one_with_the_largest(
            dims in [1usize..7, 1usize..7, 1usize..7],
            numbers in proptest::collection::vec(-9f32..9.0, 216),
        ) {
            let [nx, ny, nz] = dims;
            let joined = largest_of_eight(dims, &numbers[..nx * ny * nz]);
            let half = dims.map(|n| n.div_ceil(2));
            let mut largest = vec![f32::NEG_INFINITY; half.iter().product()];
            for (i, number) in numbers[..nx * ny * nz].iter().enumerate() {
                let at = [i % nx / 2, i / nx % ny / 2, i / (nx * ny) / 2];
                let to = &mut largest[at[0] + half[0] * (at[1] + half[1] * at[2])];
                *to = to.max(*number);
            }
            prop_assert_eq!(joined, largest);
        }

        #[test]
        fn cubes_are_the_largest_empty_ones(
            dims in [1usize..9, 1usize..9, 1usize..9],
            places in proptest::collection::vec(any::<proptest::sample::Index>(), 0..5),
            octant in 0usize..8,
        ) {
            let [nx, ny, nz] = dims;
            let mut visible = vec![false; nx * ny * nz];
            for place in places {
                let at = place.index(visible.len());
                visible[at] = true;
            }
            let number = visible.len();
            let mut cubes = vec![0; 2 * number];
            find_cubes(dims, &visible, octant / 2, &mut cubes, &Control::NONE).unwrap();
            let cubes = &cubes[octant % 2 * number..][..number];
            let place = |i: usize| [i % nx, i / nx % ny, i / (nx * ny)];
            for (i, &cube) in cubes.iter().enumerate() {
                let ahead = |j: usize| {
                    let mut furthest = 0;
                    for axis in 0..3 {
                        let (from, to) = (place(i)[axis] as i32, place(j)[axis] as i32);
                        let by = if octant >> axis & 1 == 1 { from - to } else { to - from };
                        if by < 0 {
                            return None;
                        }
                        furthest = furthest.max(by as usize);
                    }
                    Some(furthest)
                };
                let nearest = (0..visible.len()).filter(|&j| visible[j]).filter_map(ahead).min();
                prop_assert_eq!(usize::from(cube), nearest.unwrap_or(255));
            }
        }
    }
}
