//! Which shader functions, with which parameters, a Plan asks for.

use glam::DVec3;
use std::sync::Arc;
use strahl_scene::plan::{
    ClipShape, Fetch, Jitter, Plan, PlanLight, PlanModule, Reconstruct, Sampling, Shade, Technique,
};
use strahl_shader::registry::Function;
use strahl_shader::{Error, Fold, Module, Program, Selection, built_in};

/// The functions of a Plan, and the values of their parameters.
#[derive(Debug)]
pub struct Functions {
    /// The functions, for the linker.
    pub selection: Selection,
    /// Slot, parameter, value; in the order of the functions in their slot.
    values: Vec<Values>,
}

#[derive(Debug)]
struct Values {
    module: Arc<Module>,
    values: Vec<(String, Vec<f64>)>,
}

impl Functions {
    /// The functions of `plan`. `is_filtered` says whether the texture unit interpolates,
    /// `mask_threshold` what a threshold of mask number n is in the numbers of its texture.
    ///
    /// # Errors
    /// If the Plan samples by another rule than the regular one.
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
            values: Vec::new(),
        };
        functions.ray(plan, mask_threshold)?;
        functions.sample(plan, is_filtered)?;
        functions.light(plan)?;
        let composite = plan.technique().composite;
        functions.choose(composite.function(), composite.values())?;
        functions.modules(plan);
        let modules = functions.values.iter().map(|values| values.module.clone());
        functions.selection = modules.fold(Selection::new(), Selection::with);
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
            Jitter::Centre => {}
            Jitter::Hash(seed) => {
                self.put("jitter", "hash", vec![("seed", vec![f64::from(seed)])])?;
            }
            Jitter::SineHash => self.put("jitter", "sine_hash", vec![])?,
            Jitter::WhiteTile(_) | Jitter::BlueTile(_) => self.put("jitter", "tile", vec![])?,
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
        let (field, technique) = (plan.field(), plan.technique());
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
        let Technique {
            classify,
            gradient_input,
            ..
        } = technique;
        self.choose(classify.function(), classify.values())?;
        self.choose(gradient_input.function(), gradient_input.values())?;
        self.choose(field.gradient.function(), field.gradient.values())
    }

    fn light(&mut self, plan: &Plan) -> Result<(), Error> {
        let (ambient, illuminate, keep_last_normal) = match plan.technique().shade {
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
        self.choose(illuminate.function(), illuminate.values())?;
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
