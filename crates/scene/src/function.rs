//! Shader functions that a scene names: those of the library by their names, a user's own by file.

use crate::nearest::nearest;
use crate::plan::{
    Classify, Composite, DebugView, Fetch, GradientInput, GradientMethod, Illuminate, Jitter, Plan,
    PlanModule, Reconstruct, Shade,
};
use crate::problem::{Checker, Number};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;
use strahl_shader::{Module, SLOTS, built_in};

/// A shader function, and values for its parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FunctionUse {
    /// The name of a function of the library (`strahl shader list`), or a `.wgsl` file relative to the
    /// folder of the scene file.
    pub module: String,
    /// Values of its parameters; those that are not said have their default.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub params: BTreeMap<String, ParameterValue>,
}

/// A number, or the numbers of a vector.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum ParameterValue {
    /// A number.
    Number(f64),
    /// A vector.
    Vector(Vec<f64>),
}

impl FunctionUse {
    /// Whether it is a file and not a function of the library.
    pub fn is_file(&self) -> bool {
        self.module.ends_with(".wgsl")
    }
}

impl ParameterValue {
    fn numbers(&self) -> &[f64] {
        match self {
            ParameterValue::Number(number) => std::slice::from_ref(number),
            ParameterValue::Vector(numbers) => numbers,
        }
    }
}

/// Puts the functions that a scene names into its plan. `files` holds the modules of files by the
/// text that names them.
pub(crate) fn apply(
    functions: &BTreeMap<String, FunctionUse>,
    files: &BTreeMap<String, Arc<Module>>,
    plan: &mut Plan,
    checker: &mut Checker,
) {
    for (slot, function) in functions {
        let path = format!("functions.{slot}");
        if !SLOTS.iter().any(|known| known.name == slot) {
            let names: Vec<_> = SLOTS.iter().map(|slot| slot.name).collect();
            let near = nearest(slot, names.iter().copied());
            let near = near.map_or(String::new(), |near| format!("; did you mean {near:?}?"));
            checker.add(
                &path,
                "no slot of the ray",
                &format!("{}{near}", names.join(", ")),
            );
            continue;
        }
        let module = if function.is_file() {
            match files.get(&function.module) {
                Some(module) => module.clone(),
                None => {
                    checker.add(
                        format!("{path}.module"),
                        format!("{:?}, which is not loaded", function.module),
                        "a file that is handed over with the scene",
                    );
                    continue;
                }
            }
        } else {
            match built_in(slot, &function.module) {
                Ok(module) => module,
                Err(error) => {
                    checker.add(
                        format!("{path}.module"),
                        format!("{:?}", function.module),
                        &error.to_string(),
                    );
                    continue;
                }
            }
        };
        if module.slot().name != slot {
            checker.add(
                format!("{path}.module"),
                format!(
                    "{:?}, a function for the slot {}",
                    function.module,
                    module.slot().name
                ),
                &format!("a function for {slot}, or the key {}", module.slot().name),
            );
            continue;
        }
        let before = checker.problems.len();
        let values = values(&path, function, &module, checker);
        if checker.problems.len() > before {
            continue;
        }
        if function.is_file() {
            plan.modules.push(PlanModule { module, values });
        } else if let Err(why) =
            (0..plan.layers.len()).try_for_each(|layer| settle(&module, &values, plan, layer))
        {
            checker.add(
                format!("{path}.module"),
                format!("{:?}", function.module),
                why,
            );
        }
    }
}

/// The values of parameters, checked against what the module says of them.
fn values(
    path: &str,
    function: &FunctionUse,
    module: &Module,
    checker: &mut Checker,
) -> Vec<(String, Vec<f64>)> {
    let mut values = Vec::new();
    for (name, value) in &function.params {
        let path = format!("{path}.params.{name}");
        let Some(parameter) = module.parameters().iter().find(|p| p.name == *name) else {
            let names: Vec<_> = module
                .parameters()
                .iter()
                .map(|p| p.name.as_str())
                .collect();
            let allowed = match nearest(name, names.iter().copied()) {
                _ if names.is_empty() => "nothing: the function has no parameters".to_owned(),
                Some(near) => format!("{}; did you mean {near:?}?", names.join(", ")),
                None => names.join(", "),
            };
            checker.add(path, "no parameter", &allowed);
            continue;
        };
        match parameter.check(value.numbers()) {
            Ok(()) => values.push((name.clone(), value.numbers().to_vec())),
            Err(_) => {
                let [low, high] = parameter.range;
                let (kind, number) = (parameter.type_name(), Number);
                let allowed = format!("{kind}, {} to {}", number(low), number(high));
                checker.add(path, format!("{:?}", value.numbers()), &allowed);
            }
        }
    }
    values
}

/// Says a function of the library in the words of layer number `layer` of the plan.
fn settle(
    module: &Module,
    values: &[(String, Vec<f64>)],
    plan: &mut Plan,
    layer: usize,
) -> Result<(), &'static str> {
    let Plan {
        fields,
        techniques,
        layers,
        lattice,
        lights,
        ..
    } = plan;
    let field = &mut fields[layers[layer].field];
    let technique = &mut techniques[layers[layer].technique];
    let number = |name: &str| -> f32 {
        let given = values
            .iter()
            .find(|(given, _)| given == name)
            .map(|(_, v)| v[0]);
        let default = || {
            module
                .parameters()
                .iter()
                .find(|p| p.name == name)
                .map(|p| p.default[0])
        };
        given.or_else(default).unwrap_or_default() as f32
    };
    let unequal = |a: f32, b: f32| {
        (a != b)
            .then_some(())
            .ok_or("parameters whose two ends differ")
    };
    match (module.slot().name, module.name()) {
        ("fetch", "texture") => field.fetch = Fetch::Stored,
        ("fetch", "marschner_lobb") => {
            field.fetch = Fetch::MarschnerLobb {
                frequency: number("frequency"),
                alpha: number("alpha"),
            };
        }
        ("fetch", "noise") => {
            field.fetch = Fetch::Noise {
                cell_voxels: number("cell_voxels"),
                octaves: number("octaves") as u32,
                seed: number("seed") as u32,
            };
        }
        ("reconstruct", "nearest") => field.reconstruct = Reconstruct::Nearest,
        ("reconstruct", "trilinear" | "trilinear_sampler") => {
            field.reconstruct = Reconstruct::Trilinear
        }
        ("reconstruct", "b_spline" | "b_spline_sampler") => {
            field.reconstruct = Reconstruct::BSpline
        }
        ("reconstruct", "catmull_rom") => field.reconstruct = Reconstruct::CatmullRom,
        ("jitter", "hash") => lattice.jitter = Jitter::Hash(number("seed") as u32),
        ("jitter", "sine_hash") => lattice.jitter = Jitter::SineHash,
        ("jitter", "tile") => lattice.jitter = Jitter::BlueTile(0),
        ("classify", "table") => technique.classify = Classify::Table,
        ("classify", "identity") => {
            let (black, white) = (number("black"), number("white"));
            unequal(black, white)?;
            technique.classify = Classify::Identity { black, white };
        }
        ("classify", "threshold") => {
            let (black, white) = (number("black"), number("white"));
            unequal(black, white)?;
            technique.classify = Classify::Threshold {
                threshold: number("threshold"),
                black,
                white,
            };
        }
        ("classify", "gradient_table") => {
            let (low_per_mm, high_per_mm) = (number("low_per_mm"), number("high_per_mm"));
            (low_per_mm < high_per_mm)
                .then_some(())
                .ok_or("low_per_mm below high_per_mm")?;
            technique.classify = Classify::GradientTable {
                low_per_mm,
                high_per_mm,
            };
        }
        ("classify", "pre_classified") => technique.classify = Classify::PreClassified,
        ("gradient_input", "value") => technique.gradient_input = GradientInput::Value,
        ("gradient_input", "opacity") => technique.gradient_input = GradientInput::Opacity,
        ("gradient", name) => {
            field.gradient = match name {
                "forward" => GradientMethod::Forward,
                "backward" => GradientMethod::Backward,
                "central" => GradientMethod::Central,
                "central_9" => GradientMethod::Central9,
                "sobel" => GradientMethod::Sobel,
                "b_spline" => GradientMethod::BSpline,
                _ => return Err(BY_KEY),
            };
        }
        ("illuminate", name) => {
            let (diffuse, specular) = (number("diffuse"), number("specular"));
            let shininess = number("shininess");
            let chosen = match name {
                "lambert" => Illuminate::Lambert { diffuse },
                "phong" => Illuminate::Phong {
                    diffuse,
                    specular,
                    shininess,
                },
                "blinn_phong" => Illuminate::BlinnPhong {
                    diffuse,
                    specular,
                    shininess,
                },
                "cook_torrance" => Illuminate::CookTorrance {
                    diffuse,
                    roughness: number("roughness"),
                    reflectance: number("reflectance"),
                },
                _ => return Err(BY_KEY),
            };
            match &mut technique.shade {
                Shade::Lit { illuminate, .. } => *illuminate = chosen,
                _ => {
                    return Err(
                        "a scene that is lit: shading.model lambert, phong, blinn-phong or cook-torrance",
                    );
                }
            }
        }
        ("shade", name @ ("lit" | "lit_last_normal")) => match &mut technique.shade {
            Shade::Lit {
                ambient,
                keep_last_normal,
                ..
            } => {
                *ambient = number("ambient");
                *keep_last_normal = name == "lit_last_normal";
            }
            _ => {
                return Err(
                    "a scene that is lit: shading.model lambert, phong, blinn-phong or cook-torrance",
                );
            }
        },
        ("shade", "gradient_opacity") => {
            technique.shade = Shade::GradientOpacity {
                full_per_mm: number("full_per_mm"),
            };
            lights.clear();
        }
        ("composite", "front_to_back") => {
            technique.composite = Composite::EmissionAbsorption {
                stop_at_transmittance: number("stop_at_transmittance"),
            };
        }
        ("composite", "back_to_front") => technique.composite = Composite::BackToFront,
        ("composite", "maximum") => technique.composite = Composite::Mip,
        ("composite", "minimum") => technique.composite = Composite::MinIp,
        ("composite", "average") => technique.composite = Composite::Average,
        ("composite", "gradient_maximum") => {
            technique.composite = Composite::Gmip {
                white_per_mm: number("white_per_mm"),
            };
        }
        ("composite", "mida") => {
            let (low, high) = (number("low"), number("high"));
            unequal(low, high)?;
            technique.composite = Composite::Mida {
                low,
                high,
                blend: number("blend"),
                stop_at_transmittance: number("stop_at_transmittance"),
            };
        }
        ("composite", "first_hit") => {
            technique.composite = Composite::FirstHit {
                threshold: f64::from(number("threshold")),
            };
        }
        ("composite", name) => {
            let view = match name {
                "entry" => DebugView::Entry,
                "exit" => DebugView::Exit,
                "normal" => DebugView::Normal,
                "normal_raw" => DebugView::GradientRaw,
                "gradient_magnitude" => DebugView::GradientMagnitude {
                    white_per_mm: number("white_per_mm"),
                },
                "sample_count" => DebugView::SampleCount {
                    white: number("white"),
                },
                "hit_depth" => {
                    let (near_mm, far_mm) = (number("near_mm"), number("far_mm"));
                    unequal(near_mm, far_mm)?;
                    DebugView::Depth { near_mm, far_mm }
                }
                _ => return Err(BY_KEY),
            };
            technique.composite = Composite::Debug(view);
        }
        _ => return Err(BY_KEY),
    }
    Ok(())
}

const BY_KEY: &str = "what the scene's own keys say: clips, lights";

/// The functions of the library that a scene can name, for a test that none is forgotten.
#[cfg(test)]
fn nameable() -> impl Iterator<Item = &'static Arc<Module>> {
    strahl_shader::library()
        .iter()
        .filter(|m| !["clip_ray", "clip_sample", "light"].contains(&m.slot().name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Scene, resolve};
    use strahl_volume::Phantom;

    #[test]
    fn every_function_of_the_library_can_be_named() {
        let header = Phantom::Tree.volume([8; 3]).unwrap().header();
        for module in nameable() {
            let (slot, name) = (module.slot().name, module.name());
            let text =
                format!("{{ \"functions\": {{ \"{slot}\": {{ \"module\": \"{name}\" }} }} }}");
            let scene = Scene::parse("scene", &text).unwrap();
            if let Err(problems) = resolve(&scene, &header, None) {
                panic!("{slot}/{name}: {problems}");
            }
        }
    }
}
