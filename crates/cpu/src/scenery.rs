//! A Plan with everything prepared that is the same for all rays.

use crate::elementary::opacity_of_length;
use crate::lanes::{Affine, F32s, Mask, Vec3s};
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
pub struct Scenery<'p> {
    pub plan: &'p Plan,
    pub objects: Vec<Object<'p>>,
    pub shading: Shading,
    pub jitters: Jitters,
    pub meshes: &'p Meshes,
}

/// A volume in the picture.
pub struct Object<'p> {
    pub values: &'p dyn Values,
    pub clips: SampleClips<'p>,
    pub table: Table<'p>,
    pub gradients: Gradients,
    pub skip: Option<Skip>,
    classify: Classify,
    /// step/reference, the exponent of the opacity correction.
    steps_per_reference: f32,
    world_from_voxel: Affine,
}

/// The look of a sample: opacity of one step.
pub struct Look {
    pub surface: Surface,
    /// Where it is not transparent.
    pub visible: Mask,
}

impl<'p> Object<'p> {
    /// Object number `object` of `plan`.
    pub fn new(
        plan: &'p Plan,
        object: usize,
        values: &'p dyn Values,
        masks: &'p [Box<dyn Values + 'p>],
        skip: Option<Skip>,
    ) -> Object<'p> {
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

    /// Slot classify.
    #[inline(always)]
    pub fn classify(&self, value: F32s, position: Vec3s) -> Surface {
        classify(
            self.classify,
            &self.table,
            &self.gradients,
            self.values,
            value,
            position,
        )
    }

    /// Slot gradient over slot gradient_input.
    pub fn gradient(&self, position: Vec3s) -> Vec3s {
        match self.gradients.input() {
            GradientInput::Value => self.gradients.of_values(self.values, position),
            GradientInput::Opacity => {
                let opacity = |at: Vec3s| self.classify(self.values.at(at), at).opacity;
                self.gradients.of(&opacity, position)
            }
        }
    }

    /// Slot shade: `surface` under the lights, its opacity still that of the reference length.
    #[inline(never)]
    pub fn shade(
        &self,
        shading: &Shading,
        surface: Surface,
        position: Vec3s,
        to_eye: Vec3s,
        shaded: Mask,
        last_normal: &mut Vec3s,
    ) -> Surface {
        let place = Place {
            gradient: &|| self.gradient(position),
            place_mm: &|| self.world_from_voxel.point(position),
            to_eye,
        };
        shading.look(surface, &place, shaded, last_normal)
    }

    /// The look of a sample where it was `sampled`: classified, shaded, its opacity that of one step.
    #[inline(always)]
    pub fn look(
        &self,
        shading: &Shading,
        value: F32s,
        position: Vec3s,
        to_eye: Vec3s,
        sampled: Mask,
        last_normal: &mut Vec3s,
    ) -> Look {
        let mut surface = self.classify(value, position);
        let visible = sampled & F32s::ZERO.lt(surface.opacity);
        if visible.any() {
            surface = self.shade(shading, surface, position, to_eye, visible, last_normal);
            if self.steps_per_reference != 1.0 {
                surface.opacity = opacity_of_length(surface.opacity, self.steps_per_reference);
            }
        }
        Look { surface, visible }
    }
}
