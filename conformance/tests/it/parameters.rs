//! Random values of the parameters of shader functions, from the ranges that their texts give.

use crate::random::Random;
use std::collections::HashMap;
use strahl_shader::registry::Function;
use strahl_shader::{Parameter, ParameterRelation, Scalar};

/// Narrower than the text allows, by name, with the reason.
const NARROWER: &[(&str, [f64; 2])] = &[
    // What is brighter than white enlarges every difference.
    ("diffuse", [0.0, 1.0]),
    ("specular", [0.0, 0.5]),
    ("reflectance", [0.0, 0.5]),
    // The smaller a highlight, the more the last bit of a normal moves it.
    ("shininess", [1.0, 40.0]),
    ("roughness", [0.2, 1.0]),
    // Where a ray ends is a decision that rounding takes.
    ("stop_at_transmittance", [0.0, 0.0]),
    // Fractions of a lattice of a few voxels.
    ("cell_voxels", [2.0, 6.0]),
    ("octaves", [1.0, 3.0]),
    ("frequency", [2.0, 8.0]),
    ("alpha", [0.1, 0.5]),
];

/// Values of the parameters of `function` for a volume of values from `low` to `high` whose steepest gradient is
/// `steep_per_mm`. What has no range is a value of the volume (or a gradient, by its name): of two that have to
/// differ, the first is small and the second large.
pub fn random_values(
    function: &Function,
    random: &mut Random,
    [low, high]: [f64; 2],
    steep_per_mm: f64,
) -> HashMap<&'static str, f64> {
    let mut drawn = HashMap::new();
    for parameter in function.parameters {
        let is_per_mm = parameter.name.ends_with("_per_mm");
        let [lo, hi] = match narrower(parameter) {
            Some(range) => range,
            None if is_bounded(parameter) => parameter.range,
            None if parameter.name.ends_with("_mm") && !is_per_mm => [parameter.default[0]; 2],
            None => {
                let [from, to] = if is_per_mm {
                    [0.0, steep_per_mm]
                } else {
                    [low, high]
                };
                let [a, b] = part_of_values(function, parameter);
                [from + (to - from) * a, from + (to - from) * b]
            }
        };
        // The default is what is used most.
        let value = match is_bounded(parameter) && random.once_in(2) {
            true => parameter.default[0].clamp(lo, hi),
            false => random.between(lo, hi),
        };
        let [lowest, highest] = parameter.range;
        let value = value.clamp(lowest, highest);
        let value = match parameter.scalar {
            Scalar::F32 => value,
            Scalar::I32 | Scalar::U32 => value.round(),
        };
        drawn.insert(&*parameter.name, value);
    }
    drawn
}

fn narrower(parameter: &Parameter) -> Option<[f64; 2]> {
    let mut all = NARROWER.iter();
    let found = all.find(|(name, _)| *name == parameter.name);
    found.map(|(_, range)| *range)
}

/// Whether its range is one to draw from, and not only what keeps numbers finite.
fn is_bounded(parameter: &Parameter) -> bool {
    let [low, high] = parameter.range;
    high - low <= 1e6
}

/// Which part of the values it is drawn from.
fn part_of_values(function: &Function, parameter: &Parameter) -> [f64; 2] {
    let is_other =
        |p: &Parameter| p.beside.as_ref().map(ParameterRelation::other) == Some(&*parameter.name);
    if parameter.beside.is_some() {
        [0.75, 1.0]
    } else if function.parameters.iter().any(is_other) {
        [0.0, 0.25]
    } else {
        [0.3, 0.7]
    }
}

#[test]
fn values_are_those_that_the_text_allows() {
    for function in &strahl_shader::registry::FUNCTIONS {
        for seed in 0..20 {
            let mut random = Random::new(seed);
            let drawn = random_values(function, &mut random, [-100.0, 300.0], 50.0);
            for parameter in function.parameters.iter().filter(|p| p.components == 1) {
                let value = drawn[&*parameter.name];
                let place = format!("{}/{}: {}", function.slot, function.name, parameter.name);
                assert_eq!(parameter.check(&[value]), Ok(()), "{place}");
                let beside = parameter.check_beside(value, |name| drawn[name]);
                assert_eq!(beside, Ok(()), "{place}");
            }
        }
    }
}
