//! Cubes of bricks inside which one sample can stand for several lattice points.

use crate::brick_bytes::BrickBytes;
use crate::brick_number::SHIFT;
use crate::lanes::{F32s, I32s, Vec3s, each};
use crate::levels::Level;
use crate::library::fetch::Shape;
use crate::line::{Line, points_to_face};
use crate::making::Making;
use strahl_scene::plan::{Plan, Sampling};
use strahl_scene::visibility::{ContributionKey, even_cubes};
use strahl_volume::Cancelled;
use strahl_volume::bricks::Bricks;

/// The even cubes of a volume under a Plan: what [`even_cubes`] gives.
pub struct EvenCubes(BrickBytes);

impl EvenCubes {
    /// Those of object number `object`; `None` if every lattice point is to be looked at.
    pub fn new(
        making: &Making,
        contribution: &ContributionKey,
        bricks: &Bricks,
        plan: &Plan,
        object: usize,
    ) -> Result<Option<EvenCubes>, Cancelled> {
        if !matches!(plan.sampling, Sampling::Adaptive { .. }) {
            return Ok(None);
        }
        let of = (plan, object);
        let found = BrickBytes::new(making, contribution, bricks, of, None, even_cubes)?;
        Ok(found.map(EvenCubes))
    }

    /// How many lattice points, this one at `position` included, lie in the same even cube for certain; 1
    /// where it lies in none.
    #[inline(always)]
    pub fn run<S: Level>(&self, shape: &Shape, line: &Line<S>, position: Vec3s<S>) -> F32s<S> {
        let one = F32s::splat(1.0);
        let cell = shape.cell(shape.clamp(position));
        let cube = self.0.at(cell);
        let even = I32s::splat(0).lt(cube);
        if !even.any() {
            return one;
        }
        // Cells along the edge: a brick's, doubled for each number above 1.
        let exponent = cube.max(1) + I32s::splat(126 + SHIFT as i32);
        let edge = exponent.shifted_up(23).as_bits();
        let corner = I32s::splat(0) - edge.to_i32s();
        let reach = edge * F32s::splat(0.5);
        let middle = each!(cell, |c| c.both(corner).to_f32s() + reach);
        even.select(points_to_face(line, position, middle, reach), one)
    }
}
