//! Slot gradient: the change of a field, in world space, per mm.

mod b_spline;
mod differences;
mod field;
mod sobel;

use crate::lanes::{F32s, Mask, Vec3s, each};
use crate::levels::{Level, vectorized};
use crate::library::reconstruct::Values;
use field::Field;
use strahl_scene::plan::GradientMethod;
use strahl_volume::Grid;

/// How gradients are found in one object.
pub struct Gradients {
    method: GradientMethod,
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
            return self.in_world(values.central_differences(position, asked));
        }
        self.of(&|position| values.at(position), position)
    }

    /// The gradient of any field. Compiled once for all fields: their values take longer than the calls.
    #[inline(never)]
    pub fn of<S: Level>(&self, field: &Field<S>, position: Vec3s<S>) -> Vec3s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let in_voxel = match self.method {
                    GradientMethod::Forward => differences::forward(field, position),
                    GradientMethod::Backward => differences::backward(field, position),
                    GradientMethod::Central => differences::central(field, position),
                    GradientMethod::Central9 => differences::central_9(field, position),
                    GradientMethod::Sobel => sobel::per_voxel(field, position),
                    GradientMethod::BSpline => b_spline::per_voxel(field, position),
                };
                self.in_world(in_voxel)
            },
        )
    }

    #[inline(always)]
    fn in_world<S: Level>(&self, in_voxel: Vec3s<S>) -> Vec3s<S> {
        each!(self.world_from_voxel, |row| {
            in_voxel[0] * F32s::splat(row[0])
                + in_voxel[1] * F32s::splat(row[1])
                + in_voxel[2] * F32s::splat(row[2])
        })
    }
}
