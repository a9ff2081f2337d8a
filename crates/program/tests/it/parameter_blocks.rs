//! The uniform block of all parameters: the bytes that are packed, and the places at which programs read them.
//!
//! What is packed is read back by the layout that naga gives the linked program, as a device does.

use glam::{DAffine3, DMat3, DVec3};
use naga::{Handle, ScalarKind, StructMember, Type, TypeInner};
use std::collections::BTreeMap;
use std::sync::Arc;
use strahl_program::{Functions, loop_of};
use strahl_scene::plan::*;
use strahl_scene::{Scene, resolve};
use strahl_shader::registry::FUNCTIONS;
use strahl_shader::{
    Fold, Linker, Module, Parameter, Program, SLOTS, Scalar, Selection, Texels, bindings, built_in,
    ray_loop,
};
use strahl_volume::Phantom;

/// The numbers of every parameter, by function and name.
type Numbers = BTreeMap<(String, String), Vec<f64>>;

fn members(naga: &naga::Module, ty: Handle<Type>) -> impl Iterator<Item = (&str, &StructMember)> {
    let TypeInner::Struct { members, .. } = &naga.types[ty].inner else {
        panic!("{:?} is no struct", naga.types[ty]);
    };
    members.iter().map(|m| (m.name.as_deref().unwrap(), m))
}

/// What `program` finds in `bytes`.
fn read(program: &Program, bytes: &[u8]) -> Numbers {
    let naga = program.naga();
    let is_block = |v: &naga::GlobalVariable| {
        let binding = v.binding.as_ref();
        binding.is_some_and(|b| b.binding == bindings::PARAMETERS)
    };
    let block = naga.global_variables.iter().find(|(_, v)| is_block(v));
    let (_, block) = block.expect("the program has parameters");
    let mut found = Numbers::new();
    for (function, of_function) in members(naga, block.ty) {
        for (parameter, member) in members(naga, of_function.ty) {
            let (scalar, components) = match naga.types[member.ty].inner {
                TypeInner::Scalar(scalar) => (scalar, 1),
                TypeInner::Vector { size, scalar } => (scalar, size as usize),
                ref other => panic!("{function}.{parameter} is {other:?}"),
            };
            assert_eq!(scalar.width, 4);
            let at = (of_function.offset + member.offset) as usize;
            let numbers = bytes[at..at + 4 * components].chunks_exact(4).map(|b| {
                let bytes = b.try_into().unwrap();
                match scalar.kind {
                    ScalarKind::Float => f64::from(f32::from_le_bytes(bytes)),
                    ScalarKind::Sint => f64::from(i32::from_le_bytes(bytes)),
                    ScalarKind::Uint => f64::from(u32::from_le_bytes(bytes)),
                    other => panic!("{function}.{parameter} is {other:?}"),
                }
            });
            found.insert((function.into(), parameter.into()), numbers.collect());
        }
    }
    found
}

/// A function in every slot that needs one, so that each is called, and then `module`: twice where a slot may
/// have several.
fn with(module: &Arc<Module>) -> Selection {
    let usual = [
        ("fetch", "stored"),
        ("reconstruct", "trilinear"),
        ("classify", "table"),
        ("gradient_input", "value"),
        ("gradient", "central"),
        ("light", "directional"),
        ("illuminate", "blinn_phong"),
        ("shade", "lit"),
        ("composite", "emission_absorption"),
    ];
    let mut selection = Selection::new();
    for slot in &SLOTS {
        let is_own = module.slot() == slot;
        if !(is_own && slot.fold == Fold::One) {
            for (_, name) in usual.iter().filter(|(of, _)| *of == slot.name) {
                selection = selection.with(built_in(slot.name, name).unwrap());
            }
        }
        for _ in 0..usize::from(is_own) + usize::from(is_own && slot.fold != Fold::One) {
            selection = selection.with(module.clone());
        }
    }
    selection
}

/// The next number that `parameter` can take and that single precision has.
fn next(parameter: &Parameter, counter: &mut u32) -> f64 {
    *counter += 1;
    let [low, high] = parameter.range;
    let number = f64::from(*counter) + 0.5;
    match parameter.scalar {
        Scalar::F32 if (low..=high).contains(&number) => number,
        Scalar::F32 => f64::from((low + (high - low) * (number % 64.0) / 64.0) as f32),
        _ => low + number.floor() % (high - low + 1.0),
    }
}

#[test]
fn every_parameter_of_the_library_lies_where_its_program_reads_it() {
    let volume = Phantom::Tree.volume([8; 3]).unwrap();
    let plan = resolve(&Scene::default(), &volume.header(), None).unwrap();
    let skeleton = ray_loop(&loop_of(&plan, Texels::UnfilterableFloat)).unwrap();
    let mut counter = 0;
    for of in FUNCTIONS.iter().filter(|f| f.has_text) {
        let module = built_in(of.slot, of.name).unwrap();
        if module.parameters().is_empty() {
            continue;
        }
        let name = format!("{}/{}", of.slot, of.name);
        let program = Linker::new().link(&skeleton, &with(&module));
        let program = program.unwrap_or_else(|error| panic!("{name}: {error}"));
        let blocks = program.blocks().iter();
        let own = blocks.filter(|b| b.module.name() == of.name).count();
        let expected_blocks = if module.slot().fold == Fold::One {
            1
        } else {
            2
        };
        assert!(own >= expected_blocks, "{name}: {own} blocks");
        let mut bytes = vec![0; program.parameter_bytes() as usize];
        let mut packed = Numbers::new();
        for block in program.blocks() {
            for parameter in block.module.parameters() {
                let components = 0..parameter.components;
                let value: Vec<f64> = components.map(|_| next(parameter, &mut counter)).collect();
                let (label, key) = (&block.label, parameter.name.to_string());
                program.set(&mut bytes, label, &key, &value).unwrap();
                packed.insert((label.clone(), key), value);
            }
        }
        assert_eq!(read(&program, &bytes), packed, "{name}");
    }
    assert!(counter > 100, "{counter} numbers");
}

/// A Plan with several functions in each slot that can have them, no number twice.
fn plan_of_everything() -> Plan {
    let volume = Phantom::Tree.volume([8; 3]).unwrap();
    let mut plan = resolve(&Scene::default(), &volume.header(), None).unwrap();
    plan.lattice.jitter = Jitter::Hash(4_000_000_001);
    plan.ray_clips = vec![
        ClipPlane {
            normal: DVec3::new(0.25, 0.5, 0.75),
            offset_mm: 11.0,
            layers: 3,
        },
        ClipPlane {
            normal: DVec3::new(-0.25, -0.5, -0.75),
            offset_mm: 12.0,
            layers: 5,
        },
    ];
    let clip = |shape, first: f64, keep_inside, layers| {
        let rows = [0.0, 4.0, 8.0].map(|n| first + n);
        let row = |r: f64| DVec3::new(r, r + 1.0, r + 2.0);
        let matrix = DMat3::from_cols(row(rows[0]), row(rows[1]), row(rows[2])).transpose();
        let translation = DVec3::from_array(rows.map(|r| r + 3.0));
        SampleClip {
            shape,
            unit_from_world: DAffine3::from_mat3_translation(matrix, translation),
            keep_inside,
            layers,
        }
    };
    let mask = ClipShape::Mask {
        mask: 2,
        threshold: 0.625,
    };
    plan.sample_clips = vec![
        clip(ClipShape::Cylinder, 20.0, true, 6),
        clip(mask, 40.0, false, 7),
    ];
    plan.lights = vec![
        PlanLight::Point {
            place_mm: DVec3::new(60.0, 61.0, 62.0),
            reach_mm: 63.0,
            radiance: [64.0, 65.0, 66.0],
        },
        PlanLight::Directional {
            to_light: DVec3::new(0.5, -0.5, 0.125),
            radiance: [67.0, 68.0, 69.0],
        },
        PlanLight::Point {
            place_mm: DVec3::new(70.0, 71.0, 72.0),
            reach_mm: 73.0,
            radiance: [74.0, 75.0, 76.0],
        },
    ];
    let technique = plan.technique_mut();
    technique.classify = Classify::GradientTable {
        low_per_mm: 1.5,
        high_per_mm: 2.5,
    };
    technique.shade = Shade::Lit {
        ambient: 0.375,
        illuminate: Illuminate::BlinnPhong {
            diffuse: 3.5,
            specular: 4.5,
            shininess: 80.0,
        },
        keep_last_normal: false,
    };
    technique.composite = Composite::FirstHit { threshold: 90.0 };
    plan
}

/// What [`plan_of_everything`] says, in the words of the functions.
const SAID: &[(&str, &str, &[f64])] = &[
    ("clip_ray_0", "normal", &[0.25, 0.5, 0.75]),
    ("clip_ray_0", "offset_mm", &[11.0]),
    ("clip_ray_0", "objects", &[3.0]),
    ("clip_ray_1", "normal", &[-0.25, -0.5, -0.75]),
    ("clip_ray_1", "offset_mm", &[12.0]),
    ("clip_ray_1", "objects", &[5.0]),
    ("jitter", "seed", &[4_000_000_001.0]),
    (
        "clip_sample_0",
        "unit_from_world_x",
        &[20.0, 21.0, 22.0, 23.0],
    ),
    (
        "clip_sample_0",
        "unit_from_world_y",
        &[24.0, 25.0, 26.0, 27.0],
    ),
    (
        "clip_sample_0",
        "unit_from_world_z",
        &[28.0, 29.0, 30.0, 31.0],
    ),
    ("clip_sample_0", "keep_inside", &[1.0]),
    ("clip_sample_0", "objects", &[6.0]),
    (
        "clip_sample_1",
        "unit_from_world_x",
        &[40.0, 41.0, 42.0, 43.0],
    ),
    (
        "clip_sample_1",
        "unit_from_world_y",
        &[44.0, 45.0, 46.0, 47.0],
    ),
    (
        "clip_sample_1",
        "unit_from_world_z",
        &[48.0, 49.0, 50.0, 51.0],
    ),
    ("clip_sample_1", "mask", &[2.0]),
    ("clip_sample_1", "threshold", &[0.625]),
    ("clip_sample_1", "keep_inside", &[0.0]),
    ("clip_sample_1", "objects", &[7.0]),
    ("classify", "low_per_mm", &[1.5]),
    ("classify", "high_per_mm", &[2.5]),
    ("light_0", "place_mm", &[60.0, 61.0, 62.0]),
    ("light_0", "reach_mm", &[63.0]),
    ("light_0", "radiance", &[64.0, 65.0, 66.0]),
    ("light_1", "to_light", &[0.5, -0.5, 0.125]),
    ("light_1", "radiance", &[67.0, 68.0, 69.0]),
    ("light_2", "place_mm", &[70.0, 71.0, 72.0]),
    ("light_2", "reach_mm", &[73.0]),
    ("light_2", "radiance", &[74.0, 75.0, 76.0]),
    ("illuminate", "diffuse", &[3.5]),
    ("illuminate", "specular", &[4.5]),
    ("illuminate", "shininess", &[80.0]),
    ("shade", "ambient", &[0.375]),
    ("composite", "threshold", &[90.0]),
];

#[test]
fn what_a_plan_says_reaches_the_function_it_is_said_of() {
    let plan = plan_of_everything();
    let threshold = |_, threshold| f64::from(threshold);
    let functions = Functions::of(&plan, false, threshold).unwrap();
    let skeleton = ray_loop(&loop_of(&plan, Texels::UnfilterableFloat)).unwrap();
    let program = Linker::new().link(&skeleton, &functions.selection).unwrap();
    let bytes = functions.parameters(&program).unwrap();
    let said = SAID
        .iter()
        .map(|(function, parameter, numbers)| ((*function).into(), (*parameter).into(), *numbers));
    let said: Numbers = said
        .map(|(function, parameter, numbers)| ((function, parameter), numbers.to_vec()))
        .collect();
    assert_eq!(read(&program, &bytes), said);
}
