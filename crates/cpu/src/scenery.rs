//! A Plan with everything prepared that is the same for all rays.

use crate::elementary::{opacity_of_half, opacity_of_length, opacity_of_lengths};
use crate::even::EvenCubes;
use crate::important_places::ImportantPlaces;
use crate::lanes::{Affine, F32s, Mask, Vec3s, dot, each, splat3};
use crate::levels::{Level, inlined, vectorized};
use crate::library::classify::{Integrals, IntervalVisibility, Sample, Surface, Table, classify};
use crate::library::clip_sample::SampleClips;
use crate::library::fetch::Linear;
use crate::library::gradient::Gradients;
use crate::library::illustrate::{IllustratedPlace, illustrate};
use crate::library::jitter::Jitters;
use crate::library::reconstruct::Values;
use crate::library::shade::{Place, Shading};
use crate::meshes::Meshes;
use crate::outline::Outline;
use crate::rejection::Rejection;
use crate::segment_looks::SegmentLooks;
use crate::segment_numbers::SegmentNumbers;
use crate::skip::Skip;
use crate::strides::{Strides, of_stride};
use std::cell::Cell;
use std::sync::Arc;
use strahl_scene::plan::{Classify, Composite, GradientInput, Plan, Technique};
use strahl_volume::{Grid, Samples};

/// The functions in the slots, with what they read.
pub struct Scenery<'p, S: Level> {
    pub plan: &'p Plan,
    /// Of the whole: that of the one technique, or how runs of segments add up.
    pub composite: Composite,
    /// One for each layer; where there are segments, one for each technique, all of the same field.
    pub objects: Vec<Object<'p, S>>,
    /// The segments of the layer, where those of a label volume are drawn.
    pub segments: Option<Arc<SegmentNumbers<'p>>>,
    /// Their looks, where a loop of its own can draw them.
    pub looks: Option<SegmentLooks>,
    /// How important places are, where that is data.
    pub important_places: Option<ImportantPlaces<'p, S>>,
    pub jitters: Jitters,
    pub meshes: &'p Meshes,
    /// Outside of it nothing is to be seen; where that is known and rays may be left out.
    pub outline: Option<Outline>,
}

/// A volume in the picture.
pub struct Object<'p, S: Level> {
    pub values: &'p dyn Values<S>,
    /// The voxels behind them, where a loop can read them itself.
    pub stored: Option<Stored<'p>>,
    pub clips: SampleClips<'p, S>,
    pub table: Table<'p>,
    pub gradients: Gradients,
    gradient_input: GradientInput,
    /// Those that gradients of segments are found in.
    segments: Option<Arc<SegmentNumbers<'p>>>,
    pub skip: Option<Skip>,
    /// Which samples need not be reconstructed, where that takes many voxels.
    pub rejection: Option<Rejection>,
    /// Where one sample can stand for several; where the Plan's sampling is adaptive.
    pub even: Option<EvenCubes>,
    /// For how many lattice points a sample stands; where the Plan's sampling is by opacity.
    pub strides: Option<Strides>,
    /// Whether anything is shown between two values; where the Plan's sampling is of segments.
    pub between: Option<IntervalVisibility>,
    /// What is shown between two values; where the Plan's sampling is integrated.
    pub integrals: Option<Arc<Integrals>>,
    classify: Classify,
    pub composite: Composite,
    pub shading: Shading,
    /// Of the values from stored numbers: slope and intercept.
    rescale: [f32; 2],
    /// (Part of a) step/reference, the exponent of the opacity correction.
    steps_per_reference: f32,
    world_from_voxel: Affine,
    voxel_from_world: Affine,
    /// Voxels along each axis.
    dims: [f32; 3],
    /// The place of the eye and the direction of view, in the world.
    view: [[f32; 3]; 2],
}

/// What is known of an object, as [`Object`] has it.
#[derive(Default)]
pub struct Known<'p> {
    pub segments: Option<Arc<SegmentNumbers<'p>>>,
    pub skip: Option<Skip>,
    pub rejection: Option<Rejection>,
    pub even: Option<EvenCubes>,
    pub strides: Option<Strides>,
    pub integrals: Option<Arc<Integrals>>,
}

/// A half and a whole are worked out faster; lengths in single precision are not exactly that.
fn steps_per_reference(step_mm: f64, reference_mm: f32) -> f32 {
    let steps = step_mm / f64::from(reference_mm);
    let is_near = |number: &f64| (steps - number).abs() < 1e-6;
    [0.5, 1.0].into_iter().find(is_near).unwrap_or(steps) as f32
}

/// Voxels of the types that scans and simulations have.
pub enum Stored<'v> {
    U8(Linear<'v, u8>),
    U16(Linear<'v, u16>),
    I16(Linear<'v, i16>),
    F32(Linear<'v, f32>),
}

impl<'v> Stored<'v> {
    /// The voxels of `grid`; `None` for other types.
    pub fn new(grid: &Grid, samples: &'v Samples) -> Option<Stored<'v>> {
        Some(match samples {
            Samples::U8(samples) => Stored::U8(Linear::new(grid, samples)),
            Samples::U16(samples) => Stored::U16(Linear::new(grid, samples)),
            Samples::I16(samples) => Stored::I16(Linear::new(grid, samples)),
            Samples::F32(samples) => Stored::F32(Linear::new(grid, samples)),
            _ => return None,
        })
    }
}

/// Where a sample of an object is illustrated.
struct PlaceOfObject<'o, 'p, S: Level> {
    object: &'o Object<'p, S>,
    gradient: Vec3s<S>,
    position: Vec3s<S>,
    /// A position in the segment that the sample belongs to.
    anchor: Vec3s<S>,
    to_eye: Vec3s<S>,
    shaded: Mask<S>,
    /// The segment that it is in, once somebody has asked.
    segment: Cell<Option<F32s<S>>>,
}

impl<S: Level> PlaceOfObject<'_, '_, S> {
    /// The position in voxel space that is `offset_mm` away.
    #[inline(always)]
    fn beside(&self, offset_mm: Vec3s<S>) -> Vec3s<S> {
        let place = self.object.place_mm(self.position);
        let beside = each!([0, 1, 2], |c| place[c] + offset_mm[c]);
        self.object.voxel_from_world.point(beside)
    }
}

impl<S: Level> IllustratedPlace<S> for PlaceOfObject<'_, '_, S> {
    #[inline(always)]
    fn to_eye(&self) -> Vec3s<S> {
        self.to_eye
    }

    #[inline(always)]
    fn gradient(&self) -> Vec3s<S> {
        self.gradient
    }

    #[inline(always)]
    fn gradient_beside(&self, offset_mm: Vec3s<S>) -> Vec3s<S> {
        let position = self.beside(offset_mm);
        self.object
            .gradient_within(position, self.anchor, self.shaded)
    }

    #[inline(always)]
    fn opacity_beside(&self, offset_mm: Vec3s<S>) -> F32s<S> {
        let position = self.beside(offset_mm);
        let mut inside = self.shaded;
        for (at, voxels) in position.into_iter().zip(self.object.dims) {
            let [first, last] = [-0.5, voxels - 0.5].map(F32s::splat);
            inside = inside & first.le(at) & at.le(last);
        }
        if !inside.any() {
            return F32s::zero();
        }
        let mut opacity = self.object.opacity_at(position, inside);
        if let Some(segments) = &self.object.segments {
            let here = self.segment.get();
            let here = here.unwrap_or_else(|| segments.at(self.anchor, self.shaded));
            self.segment.set(Some(here));
            opacity = opacity * segments.membership(position, here);
        }
        inside.select(opacity, F32s::zero())
    }

    #[inline(always)]
    fn depth_mm(&self) -> F32s<S> {
        let place = self.object.place_mm(self.position);
        let [eye, forward] = self.object.view;
        dot(
            each!([0, 1, 2], |c| place[c] - F32s::splat(eye[c])),
            splat3(forward),
        )
    }
}

/// The look of a sample: opacity of one step.
pub struct Look<S: Level> {
    pub surface: Surface<S>,
    /// Where it is not transparent.
    pub visible: Mask<S>,
}

impl<S: Level> Look<S> {
    /// That of no sample.
    #[inline(always)]
    pub fn nothing() -> Look<S> {
        Look {
            surface: Surface {
                color: [F32s::zero(); 3],
                opacity: F32s::zero(),
            },
            visible: Mask::none(),
        }
    }
}

impl<'p, S: Level> Object<'p, S> {
    /// Layer number `layer` of `plan`, drawn by `technique`.
    pub fn new(
        plan: &'p Plan,
        layer: usize,
        technique: &'p Technique,
        values: &'p dyn Values<S>,
        stored: Option<Stored<'p>>,
        masks: &'p [Box<dyn Values<S> + 'p>],
        known: Known<'p>,
    ) -> Object<'p, S> {
        let Known {
            segments,
            skip,
            rejection,
            even,
            strides,
            integrals,
        } = known;
        let field = plan.field_of(layer);
        let table = &technique.table;
        let part_mm = plan.lattice.step_mm / f64::from(plan.sampling.parts());
        Object {
            values,
            stored,
            rescale: [field.rescale.slope, field.rescale.intercept].map(|number| number as f32),
            clips: SampleClips::new(plan, layer, &field.grid, masks),
            table: Table::new(table),
            gradients: Gradients::new(field.gradient, &field.grid),
            gradient_input: technique.gradient_input,
            segments,
            skip,
            rejection,
            even,
            strides,
            between: plan
                .sampling
                .is_of_segments()
                .then(|| IntervalVisibility::new(technique.classify, table)),
            integrals,
            classify: technique.classify,
            composite: technique.composite,
            shading: Shading::new(technique, plan),
            steps_per_reference: steps_per_reference(part_mm, table.reference_mm()),
            world_from_voxel: Affine::new(field.grid.world_from_voxel()),
            voxel_from_world: Affine::new(field.grid.voxel_from_world()),
            dims: field.grid.dims().map(|n| n as f32),
            view: [plan.camera.eye_mm, plan.camera.forward].map(|v| v.as_vec3().to_array()),
        }
    }

    /// The voxels, if `through_voxels` gives what `forwards` does: trilinear values and no clips of samples; for
    /// emission and absorption a table, and shading that asks for nothing of earlier samples and leaves the
    /// opacity as it is.
    pub fn stored_for(&self, composite: Composite) -> Option<&Stored<'p>> {
        let fits = match composite {
            Composite::EmissionAbsorption { .. } => self.is_of_single_samples(),
            Composite::FirstHit { .. }
            | Composite::Mida { .. }
            | Composite::ContextPreserving { .. }
            | Composite::ImportanceAware { .. } => true,
            _ => false,
        };
        let skips = self.skip.as_ref().is_none_or(Skip::has_cubes);
        self.stored
            .as_ref()
            .filter(|_| fits && skips && self.clips.is_empty())
    }

    /// Whether samples have the opacity that a table gives them, and need nothing of earlier ones.
    pub fn is_of_single_samples(&self) -> bool {
        self.classify == Classify::Table && self.shading.is_of_single_samples()
    }

    /// Whether such samples may be lit later than their opacities add up.
    pub fn is_lit_apart(&self) -> bool {
        self.is_of_single_samples() && !self.shading.is_unlit()
    }

    /// The value of a stored number.
    #[inline(always)]
    pub fn rescaled(&self, stored: F32s<S>) -> F32s<S> {
        let [slope, intercept] = self.rescale;
        stored * F32s::splat(slope) + F32s::splat(intercept)
    }

    /// The place of `position` (voxel space) in the world.
    #[inline(always)]
    pub fn place_mm(&self, position: Vec3s<S>) -> Vec3s<S> {
        self.world_from_voxel.point(position)
    }

    /// The opacity of a step of one of the reference length.
    #[inline(always)]
    pub fn of_step(&self, opacity: F32s<S>) -> F32s<S> {
        if self.steps_per_reference == 1.0 {
            opacity
        } else if self.steps_per_reference == 0.5 {
            opacity_of_half(opacity)
        } else {
            self.of_one_step(opacity)
        }
    }

    /// The opacity of as many steps as a stride has, from that of one; where there are no strides, that of one.
    #[inline(always)]
    pub fn of_stride(&self, opacity: F32s<S>, stride: F32s<S>) -> F32s<S> {
        if self.strides.is_some() {
            of_stride(opacity, stride)
        } else {
            opacity
        }
    }

    /// Which samples of those `asked` may be seen, as far as that is known without reconstructing them; see
    /// [`Rejection::may_be_seen`].
    #[inline(always)]
    pub fn unless_rejected(&self, position: Vec3s<S>, so_far: F32s<S>, asked: Mask<S>) -> Mask<S> {
        match &self.rejection {
            Some(rejection) => rejection.may_be_seen(self.values, position, so_far, asked),
            None => asked,
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
            || classify(self.classify, &self.sample(value, position, asked)),
        )
    }

    #[inline(always)]
    fn sample(&self, value: F32s<S>, position: Vec3s<S>, asked: Mask<S>) -> Sample<'_, S> {
        Sample {
            value,
            position,
            asked,
            table: &self.table,
            gradients: &self.gradients,
            values: self.values,
            gradient: Cell::new(None),
        }
    }

    /// Slot gradient over slot gradient_input, where `asked`; anything elsewhere.
    #[inline(never)]
    pub fn gradient(&self, position: Vec3s<S>, asked: Mask<S>) -> Vec3s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || match self.gradient_input {
                GradientInput::Value => self.gradients.of_values(self.values, position, asked),
                GradientInput::Opacity => {
                    let opacity = |at| self.opacity_at(at, asked);
                    self.gradients.of(&opacity, position)
                }
                GradientInput::Segment => self.gradient_of_segment(position, position, asked),
            },
        )
    }

    /// The same for a sample that belongs to the segment at `anchor`.
    #[inline(never)]
    fn gradient_within(&self, position: Vec3s<S>, anchor: Vec3s<S>, asked: Mask<S>) -> Vec3s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || match self.gradient_input {
                GradientInput::Segment => self.gradient_of_segment(position, anchor, asked),
                _ => self.gradient(position, asked),
            },
        )
    }

    /// The gradient of the membership of the segment at `anchor`.
    #[inline(always)]
    fn gradient_of_segment(
        &self,
        position: Vec3s<S>,
        anchor: Vec3s<S>,
        asked: Mask<S>,
    ) -> Vec3s<S> {
        let Some(segments) = &self.segments else {
            // Everything is one.
            return [F32s::zero(); 3];
        };
        let here = segments.at(anchor, asked);
        let membership = |at| segments.membership(at, here);
        let gradients = &self.gradients;
        let by_voxels = segments.gradient(gradients.method, position, here, asked);
        match by_voxels {
            Some((in_voxel, within)) if !(asked & !within).any() => gradients.in_world(in_voxel),
            Some((in_voxel, within)) => {
                let by_taps = gradients.of(&membership, position);
                within.select3(gradients.in_world(in_voxel), by_taps)
            }
            None => gradients.of(&membership, position),
        }
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
        surface: Surface<S>,
        position: Vec3s<S>,
        to_eye: Vec3s<S>,
        shaded: Mask<S>,
        last_normal: &mut Vec3s<S>,
    ) -> Surface<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                if self.shading.is_illustrated_by_gradient() {
                    // Asked for once, for both.
                    let gradient = self.gradient(position, shaded);
                    let known = || gradient;
                    return self.shade_here(surface, known, position, to_eye, shaded, last_normal);
                }
                let gradient = || self.gradient(position, shaded);
                self.shade_here(surface, gradient, position, to_eye, shaded, last_normal)
            },
        )
    }

    /// The same for a gradient that is known.
    #[inline(never)]
    pub fn shade_by(
        &self,
        surface: Surface<S>,
        gradient: Vec3s<S>,
        position: Vec3s<S>,
        to_eye: Vec3s<S>,
        shaded: Mask<S>,
        last_normal: &mut Vec3s<S>,
    ) -> Surface<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || self.shade_here(surface, || gradient, position, to_eye, shaded, last_normal),
        )
    }

    #[inline(always)]
    fn shade_here(
        &self,
        surface: Surface<S>,
        gradient: impl Fn() -> Vec3s<S>,
        position: Vec3s<S>,
        to_eye: Vec3s<S>,
        shaded: Mask<S>,
        last_normal: &mut Vec3s<S>,
    ) -> Surface<S> {
        let mut seen = self.light(surface, &gradient, position, to_eye, shaded, last_normal);
        if self.shading.is_illustrated() {
            let gradient = match self.shading.is_illustrated_by_gradient() {
                true => gradient(),
                false => [F32s::zero(); 3],
            };
            let places = [position; 2];
            seen.color = self.illustrate(seen.color, gradient, places, to_eye, shaded);
        }
        seen
    }

    /// Slot shade, for a sample that belongs to the segment at `anchor`.
    #[inline(always)]
    pub fn shade_within(
        &self,
        surface: Surface<S>,
        [position, anchor]: [Vec3s<S>; 2],
        to_eye: Vec3s<S>,
        shaded: Mask<S>,
        last_normal: &mut Vec3s<S>,
    ) -> Surface<S> {
        if self.segments.is_none() || self.shading.is_unlit() {
            return self.shade(surface, position, to_eye, shaded, last_normal);
        }
        let gradient = self.gradient_within(position, anchor, shaded);
        let mut seen = self.light_by(surface, gradient, position, to_eye, shaded, last_normal);
        if self.shading.is_illustrated() {
            let places = [position, anchor];
            seen.color = self.illustrate(seen.color, gradient, places, to_eye, shaded);
        }
        seen
    }

    /// Slot shade without illustration, for a gradient that is known.
    #[inline(never)]
    pub fn light_by(
        &self,
        surface: Surface<S>,
        gradient: Vec3s<S>,
        position: Vec3s<S>,
        to_eye: Vec3s<S>,
        shaded: Mask<S>,
        last_normal: &mut Vec3s<S>,
    ) -> Surface<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || self.light(surface, || gradient, position, to_eye, shaded, last_normal),
        )
    }

    /// Slot shade without illustration.
    #[inline(always)]
    fn light(
        &self,
        surface: Surface<S>,
        gradient: impl Fn() -> Vec3s<S>,
        position: Vec3s<S>,
        to_eye: Vec3s<S>,
        shaded: Mask<S>,
        last_normal: &mut Vec3s<S>,
    ) -> Surface<S> {
        let place = Place {
            gradient,
            place_mm: || self.place_mm(position),
            to_eye,
        };
        self.shading.look(surface, &place, shaded, last_normal)
    }

    /// Slot illustrate, where `shaded`: the color of a sample with this gradient, at a position, and a position in the
    /// segment that it belongs to.
    #[inline(never)]
    pub fn illustrate(
        &self,
        color: Vec3s<S>,
        gradient: Vec3s<S>,
        [position, anchor]: [Vec3s<S>; 2],
        to_eye: Vec3s<S>,
        shaded: Mask<S>,
    ) -> Vec3s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let place = PlaceOfObject {
                    object: self,
                    gradient,
                    position,
                    anchor,
                    to_eye,
                    shaded,
                    segment: Cell::new(None),
                };
                illustrate(self.shading.illustration, color, &place)
            },
        )
    }

    /// The look of a sample where it was `sampled`: classified, shaded, its opacity that of one step.
    #[inline(always)]
    pub fn look(
        &self,
        value: F32s<S>,
        position: Vec3s<S>,
        to_eye: Vec3s<S>,
        sampled: Mask<S>,
        last_normal: &mut Vec3s<S>,
    ) -> Look<S> {
        // Calls are given a copy: without the address of a part of the state, this may stay in registers.
        let mut normal = *last_normal;
        if !matches!(self.classify, Classify::Table) {
            let look = self.look_otherwise(value, position, to_eye, sampled, &mut normal);
            *last_normal = normal;
            return look;
        }
        // Most samples show nothing, and colors are most of what the table costs.
        let visible = sampled & F32s::zero().lt(self.table.opacity_at(value));
        if !visible.any() {
            return Look::nothing();
        }
        let mut surface = self.table.at(value);
        if !self.shading.is_unlit() {
            surface = self.shade(surface, position, to_eye, visible, &mut normal);
            *last_normal = normal;
        }
        surface.opacity = self.of_step(surface.opacity);
        Look { surface, visible }
    }

    /// By another classification than a table over the value. A gradient that it asks for is not looked for again.
    #[inline(never)]
    fn look_otherwise(
        &self,
        value: F32s<S>,
        position: Vec3s<S>,
        to_eye: Vec3s<S>,
        sampled: Mask<S>,
        last_normal: &mut Vec3s<S>,
    ) -> Look<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let sample = self.sample(value, position, sampled);
                let mut surface = classify(self.classify, &sample);
                let visible = sampled & F32s::zero().lt(surface.opacity);
                if visible.any() {
                    let is_shaded_by_it = self.gradient_input == GradientInput::Value;
                    let gradient = sample.gradient.get().filter(|_| is_shaded_by_it);
                    surface = match gradient {
                        _ if self.shading.is_unlit() => surface,
                        Some(gradient) => {
                            self.shade_by(surface, gradient, position, to_eye, visible, last_normal)
                        }
                        None => self.shade(surface, position, to_eye, visible, last_normal),
                    };
                    surface.opacity = self.of_step(surface.opacity);
                }
                Look { surface, visible }
            },
        )
    }

    /// The look of a sample whose value and gradient are known from samples beside it, as [`look`](Self::look).
    #[inline(always)]
    pub fn look_by(
        &self,
        value: F32s<S>,
        gradient: Vec3s<S>,
        position: Vec3s<S>,
        to_eye: Vec3s<S>,
        sampled: Mask<S>,
        last_normal: &mut Vec3s<S>,
    ) -> Look<S> {
        let mut surface = self.classify(value, position, sampled);
        let visible = sampled & F32s::zero().lt(surface.opacity);
        if visible.any() {
            if !self.shading.is_unlit() {
                surface =
                    self.shade_here(surface, || gradient, position, to_eye, visible, last_normal);
            }
            surface.opacity = self.of_step(surface.opacity);
        }
        Look { surface, visible }
    }

    /// The look of `share` of a segment with these values at its `ends`, as [`look`](Self::look) at its middle.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "what a look is made of")]
    pub fn look_of_segment(
        &self,
        integrals: &Integrals,
        ends: [F32s<S>; 2],
        share: F32s<S>,
        position: Vec3s<S>,
        to_eye: Vec3s<S>,
        sampled: Mask<S>,
        last_normal: &mut Vec3s<S>,
    ) -> Look<S> {
        let of_length = inlined(
            #[inline(always)]
            |opacity: F32s<S>| self.of_steps(opacity, share),
        );
        let mut surface = integrals.between(&self.table, ends, of_length, sampled);
        let visible = sampled & F32s::zero().lt(surface.opacity);
        if visible.any() {
            if !self.shading.is_unlit() {
                surface = self.shade(surface, position, to_eye, visible, last_normal);
            }
            surface.opacity = self.of_steps(surface.opacity, share);
        }
        Look { surface, visible }
    }

    /// The opacity of `steps` steps for that of the reference length.
    #[inline(always)]
    pub fn of_steps(&self, opacity: F32s<S>, steps: F32s<S>) -> F32s<S> {
        let exponent = F32s::splat(self.steps_per_reference) * steps;
        let one = F32s::splat(1.0);
        // The reference length itself is not worked out, as for single steps.
        exponent
            .eq(one)
            .select(opacity, opacity_of_lengths(opacity, exponent))
    }

    #[inline(never)]
    fn of_one_step(&self, opacity: F32s<S>) -> F32s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || opacity_of_length(opacity, self.steps_per_reference),
        )
    }
}
