//! Shader functions that a scene names: those of the library by their names, a user's own by file.

use crate::ShadingModel;
use crate::nearest::nearest;
use crate::plan::{
    Classify, Composite, Fetch, GradientInput, GradientMethod, Illuminate, Illustrate, Jitter,
    Plan, PlanModule, Reconstruct, Shade,
};
use crate::problem::{Checker, Number};
use crate::transfer::TransferTable;
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;
use strahl_shader::registry::Function;
use strahl_shader::{Module, Parameter, SLOTS, Scalar};

/// A shader function, and values for its parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct FunctionUse {
    /// The name of a library function (`strahl shader list`), or a `.wgsl` file relative to the
    /// folder of the scene file.
    pub module: String,
    /// Values of its parameters; missing ones have their default.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub params: BTreeMap<String, ParameterValue>,
}

/// A number, or the numbers of a vector.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
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

/// The slots of which an object may have functions of its own.
const OF_OBJECTS: [&str; 2] = ["classify", "gradient_input"];

/// Puts the functions of the library that object number `object` of a scene names into layer number `layer`
/// of its plan.
pub(crate) fn apply_to_layer(
    object: usize,
    functions: &BTreeMap<String, FunctionUse>,
    layer: usize,
    plan: &mut Plan,
    checker: &mut Checker,
) {
    for (slot, function) in functions {
        let path = format!("objects[{object}].functions.{slot}");
        if !OF_OBJECTS.contains(&slot.as_str()) {
            let allowed = format!(
                "{}; other functions are those of the scene, shading has a key of its own",
                OF_OBJECTS.join(", ")
            );
            checker.add(&path, "given for an object", &allowed);
            continue;
        }
        of_library(&path, slot, function, layer..layer + 1, plan, checker);
    }
}

/// Puts the functions that a scene names into all layers of its plan. `files` holds the modules of files by the
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
        if !function.is_file() {
            of_library(&path, slot, function, 0..plan.layers.len(), plan, checker);
            continue;
        }
        let Some(module) = files.get(&function.module) else {
            checker.add(
                format!("{path}.module"),
                format!("{:?}, which is not loaded", function.module),
                "a file that is handed over with the scene",
            );
            continue;
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
        if let Some(values) = values(&path, function, module.parameters(), checker) {
            plan.modules.push(PlanModule {
                module: module.clone(),
                values,
            });
        }
    }
}

/// Says a function of the library in the words of these layers of the plan.
fn of_library(
    path: &str,
    slot: &str,
    wanted: &FunctionUse,
    mut layers: Range<usize>,
    plan: &mut Plan,
    checker: &mut Checker,
) {
    let function = match Function::named(slot, &wanted.module) {
        Ok(function) => function,
        Err(error) => {
            let names: Vec<&str> = Function::of_slot(slot).map(|f| f.name).collect();
            let allowed = match names.is_empty() {
                true => error.to_string(),
                false => format!("{}, or a file that ends in .wgsl", names.join(", ")),
            };
            let name = format!("{:?}", wanted.module);
            return checker.add(format!("{path}.module"), name, &allowed);
        }
    };
    let Some(values) = values(path, wanted, function.parameters, checker) else {
        return;
    };
    if let Err(why) = layers.try_for_each(|layer| settle(function, &values, plan, layer)) {
        let name = format!("{:?}", wanted.module);
        checker.add(format!("{path}.module"), name, &why);
    }
}

/// The values of parameters, checked against what is said of them; `None` if one is wrong.
fn values(
    path: &str,
    function: &FunctionUse,
    parameters: &[Parameter],
    checker: &mut Checker,
) -> Option<Vec<(String, Vec<f64>)>> {
    let before = checker.problems.len();
    let mut values = Vec::new();
    for (name, value) in &function.params {
        let path = format!("{path}.params.{name}");
        let Some(parameter) = parameters.iter().find(|p| p.name == *name) else {
            let names: Vec<_> = parameters.iter().map(|p| &*p.name).collect();
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
                let found = match value {
                    ParameterValue::Number(value) => Number(*value).to_string(),
                    ParameterValue::Vector(values) => format!("{values:?}"),
                };
                checker.add(path, found, &allowed(parameter));
            }
        }
    }
    (checker.problems.len() == before).then_some(values)
}

/// What a parameter takes, in words.
fn allowed(parameter: &Parameter) -> String {
    let [low, high] = parameter.range.map(Number);
    let what = match (parameter.components, parameter.scalar) {
        (1, Scalar::F32) => "a number".to_owned(),
        (1, _) => "a whole number".to_owned(),
        (n, Scalar::F32) => format!("{n} numbers"),
        (n, _) => format!("{n} whole numbers"),
    };
    format!("{what}, {low} to {high}")
}

/// The same of one layer.
fn settle(
    function: &Function,
    values: &[(String, Vec<f64>)],
    plan: &mut Plan,
    layer: usize,
) -> Result<(), String> {
    let number = plan.technique_number(layer);
    let Plan {
        fields,
        techniques,
        layers,
        lattice,
        lights,
        ..
    } = plan;
    let field = &mut fields[layers[layer].field];
    let technique = &mut techniques[number];
    let value = |name: &str| {
        let given = values.iter().find(|(given, _)| given == name);
        given.map_or_else(|| function.default_of(name), |(_, numbers)| numbers[0])
    };
    for parameter in function.parameters {
        parameter.check_beside(value(&parameter.name), value)?;
    }
    let name = function.is_way_of.unwrap_or(function.name);
    let lit = || format!("a scene that is lit: shading.model {}", ShadingModel::lit());
    let settled = match function.slot {
        "fetch" => Fetch::of(name, value).map(|fetch| field.fetch = fetch),
        "reconstruct" => Reconstruct::of(name, value).map(|way| field.reconstruct = way),
        "classify" => Classify::of(name, value).map(|classify| {
            technique.classify = of_table(classify, &technique.table);
        }),
        "gradient_input" => {
            GradientInput::of(name, value).map(|input| technique.gradient_input = input)
        }
        "gradient" => GradientMethod::of(name, value).map(|method| field.gradient = method),
        "composite" => Composite::of(name, value).map(|composite| technique.composite = composite),
        "illuminate" => match &mut technique.shade {
            Shade::Lit { illuminate, .. } => {
                Illuminate::of(name, value).map(|model| *illuminate = model)
            }
            _ => return Err(lit()),
        },
        "shade" if ["lit", "lit_last_normal"].contains(&name) => match &mut technique.shade {
            Shade::Lit {
                ambient,
                keep_last_normal,
                ..
            } => {
                *ambient = value("ambient") as f32;
                *keep_last_normal = name == "lit_last_normal";
                Some(())
            }
            _ => return Err(lit()),
        },
        "shade" => {
            lights.clear();
            Shade::of(name, value).map(|shade| technique.shade = shade)
        }
        "illustrate" => Illustrate::of(name, value).map(|style| technique.illustrate = style),
        "jitter" => {
            lattice.jitter = match name {
                "sine_hash" => Jitter::SineHash,
                "tile" => Jitter::BlueTile(0),
                _ => Jitter::Hash(value("seed") as u32),
            };
            Some(())
        }
        _ => None,
    };
    settled.ok_or_else(|| "a slot that the scene's own keys set: clips, lights".to_owned())
}

/// A classification whose size is that of its table.
fn of_table(classify: Classify, table: &TransferTable) -> Classify {
    let number = table.entries().len();
    match classify {
        Classify::ValueGradient { full_per_mm, .. } => Classify::ValueGradient {
            full_per_mm,
            columns: number as u32,
            rows: (table.rows().len() / number) as u32,
        },
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Scene, resolve};
    use strahl_shader::registry::FUNCTIONS;
    use strahl_volume::Phantom;

    fn resolved(slot: &str, name: &str) -> Plan {
        let header = Phantom::Tree.volume([8; 3]).unwrap().header();
        let text = format!(r#"{{ "functions": {{ "{slot}": {{ "module": "{name}" }} }} }}"#);
        let scene = Scene::parse("scene", &text).unwrap();
        resolve(&scene, &header, None).unwrap_or_else(|why| panic!("{slot}/{name}: {why}"))
    }

    #[test]
    fn every_function_of_the_library_can_be_named_by_every_name_that_it_has_or_had() {
        let by_keys = ["clip_ray", "clip_sample", "light"];
        for function in FUNCTIONS.iter().filter(|f| !by_keys.contains(&f.slot)) {
            let plan = format!("{:?}", resolved(function.slot, function.name));
            for name in function.was.iter().chain([&function.word]) {
                let other = format!("{:?}", resolved(function.slot, name));
                assert!(plan == other, "{}/{name}", function.slot);
            }
        }
    }

    #[test]
    fn the_named_function_is_in_the_plan() {
        let plan = resolved("composite", "maximum");
        assert_eq!(plan.technique().composite, Composite::Mip);
        assert_eq!(
            resolved("reconstruct", "b_spline_sampler")
                .field()
                .reconstruct,
            Reconstruct::BSpline
        );
        assert_eq!(resolved("fetch", "texture").field().fetch, Fetch::Stored);
    }
}
