//! Leaving out lattice points that cannot change a pixel.
//!
//! Only whole lattice points are left out, and only those whose single-precision position falls
//! into a brick that provably gives nothing: pictures have the same bytes with skipping and without.

use crate::lanes::{F32s, I32s, Vec3s, each, words};
use crate::levels::Level;
use crate::library::fetch::Shape;
use crate::ray::{Line, NEVER};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use strahl_scene::plan::{Classify, Composite, Fetch, Plan, PlanCamera, Projection, Reconstruct};
use strahl_scene::transfer::TransferTable;
use strahl_scene::visibility::Contribution;
use strahl_volume::Rescale;
use strahl_volume::bricks::Bricks;

/// What is known of the bricks of a volume under a Plan.
pub struct Skip {
    /// Number of bricks along each axis.
    dims: [i32; 3],
    bricks: Knowledge,
}

#[derive(Clone)]
enum Knowledge {
    /// Nothing can be left out.
    Nothing,
    /// For each octant of directions, and each brick: 0 if it may show something; r if the cube of r³
    /// bricks shows nothing whose corner it is and that lies ahead. Three bytes more, so that a word can
    /// be read anywhere. Octants that no ray has are 0.
    Cubes(Arc<Vec<u8>>),
    /// An upper bound of the values, or of the values' negatives: nothing where the ray has seen more.
    Bounds {
        /// Of 1³, 4³ and 16³ bricks.
        blocks: Arc<[Blocks; 3]>,
        is_negative: bool,
    },
}

/// A number for each block of bricks.
struct Blocks {
    dims: [usize; 3],
    largest: Vec<f32>,
}

impl Blocks {
    /// The largest numbers of blocks of 4³.
    fn coarser(&self) -> Blocks {
        let dims = self.dims.map(|n| n.div_ceil(4));
        let mut largest = vec![f32::NEG_INFINITY; dims.iter().product()];
        let [nx, ny, _] = self.dims;
        for (row, values) in self.largest.chunks_exact(nx).enumerate() {
            let (y, z) = (row % ny / 4, row / ny / 4);
            let start = dims[0] * (y + dims[1] * z);
            for (block, values) in largest[start..].iter_mut().zip(values.chunks(4)) {
                *block = values.iter().copied().fold(*block, f32::max);
            }
        }
        Blocks { dims, largest }
    }

    /// The number of the block, with an edge of 2^`shift` cells, that each cell lies in.
    #[inline(always)]
    fn at<S: Level>(&self, cell: [I32s<S>; 3], shift: u32) -> F32s<S> {
        let block = each!(cell, |c| c.shifted_down(shift));
        let row = I32s::splat(self.dims[0] as i32);
        let slice = I32s::splat((self.dims[0] * self.dims[1]) as i32);
        let index = block[0] + block[1] * row + block[2] * slice;
        // SAFETY: the cell lies in the volume, and so does its block.
        unsafe { words(bytemuck::cast_slice(&self.largest), index.shifted_up(2)) }.as_bits()
    }
}

/// What was found for the Plans drawn last: most have only another camera.
#[derive(Default)]
pub struct Recent(Mutex<Vec<Found>>);

struct Found {
    of: Asked,
    visible: Vec<bool>,
    /// Octants whose cubes are found: bit i is octant i.
    octants: u32,
    knowledge: Knowledge,
}

/// All that a [`Contribution`] depends on.
#[derive(Clone, PartialEq)]
struct Asked {
    volume: usize,
    fetch: Fetch,
    reconstruct: Reconstruct,
    classify: Classify,
    composite: Composite,
    rescale: Rescale,
    table: TransferTable,
}

impl Recent {
    fn find(&self, bricks: &Bricks, plan: &Plan, object: usize) -> Knowledge {
        let placed = &plan.objects[object];
        let asked = Asked {
            volume: placed.volume,
            fetch: plan.fetch,
            reconstruct: plan.reconstruct,
            classify: plan.classify,
            composite: plan.composite,
            rescale: placed.rescale,
            table: placed.table.clone(),
        };
        let known = {
            let mut all = self.all();
            let place = all.iter().position(|found| found.of == asked);
            place.map(|place| all.remove(place))
        };
        // Not under the lock: the threads that help here may draw other pictures meanwhile.
        let mut found = known.unwrap_or_else(|| Found::new(asked, bricks, plan, object));
        found.look_towards(octants(plan, object), bricks.dims());
        let knowledge = found.knowledge.clone();
        let mut all = self.all();
        all.insert(0, found);
        // What was found for other transfer functions would take an eighth of a `u8` volume each.
        all.truncate(plan.objects.len());
        knowledge
    }

    fn all(&self) -> MutexGuard<'_, Vec<Found>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Found {
    fn new(of: Asked, bricks: &Bricks, plan: &Plan, object: usize) -> Found {
        let bounds = |largest: Vec<f32>, is_negative| {
            let bricks = Blocks {
                dims: bricks.dims(),
                largest,
            };
            let fours = bricks.coarser();
            let sixteens = fours.coarser();
            Knowledge::Bounds {
                blocks: Arc::new([bricks, fours, sixteens]),
                is_negative,
            }
        };
        let mut visible = Vec::new();
        // Words are gathered at 32-bit offsets.
        let knowledge = if bricks.ranges().len() > i32::MAX as usize / 8 {
            Knowledge::Nothing
        } else {
            match Contribution::of(plan, object, bricks) {
                Contribution::Every => Knowledge::Nothing,
                Contribution::Visible(of_bricks) => {
                    visible = of_bricks;
                    Knowledge::Cubes(Arc::new(vec![0; 8 * visible.len() + 3]))
                }
                Contribution::Largest(values) => bounds(values, false),
                Contribution::Smallest(values) => {
                    bounds(values.into_iter().map(|value| -value).collect(), true)
                }
            }
        };
        Found {
            of,
            visible,
            octants: 0,
            knowledge,
        }
    }

    /// Finds the cubes of `octants` that are not known yet.
    fn look_towards(&mut self, octants: u32, dims: [usize; 3]) {
        let octants = octants & !self.octants;
        let Knowledge::Cubes(cubes) = &mut self.knowledge else {
            return;
        };
        if octants == 0 {
            return;
        }
        let visible = &self.visible;
        Arc::make_mut(cubes)
            .par_chunks_exact_mut(visible.len())
            .enumerate()
            .filter(|(octant, _)| octants >> octant & 1 == 1)
            .for_each(|(octant, cubes)| find_cubes(dims, visible, octant, cubes));
        self.octants |= octants;
    }
}

impl Skip {
    /// Cells along the edge of the bricks: of the samples of typical scans half as many lie in visible
    /// bricks of 4 as in those of 8, for 12.5 % of the memory of a `u8` volume.
    pub const EDGE: usize = 4;

    const SHIFT: u32 = Self::EDGE.trailing_zeros();

    /// What can be left out of object number `object`; `None` if the rule needs, or its loop visits, every
    /// sample.
    pub fn new(recent: &Recent, bricks: &Bricks, plan: &Plan, object: usize) -> Option<Skip> {
        assert_eq!(bricks.edge(), Self::EDGE);
        if plan.composite == Composite::BackToFront {
            return None;
        }
        match recent.find(bricks, plan, object) {
            Knowledge::Nothing => None,
            knowledge => Some(Skip {
                dims: bricks.dims().map(|n| n as i32),
                bricks: knowledge,
            }),
        }
    }

    /// How many lattice points, this one at `position` included, show nothing for certain; 0 where
    /// this one has to be looked at. `seen` is the value that each ray has seen, for rules that keep the
    /// largest or the smallest.
    #[inline(always)]
    pub fn jump<S: Level>(
        &self,
        shape: &Shape,
        line: &Line<S>,
        position: Vec3s<S>,
        seen: F32s<S>,
    ) -> F32s<S> {
        let cell = shape.cell(shape.clamp(position));
        let (one, half) = (F32s::splat(1.0), F32s::splat(0.5));
        let edge = F32s::splat(Self::EDGE as f32);
        // The middle of a block that shows nothing, and what is from there to its face.
        let (empty, middle, reach) = match &self.bricks {
            Knowledge::Nothing => return F32s::zero(),
            Knowledge::Cubes(cubes) => {
                let brick = each!(cell, |c| c.shifted_down(Self::SHIFT));
                let row = I32s::splat(self.dims[0]);
                let slice = I32s::splat(self.dims[0] * self.dims[1]);
                let of_octant = line.octant * (slice * I32s::splat(self.dims[2]));
                let index = brick[0] + brick[1] * row + brick[2] * slice + of_octant;
                // SAFETY: the cell lies in one of the bricks, and there are three bytes behind the last.
                let cube = unsafe { words(cubes, index) }.and(0xFF);
                let empty = I32s::splat(0).lt(cube);
                if !empty.any() {
                    return F32s::zero();
                }
                // Half a brick, and the bricks behind it.
                let reach = (cube.to_f32s() - half) * edge;
                let middle = each!(brick, |brick| (brick.to_f32s() + half) * edge);
                (empty, middle, reach)
            }
            Knowledge::Bounds {
                blocks,
                is_negative,
            } => {
                let seen = if *is_negative { -seen } else { seen };
                let empty = blocks[0].at(cell, Self::SHIFT).le(seen);
                if !empty.any() {
                    return F32s::zero();
                }
                let fours = blocks[1].at(cell, Self::SHIFT + 2).le(seen);
                let sixteens = blocks[2].at(cell, Self::SHIFT + 4).le(seen);
                let mask = fours.select_i32s(I32s::splat(!15), I32s::splat(!3));
                let mask = sixteens.select_i32s(I32s::splat(!63), mask);
                let reach = fours.select(F32s::splat(8.0), F32s::splat(2.0));
                let reach = sixteens.select(F32s::splat(32.0), reach);
                let middle = each!(cell, |c| c.both(mask).to_f32s() + reach);
                (empty, middle, reach)
            }
        };
        let mut points = F32s::splat(NEVER);
        for axis in 0..3 {
            let face = middle[axis] + reach * line.sign[axis] - line.margin[axis];
            let steps = (face - position[axis]) * line.inverse_step[axis] + line.stays[axis];
            points = points.min(steps);
        }
        let points = points.max(F32s::zero()).to_i32s().to_f32s() + one;
        empty.select(points, F32s::zero())
    }
}

/// Which octants of directions (bit i is octant i) rays of `plan` may have in the voxel space of an object.
fn octants(plan: &Plan, object: usize) -> u32 {
    let PlanCamera {
        right, up, forward, ..
    } = plan.camera;
    let corners: Vec<DVec3> = match plan.camera.projection {
        Projection::Orthographic { .. } => vec![forward],
        // Every component is a linear function of the place in the picture: its signs are those at the
        // corners.
        Projection::Perspective { tan_half_height } => {
            let aspect = f64::from(plan.width) / f64::from(plan.height);
            let at = |[x, y]: [f64; 2]| forward + (right * (x * aspect) + up * y) * tan_half_height;
            [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]]
                .map(at)
                .to_vec()
        }
    };
    let voxel_from_world = plan.objects[object].grid.voxel_from_world();
    let mut signs = [[false; 2]; 3];
    for corner in corners {
        let direction = voxel_from_world.transform_vector3(corner);
        let rounding = 1e-9 * direction.length();
        for (axis, signs) in signs.iter_mut().enumerate() {
            signs[0] |= direction[axis] > -rounding;
            signs[1] |= direction[axis] < rounding;
        }
    }
    (0..8)
        .filter(|octant| (0..3).all(|axis| signs[axis][octant >> axis & 1]))
        .fold(0, |set, octant| set | 1 << octant)
}

/// For each brick the edge (at most 255) of the largest cube of bricks that are not `visible`, whose
/// corner it is and that lies ahead in directions of the `octant`. (The largest square of ones with a
/// given corner, by dynamic programming, in three dimensions.) Bricks outside show nothing.
fn find_cubes(dims: [usize; 3], visible: &[bool], octant: usize, cubes: &mut [u8]) {
    let [nx, ny, nz] = dims;
    // From the far end: what lies ahead is known.
    let turned = |i: usize, n: usize, axis: usize| {
        if octant >> axis & 1 == 1 {
            i
        } else {
            n - 1 - i
        }
    };
    // Of each row that is done: the smaller one of each brick and the next ahead.
    let mut pairs = vec![u8::MAX; cubes.len()];
    let mut least = vec![u8::MAX; nx];
    for z in 0..nz {
        for y in 0..ny {
            let row_at = |y: usize, z: usize| nx * (turned(y, ny, 1) + ny * turned(z, nz, 2));
            let start = row_at(y, z);
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
            let row = &mut cubes[start..start + nx];
            let pairs = &mut pairs[start..start + nx];
            let mut ahead = u8::MAX;
            for x in 0..nx {
                let x = turned(x, nx, 0);
                let cube = least[x].min(ahead).saturating_add(1);
                let cube = if visible[start + x] { 0 } else { cube };
                row[x] = cube;
                pairs[x] = cube.min(ahead);
                ahead = cube;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
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
            let mut cubes = vec![0; visible.len()];
            find_cubes(dims, &visible, octant, &mut cubes);
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
