//! Which shader functions, with which parameters, a Plan asks for.

use glam::DVec3;
use std::sync::Arc;
use strahl_scene::plan::{
    ClipShape, Fetch, Jitter, Plan, PlanLight, PlanModule, Reconstruct, Sampling, Shade, Technique,
};
use strahl_shader::registry::Function;
use strahl_shader::{
    Error, Fold, MOST_MASKS, Module, Parameter, Program, Selection, Slot, TECHNIQUE_SLOTS,
    TechniqueTexels, built_in, slot,
};

/// The functions of a Plan, and the values of their parameters.
#[derive(Debug)]
pub struct Functions {
    /// The functions, for the linker.
    pub selection: Selection,
    /// Techniques among which the segments of the one object choose; 0 if it has no segments.
    pub techniques_of_segments: usize,
    /// Slot, parameter, value; in the order of the functions in their slot.
    values: Vec<Values>,
}

#[derive(Debug)]
struct Values {
    module: Arc<Module>,
    values: Vec<(String, Vec<f64>)>,
}

/// Among which functions the techniques of a Plan choose: of each slot, in the order of their names.
#[derive(Default)]
struct Choices {
    of_slots: Vec<(&'static Slot, Vec<Arc<Module>>)>,
    /// What each technique asks for.
    of_techniques: Vec<Vec<Values>>,
}

impl Choices {
    fn of(plan: &Plan) -> Result<Choices, Error> {
        let mut choices = Choices::default();
        for technique in plan.drawn_techniques() {
            let mut own = Functions {
                selection: Selection::new(),
                techniques_of_segments: 0,
                values: Vec::new(),
            };
            own.technique(technique)?;
            if plan.labeled().is_some() {
                let composite = technique.composite;
                own.choose(composite.function(), composite.values())?;
            }
            choices.of_techniques.push(own.values);
        }
        for name in TECHNIQUE_SLOTS {
            let Some(slot) = slot(name) else { continue };
            let all = choices.of_techniques.iter().flatten();
            let mut modules: Vec<_> = all
                .filter(|values| values.module.slot() == slot)
                .map(|values| values.module.clone())
                .collect();
            modules.sort_by(|a, b| a.name().cmp(b.name()));
            modules.dedup_by(|a, b| Arc::ptr_eq(a, b));
            choices.of_slots.push((slot, modules));
        }
        Ok(choices)
    }
}

/// Chooses the functions of the techniques among which the samples of `plan` choose.
///
/// # Errors
/// None for a Plan that `resolve` made.
pub(crate) fn choose(plan: &Plan, techniques: &mut [TechniqueTexels]) -> Result<(), Error> {
    let choices = Choices::of(plan)?;
    for (texels, values) in techniques.iter_mut().zip(&choices.of_techniques) {
        for (slot, modules) in &choices.of_slots {
            let own = values.iter().find(|values| values.module.slot() == *slot);
            let numbers = own.map(Values::numbers).unwrap_or_default();
            let is_own =
                |module: &Arc<Module>| own.is_some_and(|own| Arc::ptr_eq(&own.module, module));
            let function = modules.iter().position(is_own).unwrap_or(modules.len());
            texels.choose(slot, function, &numbers);
        }
    }
    Ok(())
}

impl Values {
    /// The values of all parameters, in their order.
    fn numbers(&self) -> Vec<f64> {
        let value = |parameter: &Parameter| {
            let given = self.values.iter().find(|(name, _)| *name == parameter.name);
            given.map_or_else(|| parameter.default.to_vec(), |(_, value)| value.clone())
        };
        self.module.parameters().iter().flat_map(value).collect()
    }
}

impl Functions {
    /// The functions of `plan`. `is_filtered` says whether the texture unit interpolates,
    /// `mask_threshold` what a threshold of mask number n is in the numbers of its texture.
    ///
    /// # Errors
    /// If the Plan samples by another rule than the regular one, or has more masks than programs have.
    pub fn of(
        plan: &Plan,
        is_filtered: bool,
        mask_threshold: impl Fn(usize, f32) -> f64,
    ) -> Result<Functions, Error> {
        if plan.sampling != Sampling::Regular {
            let rule = plan.sampling.name();
            return Err(Error::Sampling { rule });
        }
        let mut functions = Functions {
            selection: Selection::new(),
            techniques_of_segments: plan.labeled().map_or(0, |_| plan.techniques.len()),
            values: Vec::new(),
        };
        functions.ray(plan, mask_threshold)?;
        functions.sample(plan, is_filtered)?;
        let choices = if plan.has_one_technique() {
            functions.technique(plan.technique())?;
            Choices::default()
        } else {
            Choices::of(plan)?
        };
        functions.light(plan)?;
        if plan.labeled().is_none() {
            let composite = plan.technique().composite;
            functions.choose(composite.function(), composite.values())?;
        }
        functions.modules(plan);
        let modules = functions.values.iter().map(|values| values.module.clone());
        let selection = modules.fold(Selection::new(), Selection::with);
        let choices = choices.of_slots.into_iter();
        functions.selection = choices.fold(selection, |selection, (slot, modules)| {
            // A function of the user takes the place of all.
            match selection.of(slot) {
                [] if !modules.is_empty() => selection.with_choice(slot, modules),
                _ => selection,
            }
        });
        Ok(functions)
    }

    /// The bytes of the uniform block of `program`, which was linked from these functions.
    ///
    /// # Errors
    /// A value that its parameter cannot take; none for a Plan that `resolve` made.
    pub fn parameters(&self, program: &Program) -> Result<Vec<u8>, Error> {
        let mut bytes = program.default_parameters();
        let mut used = vec![false; self.values.len()];
        for block in program.blocks() {
            // Blocks come in the order of the slots and of the functions in them.
            let next = self
                .values
                .iter()
                .enumerate()
                .position(|(i, v)| !used[i] && Arc::ptr_eq(&v.module, &block.module));
            let Some(next) = next else { continue };
            used[next] = true;
            for (parameter, value) in &self.values[next].values {
                program.set(&mut bytes, &block.label, parameter, value)?;
            }
        }
        Ok(bytes)
    }

    fn put(
        &mut self,
        slot: &str,
        name: &str,
        values: Vec<(&'static str, Vec<f64>)>,
    ) -> Result<(), Error> {
        let module = built_in(slot, name)?;
        let named = |(name, value): (&str, Vec<f64>)| (name.to_owned(), value);
        self.values.push(Values {
            module,
            values: values.into_iter().map(named).collect(),
        });
        Ok(())
    }

    /// A function that the Plan names as such.
    fn choose(
        &mut self,
        function: &Function,
        values: Vec<(&'static str, f64)>,
    ) -> Result<(), Error> {
        let values = values.into_iter().map(|(name, value)| (name, vec![value]));
        self.put(function.slot, function.name, values.collect())
    }

    fn ray(
        &mut self,
        plan: &Plan,
        mask_threshold: impl Fn(usize, f32) -> f64,
    ) -> Result<(), Error> {
        for clip in &plan.ray_clips {
            let values = vec![
                ("normal", vector(clip.normal)),
                ("offset_mm", vec![clip.offset_mm]),
                ("objects", vec![f64::from(clip.layers)]),
            ];
            self.put("clip_ray", "plane", values)?;
        }
        if !plan.meshes.is_empty() {
            self.put("clip_ray", "depth", vec![])?;
        }
        match plan.lattice.jitter {
            Jitter::Center => {}
            Jitter::Hash(seed) => {
                self.put("jitter", "hash", vec![("seed", vec![f64::from(seed)])])?;
            }
            Jitter::SineHash => self.put("jitter", "sine_hash", vec![])?,
            Jitter::WhiteTile(_) | Jitter::BlueTile(_) => self.put("jitter", "tile", vec![])?,
        }
        let masks = plan.sample_clips.iter().map(|clip| match clip.shape {
            ClipShape::Mask { mask, .. } => mask + 1,
            _ => 0,
        });
        let of_importance = plan.importance.iter().map(|importance| importance.mask + 1);
        let number = masks.chain(of_importance).max().unwrap_or(0);
        if number > MOST_MASKS {
            let most = MOST_MASKS;
            return Err(Error::Masks { number, most });
        }
        for clip in &plan.sample_clips {
            let m = clip.unit_from_world;
            let row = |r: usize| {
                let linear = m.matrix3.row(r);
                vec![linear.x, linear.y, linear.z, m.translation[r]]
            };
            let mut values = vec![
                ("unit_from_world_x", row(0)),
                ("unit_from_world_y", row(1)),
                ("unit_from_world_z", row(2)),
                ("keep_inside", vec![f64::from(u8::from(clip.keep_inside))]),
                ("objects", vec![f64::from(clip.layers)]),
            ];
            let name = match clip.shape {
                ClipShape::Box => "box",
                ClipShape::Ellipsoid => "ellipsoid",
                ClipShape::Cylinder => "cylinder",
                ClipShape::Mask { mask, threshold } => {
                    values.push(("mask", vec![mask as f64]));
                    values.push(("threshold", vec![mask_threshold(mask, threshold)]));
                    "mask"
                }
            };
            self.put("clip_sample", name, values)?;
        }
        Ok(())
    }

    fn sample(&mut self, plan: &Plan, is_filtered: bool) -> Result<(), Error> {
        let field = plan.field();
        self.choose(field.fetch.function(), field.fetch.values())?;
        // The texture unit knows what is stored only.
        let has_own_fetch = plan.modules.iter().any(|m| m.module.slot().name == "fetch");
        let filtered = is_filtered && field.fetch == Fetch::Stored && !has_own_fetch;
        let reconstruct = match field.reconstruct {
            Reconstruct::Trilinear if filtered => "trilinear_sampler",
            // The texture holds coefficients if the spline shall interpolate.
            Reconstruct::BSpline | Reconstruct::BSplineInterpolating if filtered => {
                "b_spline_sampler"
            }
            way => way.function().name,
        };
        self.put("reconstruct", reconstruct, vec![])?;
        self.choose(field.gradient.function(), field.gradient.values())
    }

    /// What `technique` alone asks for, but its composite.
    fn technique(&mut self, technique: &Technique) -> Result<(), Error> {
        let Technique {
            classify,
            gradient_input,
            ..
        } = technique;
        self.choose(classify.function(), classify.values())?;
        self.choose(gradient_input.function(), gradient_input.values())?;
        if let Some(function) = technique.illustrate.function() {
            self.choose(function, technique.illustrate.values())?;
        }
        let (ambient, illuminate, keep_last_normal) = match technique.shade {
            Shade::Lit {
                ambient,
                illuminate,
                keep_last_normal,
            } => (ambient, illuminate, keep_last_normal),
            other => {
                return other
                    .function()
                    .map_or(Ok(()), |f| self.choose(f, other.values()));
            }
        };
        let shade = if keep_last_normal {
            "lit_last_normal"
        } else {
            "lit"
        };
        self.put("shade", shade, vec![("ambient", one(ambient))])?;
        self.choose(illuminate.function(), illuminate.values())
    }

    /// The lights, if anything but meshes is lit.
    fn light(&mut self, plan: &Plan) -> Result<(), Error> {
        let is_lit = |technique: &Technique| matches!(technique.shade, Shade::Lit { .. });
        if !plan.drawn_techniques().any(is_lit) {
            return Ok(());
        }
        for light in &plan.lights {
            let color = |c: [f32; 3]| c.map(f64::from).to_vec();
            match *light {
                PlanLight::Directional { to_light, radiance } => self.put(
                    "light",
                    "directional",
                    vec![
                        ("to_light", vector(to_light)),
                        ("radiance", color(radiance)),
                    ],
                )?,
                PlanLight::Point {
                    place_mm,
                    reach_mm,
                    radiance,
                } => self.put(
                    "light",
                    "point",
                    vec![
                        ("place_mm", vector(place_mm)),
                        ("reach_mm", one(reach_mm)),
                        ("radiance", color(radiance)),
                    ],
                )?,
                PlanLight::Head { radiance } => {
                    self.put("light", "head", vec![("radiance", color(radiance))])?;
                }
            }
        }
        Ok(())
    }

    /// The user's own functions: each takes the place of what stands in its slot; where several
    /// functions stand together it comes last.
    fn modules(&mut self, plan: &Plan) {
        for PlanModule { module, values } in &plan.modules {
            if module.slot().fold == Fold::One {
                self.values
                    .retain(|values| values.module.slot() != module.slot());
            }
            self.values.push(Values {
                module: module.clone(),
                values: values.clone(),
            });
        }
    }
}

fn one(v: f32) -> Vec<f64> {
    vec![f64::from(v)]
}

fn vector(v: DVec3) -> Vec<f64> {
    v.to_array().to_vec()
}
