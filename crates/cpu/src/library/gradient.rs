//! Slot gradient: the change of a field, in world space, per mm.

mod field;

use crate::lanes::{F32s, Mask, Vec3s, each};
use crate::levels::{Level, vectorized};
use crate::library::reconstruct::Values;
use field::Field;
use std::cell::Cell;
use strahl_scene::plan::{GradientMethod, for_each_function};
use strahl_volume::Grid;

/// A file per estimate of the registry, each with a function `per_voxel` of the field, the position (voxel space) and the
/// estimate's parameters.
macro_rules! estimates {
    ($(; $meaning:literal $variant:ident $name:ident $word:literal { $($field:ident),* })*) => {
        $(mod $name;)*

        /// The gradient in voxel space.
        #[inline(always)]
        fn per_voxel<S: Level>(
            method: GradientMethod,
            field: &Field<S>,
            position: Vec3s<S>,
        ) -> Vec3s<S> {
            match method {
                $(GradientMethod::$variant { $($field),* } => {
                    $name::per_voxel(field, position, $($field),*)
                })*
            }
        }
    };
}

for_each_function! { GradientMethod => estimates! {} }

/// What rounding can make of a gradient, as a share of the values that it is made of: 64 times half the last place. Of a
/// spline over 64 voxels it makes less than ten, and the opacity of a value lies in a few times as much doubt as the value.
const ROUNDING: f32 = 1.0 / (1 << 18) as f32;

/// A gradient in voxel space where rounding cannot have made it, 0 elsewhere; `largest` is the largest of the values that
/// it was made of, without its sign.
#[inline(always)]
pub fn above_rounding<S: Level>(in_voxel: Vec3s<S>, largest: F32s<S>) -> Vec3s<S> {
    let [x, y, z] = each!(in_voxel, |c| c.abs());
    let is_more = (largest * F32s::splat(ROUNDING)).lt(x.max(y).max(z));
    each!(in_voxel, |c| is_more.select(c, F32s::zero()))
}

/// How gradients are found in one object.
pub struct Gradients {
    pub method: GradientMethod,
    /// Gradient in voxel space → in world space: the transpose of `voxel_from_world`.
    world_from_voxel: [[f32; 3]; 3],
}

impl Gradients {
    /// The gradients on `grid`.
    pub fn new(method: GradientMethod, grid: &Grid) -> Gradients {
        let transposed = grid.voxel_from_world().matrix3.transpose();
        let row = |r: usize| transposed.row(r).to_array().map(|v| v as f32);
        Gradients {
            method,
            world_from_voxel: [row(0), row(1), row(2)],
        }
    }

    /// The gradient of the values at `position` (voxel space) where `asked`; anything elsewhere.
    #[inline(always)]
    pub fn of_values<S: Level>(
        &self,
        values: &dyn Values<S>,
        position: Vec3s<S>,
        asked: Mask<S>,
    ) -> Vec3s<S> {
        if self.method == GradientMethod::Central {
            let (differences, largest) = values.central_differences(position, asked);
            return self.in_world(above_rounding(differences, largest));
        }
        self.of(&|position| values.at(position), position)
    }

    /// The gradient of any field. Compiled once for all fields: their values take longer than the calls.
    #[inline(never)]
    pub fn of<S: Level>(&self, field: &Field<S>, position: Vec3s<S>) -> Vec3s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let largest = Cell::new(F32s::zero());
                let field = |position| {
                    let value = field(position);
                    largest.set(value.abs().max(largest.get()));
                    value
                };
                let in_voxel = per_voxel(self.method, &field, position);
                self.in_world(above_rounding(in_voxel, largest.get()))
            },
        )
    }

    /// Of one in voxel space.
    #[inline(always)]
    pub fn in_world<S: Level>(&self, in_voxel: Vec3s<S>) -> Vec3s<S> {
        each!(self.world_from_voxel, |row| {
            in_voxel[0] * F32s::splat(row[0])
                + in_voxel[1] * F32s::splat(row[1])
                + in_voxel[2] * F32s::splat(row[2])
        })
    }
}
