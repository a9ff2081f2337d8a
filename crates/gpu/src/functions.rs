//! Which shader functions, with which parameters, a Plan asks for.

use crate::volume_texture::Storage;
use glam::DVec3;
use std::sync::Arc;
use strahl_scene::plan::{Composite, Gradient, Jitter, Plan, PlanLight, Reconstruct, Shade};
use strahl_shader::{Error, Module, Program, Selection, built_in};

/// The functions of a Plan, and the values of their parameters.
pub struct Functions {
    pub selection: Selection,
    /// Slot, parameter, value; in the order of the functions in their slot.
    values: Vec<Values>,
}

struct Values {
    module: Arc<Module>,
    values: Vec<(&'static str, Vec<f64>)>,
}

impl Functions {
    /// The functions of `plan` over a texture of this storage.
    pub fn of(plan: &Plan, storage: &Storage) -> Result<Functions, Error> {
        let mut functions = Functions {
            selection: Selection::new(),
            values: Vec::new(),
        };
        functions.ray(plan)?;
        functions.sample(plan, storage)?;
        functions.light(plan)?;
        functions.composite(plan)?;
        Ok(functions)
    }

    /// The bytes of the uniform block of `program`, which was linked from these functions.
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
        self.selection = std::mem::take(&mut self.selection).with(module.clone());
        self.values.push(Values { module, values });
        Ok(())
    }

    fn ray(&mut self, plan: &Plan) -> Result<(), Error> {
        for clip in &plan.ray_clips {
            let values = vec![
                ("normal", vector(clip.normal)),
                ("offset_mm", vec![clip.offset_mm]),
            ];
            self.put("clip_ray", "plane", values)?;
        }
        if let Jitter::Hash(seed) = plan.lattice.jitter {
            self.put("jitter", "hash", vec![("seed", vec![f64::from(seed)])])?;
        }
        for clip in &plan.sample_clips {
            let m = clip.unit_from_world;
            let row = |r: usize| {
                let linear = m.matrix3.row(r);
                vec![linear.x, linear.y, linear.z, m.translation[r]]
            };
            let values = vec![
                ("unit_from_world_x", row(0)),
                ("unit_from_world_y", row(1)),
                ("unit_from_world_z", row(2)),
                ("keep_inside", vec![f64::from(u8::from(clip.keep_inside))]),
            ];
            self.put("clip_sample", "box", values)?;
        }
        Ok(())
    }

    fn sample(&mut self, plan: &Plan, storage: &Storage) -> Result<(), Error> {
        self.put("fetch", "texture", vec![])?;
        let reconstruct = match plan.reconstruct {
            Reconstruct::Nearest => "nearest",
            Reconstruct::Trilinear if storage.is_filterable => "trilinear_sampler",
            Reconstruct::Trilinear => "trilinear",
        };
        self.put("reconstruct", reconstruct, vec![])?;
        self.put("classify", "table", vec![])?;
        self.put("gradient_input", "value", vec![])?;
        match plan.gradient {
            Gradient::Central => self.put("gradient", "central", vec![]),
        }
    }

    fn light(&mut self, plan: &Plan) -> Result<(), Error> {
        let Shade::BlinnPhong {
            ambient,
            diffuse,
            specular,
            shininess,
        } = plan.shade
        else {
            return Ok(());
        };
        let one = |v: f32| vec![f64::from(v)];
        self.put("shade", "lit", vec![("ambient", one(ambient))])?;
        let values = vec![
            ("diffuse", one(diffuse)),
            ("specular", one(specular)),
            ("shininess", one(shininess)),
        ];
        self.put("illuminate", "blinn_phong", values)?;
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
                PlanLight::Head { radiance } => {
                    self.put("light", "head", vec![("radiance", color(radiance))])?;
                }
            }
        }
        Ok(())
    }

    fn composite(&mut self, plan: &Plan) -> Result<(), Error> {
        let (name, values) = match plan.composite {
            Composite::EmissionAbsorption {
                stop_at_transmittance,
            } => (
                "front_to_back",
                vec![(
                    "stop_at_transmittance",
                    vec![f64::from(stop_at_transmittance)],
                )],
            ),
            Composite::Mip => ("maximum", vec![]),
            Composite::MinIp => ("minimum", vec![]),
            Composite::Average => ("average", vec![]),
            Composite::FirstHit { threshold } => {
                ("first_hit", vec![("threshold", vec![threshold])])
            }
        };
        self.put("composite", name, values)
    }
}

fn vector(v: DVec3) -> Vec<f64> {
    v.to_array().to_vec()
}
