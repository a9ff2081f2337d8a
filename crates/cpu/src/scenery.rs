//! A Plan with everything prepared that is the same for all rays.

use crate::elementary::opacity_of_length;
use crate::lanes::{Affine, F32s, Mask, Vec3s};
use crate::levels::{Level, vectorized};
use crate::library::classify::{Surface, Table, classify};
use crate::library::clip_sample::SampleClips;
use crate::library::gradient::Gradients;
use crate::library::jitter::Jitters;
use crate::library::reconstruct::Values;
use crate::library::shade::{Place, Shading};
use crate::meshes::Meshes;
use crate::skip::Skip;
use strahl_scene::plan::{Classify, GradientInput, Plan};

/// The functions in the slots, with what they read.
pub struct Scenery<'p, S: Level> {
    pub plan: &'p Plan,
    pub objects: Vec<Object<'p, S>>,
    pub shading: Shading,
    pub jitters: Jitters,
    pub meshes: &'p Meshes,
}

/// A volume in the picture.
pub struct Object<'p, S: Level> {
    pub values: &'p dyn Values<S>,
    pub clips: SampleClips<'p, S>,
    pub table: Table<'p>,
    pub gradients: Gradients,
    pub skip: Option<Skip>,
    classify: Classify,
    /// step/reference, the exponent of the opacity correction.
    steps_per_reference: f32,
    world_from_voxel: Affine,
}

/// The look of a sample: opacity of one step.
pub struct Look<S: Level> {
    pub surface: Surface<S>,
    /// Where it is not transparent.
    pub visible: Mask<S>,
}

impl<'p, S: Level> Object<'p, S> {
    /// Object number `object` of `plan`.
    pub fn new(
        plan: &'p Plan,
        object: usize,
        values: &'p dyn Values<S>,
        masks: &'p [Box<dyn Values<S> + 'p>],
        skip: Option<Skip>,
    ) -> Object<'p, S> {
        let placed = &plan.objects[object];
        let table = &placed.table;
        Object {
            values,
            clips: SampleClips::new(plan, object, &placed.grid, masks),
            table: Table::new(table),
            gradients: Gradients::new(plan.gradient, &placed.grid),
            skip,
            classify: plan.classify,
            steps_per_reference: (plan.lattice.step_mm / f64::from(table.reference_mm())) as f32,
            world_from_voxel: Affine::new(placed.grid.world_from_voxel()),
        }
    }

    /// Slot classify, where `asked`; anything elsewhere.
    #[inline(always)]
    pub fn classify(&self, value: F32s<S>, position: Vec3s<S>, asked: Mask<S>) -> Surface<S> {
        match self.classify {
            Classify::Table => self.table.at(value),
            _ => self.classify_otherwise(value, position, asked),
        }
    }

    /// Compiled once instead of wherever something is classified.
    #[inline(never)]
    fn classify_otherwise(&self, value: F32s<S>, position: Vec3s<S>, asked: Mask<S>) -> Surface<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                classify(
                    self.classify,
                    &self.table,
                    &self.gradients,
                    self.values,
                    value,
                    position,
                    asked,
                )
            },
        )
    }

    /// Slot gradient over slot gradient_input, where `asked`; anything elsewhere.
    #[inline(never)]
    pub fn gradient(&self, position: Vec3s<S>, asked: Mask<S>) -> Vec3s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || match self.gradients.input() {
                GradientInput::Value => self.gradients.of_values(self.values, position, asked),
                GradientInput::Opacity => {
                    let opacity = |at| self.opacity_at(at, asked);
                    self.gradients.of(&opacity, position)
                }
            },
        )
    }

    #[inline(never)]
    fn opacity_at(&self, position: Vec3s<S>, asked: Mask<S>) -> F32s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let value = self.values.at(position);
                self.classify(value, position, asked).opacity
            },
        )
    }

    /// Slot shade: `surface` under the lights, its opacity still that of the reference length.
    #[inline(never)]
    pub fn shade(
        &self,
        shading: &Shading,
        surface: Surface<S>,
        position: Vec3s<S>,
        to_eye: Vec3s<S>,
        shaded: Mask<S>,
        last_normal: &mut Vec3s<S>,
    ) -> Surface<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let place = Place {
                    gradient: || self.gradient(position, shaded),
                    place_mm: || self.world_from_voxel.point(position),
                    to_eye,
                };
                shading.look(surface, &place, shaded, last_normal)
            },
        )
    }

    /// The look of a sample where it was `sampled`: classified, shaded, its opacity that of one step.
    #[inline(always)]
    pub fn look(
        &self,
        shading: &Shading,
        value: F32s<S>,
        position: Vec3s<S>,
        to_eye: Vec3s<S>,
        sampled: Mask<S>,
        last_normal: &mut Vec3s<S>,
    ) -> Look<S> {
        let mut surface = self.classify(value, position, sampled);
        let visible = sampled & F32s::zero().lt(surface.opacity);
        if visible.any() {
            if !shading.is_unlit() {
                surface = self.shade(shading, surface, position, to_eye, visible, last_normal);
            }
            if self.steps_per_reference != 1.0 {
                surface.opacity = self.of_one_step(surface.opacity);
            }
        }
        Look { surface, visible }
    }

    #[inline(never)]
    fn of_one_step(&self, opacity: F32s<S>) -> F32s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || opacity_of_length(opacity, self.steps_per_reference),
        )
    }
}
