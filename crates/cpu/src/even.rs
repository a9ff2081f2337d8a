//! Cubes of bricks inside which one sample can stand for several lattice points.

use crate::kept::Kept;
use crate::lanes::{F32s, I32s, Vec3s, each, words};
use crate::levels::Level;
use crate::library::fetch::Shape;
use crate::ray::Line;
use crate::skip::{Skip, brick_number, points_to_face};
use std::sync::Arc;
use strahl_scene::plan::{Plan, Reconstruct, Sampling};
use strahl_scene::transfer::TransferTable;
use strahl_scene::visibility::even_cubes;
use strahl_volume::Rescale;
use strahl_volume::bricks::Bricks;

/// The even cubes of a volume under a Plan.
pub struct EvenCubes {
    /// Number of bricks along each axis.
    dims: [i32; 3],
    /// What [`even_cubes`] gives, and three bytes more, so that a word can be read anywhere.
    cubes: Arc<Vec<u8>>,
}

/// What was found for the Plan drawn last: most have only another camera.
pub type RecentCubes = Kept<Asked, Vec<u8>>;

/// All that the cubes depend on; other Plans have none.
#[derive(PartialEq)]
pub struct Asked {
    volume: usize,
    sampling: Sampling,
    step_mm: f64,
    reconstruct: Reconstruct,
    rescale: Rescale,
    table: TransferTable,
}

impl EvenCubes {
    /// Those of object number `object`; `None` if every lattice point is to be looked at.
    pub fn new(
        recent: &RecentCubes,
        bricks: &Bricks,
        plan: &Plan,
        object: usize,
    ) -> Option<EvenCubes> {
        if !matches!(plan.sampling, Sampling::Adaptive { .. }) {
            return None;
        }
        assert_eq!(bricks.edge(), Skip::EDGE);
        // Words are gathered at 32-bit offsets.
        if bricks.number() > i32::MAX as usize / 8 {
            return None;
        }
        let placed = &plan.objects[object];
        let asked = Asked {
            volume: placed.volume,
            sampling: plan.sampling,
            step_mm: plan.lattice.step_mm,
            reconstruct: plan.reconstruct,
            rescale: placed.rescale,
            table: placed.table.clone(),
        };
        let cubes = recent.find(asked, |_| {
            let mut cubes = even_cubes(plan, object, bricks)?;
            cubes.extend([0; 3]);
            Some(cubes)
        })?;
        Some(EvenCubes {
            dims: bricks.dims().map(|n| n as i32),
            cubes,
        })
    }

    /// How many lattice points, this one at `position` included, lie in the same even cube for certain; 1
    /// where it lies in none.
    #[inline(always)]
    pub fn run<S: Level>(&self, shape: &Shape, line: &Line<S>, position: Vec3s<S>) -> F32s<S> {
        let one = F32s::splat(1.0);
        let cell = shape.cell(shape.clamp(position));
        let index = brick_number(self.dims, cell);
        // SAFETY: the cell lies in one of the bricks, and there are three bytes behind the last.
        let cube = unsafe { words(&self.cubes, index) }.and(0xFF);
        let even = I32s::splat(0).lt(cube);
        if !even.any() {
            return one;
        }
        // Cells along the edge: a brick's, doubled for each number above 1.
        let exponent = cube.max(1) + I32s::splat(126 + Skip::SHIFT as i32);
        let edge = exponent.shifted_up(23).as_bits();
        let corner = I32s::splat(0) - edge.to_i32s();
        let reach = edge * F32s::splat(0.5);
        let middle = each!(cell, |c| c.both(corner).to_f32s() + reach);
        even.select(points_to_face(line, position, middle, reach), one)
    }
}
