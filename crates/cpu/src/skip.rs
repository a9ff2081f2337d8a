//! Leaving out lattice points that cannot change a pixel.
//!
//! Only whole lattice points are left out, and only those whose single-precision position falls
//! into a brick that provably gives nothing: pictures have the same bytes with skipping and without.

use crate::lanes::{F32s, I32s, Vec3s, lanes};
use crate::library::composite::State;
use crate::library::fetch::Shape;
use crate::ray::Line;
use strahl_scene::plan::Plan;
use strahl_scene::visibility::Contribution;
use strahl_volume::bricks::Bricks;

/// What is known of the bricks of a volume under a Plan.
pub struct Skip {
    /// Number of bricks along each axis.
    dims: [i32; 3],
    /// How far a position may be off by rounding, per axis, in voxels: 8 times the bound of the
    /// product, the sum and the quotient that it comes from.
    margin: [f32; 3],
    bricks: Knowledge,
}

enum Knowledge {
    /// 0: the brick may show something. r > 0: all bricks less than r away along every axis (the
    /// brick itself for r = 1) show nothing.
    Radius(Vec<u8>),
    /// An upper bound of the values: nothing where the ray has seen more.
    Largest(Vec<f32>),
    /// A lower bound of the values: nothing where the ray has seen less.
    Smallest(Vec<f32>),
}

/// Further than any lattice reaches, as a number of steps.
const NEVER: f32 = 1e9;

impl Skip {
    /// What can be left out of object number `object`; `None` if the rule needs every sample.
    pub fn new(bricks: &Bricks, plan: &Plan, object: usize) -> Option<Skip> {
        let dims = bricks.dims().map(|n| n as i32);
        let bricks = match Contribution::of(plan, object, bricks) {
            Contribution::Every => return None,
            Contribution::Visible(visible) => Knowledge::Radius(radii(dims, &visible)),
            Contribution::Largest(values) => Knowledge::Largest(values),
            Contribution::Smallest(values) => Knowledge::Smallest(values),
        };
        let voxels = plan.objects[object].grid.dims();
        Some(Skip {
            dims,
            margin: voxels.map(|n| n as f32 / (1 << 20) as f32),
            bricks,
        })
    }

    /// How many lattice points, this one at `position` included, show nothing for certain; 0 where
    /// this one has to be looked at.
    #[inline(always)]
    pub fn jump(&self, shape: &Shape, line: &Line, position: Vec3s, state: &State) -> F32s {
        let cell = shape.cell(shape.clamp(position));
        let brick = cell.map(|c| I32s(c.0.map(|c| c >> BRICK_SHIFT)));
        let index: [usize; _] = lanes(|i| {
            let [x, y, z] = [0, 1, 2].map(|axis: usize| brick[axis].0[i] as usize);
            x + self.dims[0] as usize * (y + self.dims[1] as usize * z)
        });
        let (empty, radius) = match &self.bricks {
            Knowledge::Radius(radii) => {
                let radius = I32s(lanes(|i| i32::from(radii[index[i]])));
                (F32s::ZERO.lt(radius.to_f32s()), radius)
            }
            Knowledge::Largest(values) => {
                let largest = F32s(lanes(|i| values[index[i]]));
                (largest.le(state.value), I32s([1; _]))
            }
            Knowledge::Smallest(values) => {
                let smallest = F32s(lanes(|i| values[index[i]]));
                (state.value.le(smallest), I32s([1; _]))
            }
        };
        if !empty.any() {
            return F32s::ZERO;
        }
        let mut points = F32s::splat(NEVER);
        for axis in 0..3 {
            points = points.min(self.points_inside(line, position, brick, radius, axis));
        }
        let points = points.max(F32s::ZERO).to_i32s().to_f32s() + F32s::splat(1.0);
        empty.select(points, F32s::ZERO)
    }

    /// How many steps stay within the bricks less than `radius` away along `axis`.
    #[inline(always)]
    fn points_inside(
        &self,
        line: &Line,
        position: Vec3s,
        brick: [I32s; 3],
        radius: I32s,
        axis: usize,
    ) -> F32s {
        let inverse = line.inverse_step[axis];
        let ahead = brick[axis] + radius;
        let behind = brick[axis] - radius + I32s([1; _]);
        let edge = F32s::splat(Bricks::EDGE as f32);
        let margin = F32s::splat(self.margin[axis]);
        let upper = ahead.to_f32s() * edge - margin;
        let lower = behind.to_f32s() * edge + margin;
        let forward = F32s::ZERO.lt(inverse);
        let steps = (forward.select(upper, lower) - position[axis]) * inverse;
        // The outermost bricks reach to the end of every ray, and so does every brick for a ray
        // that stays where it is along this axis.
        let last = F32s::splat((self.dims[axis] - 1) as f32);
        let open = (forward & last.lt(ahead.to_f32s()))
            | (inverse.lt(F32s::ZERO) & behind.to_f32s().le(F32s::ZERO))
            | inverse.eq(F32s::ZERO);
        open.select(F32s::splat(NEVER), steps)
    }
}

const BRICK_SHIFT: u32 = Bricks::EDGE.trailing_zeros();

/// For each brick the chessboard distance (at most 255) to the nearest that is `visible`, by the two
/// raster passes of A. Rosenfeld and J. Pfaltz (1968), exact for this distance.
fn radii(dims: [i32; 3], visible: &[bool]) -> Vec<u8> {
    let radius = |visible: &bool| if *visible { 0 } else { u8::MAX };
    let mut radii: Vec<u8> = visible.iter().map(radius).collect();
    let dims = dims.map(|n| n as isize);
    let [nx, ny, nz] = dims;
    let mut neighbours = Vec::new();
    for dz in -1..=0 {
        for dy in -1..=1 {
            for dx in -1..=1 {
                if (dz, dy, dx) < (0, 0, 0) {
                    neighbours.push([dx, dy, dz]);
                }
            }
        }
    }
    for sign in [1, -1] {
        for i in 0..nx * ny * nz {
            let i = if sign == 1 { i } else { nx * ny * nz - 1 - i };
            let at = [i % nx, i / nx % ny, i / (nx * ny)];
            let mut least = radii[i as usize];
            for d in &neighbours {
                let [x, y, z] = [0, 1, 2].map(|axis| at[axis] + sign * d[axis]);
                if x >= 0 && x < nx && y >= 0 && y < ny && z >= 0 && z < nz {
                    let near = radii[(x + nx * (y + ny * z)) as usize];
                    least = least.min(near.saturating_add(1));
                }
            }
            radii[i as usize] = least;
        }
    }
    radii
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use strahl_volume::{Grid, Metadata, Rescale, Samples, Volume};

    proptest! {
        #[test]
        fn radii_are_chessboard_distances(
            dims in [1usize..40, 1usize..40, 1usize..40],
            places in proptest::collection::vec(any::<proptest::sample::Index>(), 0..3),
        ) {
            let grid = Grid::centred(dims, glam::DVec3::ONE).unwrap();
            let mut samples = vec![0u8; grid.voxel_count()];
            for place in places {
                let at = place.index(samples.len());
                samples[at] = 1;
            }
            let volume =
                Volume::new(grid, Samples::U8(samples), Rescale::IDENTITY, Metadata::default());
            let bricks = Bricks::new(&volume.unwrap());
            let visible: Vec<bool> = bricks.ranges().iter().map(|range| range.hi > 0.0).collect();
            let got = radii(bricks.dims().map(|n| n as i32), &visible);
            let [nx, ny, nz] = bricks.dims();
            let place = |i: usize| [i % nx, i / nx % ny, i / (nx * ny)];
            for (i, radius) in got.iter().enumerate().take(nx * ny * nz) {
                let nearest = (0..nx * ny * nz)
                    .filter(|&j| visible[j])
                    .map(|j| (0..3).map(|a| place(i)[a].abs_diff(place(j)[a])).max().unwrap())
                    .min()
                    .unwrap_or(255);
                prop_assert_eq!(usize::from(*radius), nearest);
            }
        }
    }
}
