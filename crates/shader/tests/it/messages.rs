//! What people read who made a mistake.

use crate::one;
use std::sync::Arc;
use strahl_shader::{Error, Linker, Module, Selection, Texels, built_in};

fn refused(source: &str) -> String {
    match Module::parse("mine", "mine.wgsl", source) {
        Ok(_) => panic!("this was taken:\n{source}"),
        Err(error) => error.to_string(),
    }
}

fn linked(modules: &[(&str, &str)], own: &[&str]) -> Result<String, Error> {
    let mut selection = Selection::new();
    for (slot, name) in modules {
        selection = selection.with(built_in(slot, name)?);
    }
    for source in own {
        selection = selection.with(Arc::new(Module::parse("mine", "mine.wgsl", source)?));
    }
    let program = Linker::new().link(&one(Texels::Float), &selection)?;
    Ok(program.wgsl().to_owned())
}

const BASE: [(&str, &str); 3] = [
    ("fetch", "stored"),
    ("reconstruct", "trilinear"),
    ("composite", "emission_absorption"),
];

#[test]
fn mistakes_in_a_module_are_shown_where_they_are() {
    let cases = [
        (
            "wrong signature",
            "fn classify(value: f32) -> vec4f {\n    return vec4f(value);\n}\n",
        ),
        (
            "no function of a slot",
            "fn clasify(value: f32, position: vec3f) -> Surface {\n    return table(value);\n}\n",
        ),
        (
            "two slots",
            "fn jitter(pixel: vec2u, frame: u32) -> f32 { return 0.0; }\nfn clip_sample(place_mm: vec3f) -> bool { return false; }\n",
        ),
        (
            "half a composite",
            "struct State { sum: f32 }\nfn composite_start() -> State { return State(0.0); }\n",
        ),
        (
            "unknown parameter",
            "struct Params {\n    /// How much.\n    /// default 1\n    gain: f32,\n}\n\nfn classify(value: f32, position: vec3f) -> Surface {\n    return table(value * params.gian);\n}\n",
        ),
        (
            "type error in the body",
            "fn classify(value: f32, position: vec3f) -> Surface {\n    let scaled = 2.0 * value;\n    return table(position);\n}\n",
        ),
        (
            "unknown name",
            "fn classify(value: f32, position: vec3f) -> Surface {\n    return tabel(value);\n}\n",
        ),
        (
            "a taken name",
            "struct Light { watt: f32 }\nfn classify(value: f32, position: vec3f) -> Surface { return table(value); }\n",
        ),
        (
            "recursion",
            "fn again(x: f32) -> f32 {\n    return again(x - 1.0);\n}\nfn classify(value: f32, position: vec3f) -> Surface {\n    return table(again(value));\n}\n",
        ),
        (
            "resources",
            "@group(0) @binding(9) var<storage, read> mine: array<f32>;\nfn classify(value: f32, position: vec3f) -> Surface { return table(mine[0]); }\n",
        ),
        (
            "an entry point",
            "@fragment fn classify() -> @location(0) vec4f { return vec4f(1.0); }\n",
        ),
        (
            "an extension",
            "enable f16;\nfn classify(value: f32, position: vec3f) -> Surface { return table(value); }\n",
        ),
        (
            "a parameter without default",
            "struct Params {\n    gain: f32,\n}\nfn classify(value: f32, position: vec3f) -> Surface { return table(value * params.gain); }\n",
        ),
        (
            "a parameter of another type",
            "struct Params {\n    /// default 1\n    gain: mat4x4f,\n}\nfn classify(value: f32, position: vec3f) -> Surface { return table(value); }\n",
        ),
        (
            "a default out of range",
            "struct Params {\n    /// default 3, range 0 to 2\n    gain: f32,\n}\nfn classify(value: f32, position: vec3f) -> Surface { return table(value * params.gain); }\n",
        ),
        ("not WGSL", "void classify(float value) {}\n"),
        ("nothing", ""),
        (
            "a missing return",
            "fn classify(value: f32, position: vec3f) -> Surface {\n    let x = value;\n}\n",
        ),
    ];
    let mut text = String::new();
    for (what, source) in cases {
        text.push_str(&format!("== {what}\n{}\n\n", refused(source)));
    }
    insta::assert_snapshot!(text);
}

#[test]
fn a_choice_that_cannot_be_linked_is_explained() {
    let circle = "fn gradient_input(position: vec3f) -> f32 {\n    return classify(0.0, position).opacity;\n}\n";
    let mut text = String::new();
    let mut case = |what: &str, result: Result<String, Error>| {
        let error = result.expect_err(what);
        text.push_str(&format!("== {what}\n{error}\n\n"));
    };
    case("an empty slot", linked(&BASE, &[]));
    case(
        "two functions for one place",
        linked(
            &[
                BASE[0],
                BASE[1],
                BASE[2],
                ("classify", "table"),
                ("classify", "identity"),
            ],
            &[],
        ),
    );
    case(
        "a circle",
        linked(
            &[
                BASE[0],
                BASE[1],
                BASE[2],
                ("classify", "gradient_table"),
                ("gradient", "central"),
            ],
            &[circle],
        ),
    );
    case("no such function", linked(&[("classify", "tabel")], &[]));
    case("no such slot", linked(&[("clasify", "table")], &[]));
    insta::assert_snapshot!(text);
}

#[test]
fn wrong_values_are_explained() {
    let selection = [
        BASE[0],
        BASE[1],
        BASE[2],
        ("classify", "table"),
        ("clip_ray", "plane"),
        ("clip_ray", "plane"),
    ]
    .into_iter()
    .fold(Selection::new(), |s, (slot, name)| {
        s.with(built_in(slot, name).unwrap())
    });
    let program = Linker::new().link(&one(Texels::Float), &selection).unwrap();
    let mut bytes = program.default_parameters();
    let mut set = |label, parameter, value: &[f64]| {
        program
            .set(&mut bytes, label, parameter, value)
            .map_err(|e| e.to_string())
    };
    let labels: Vec<_> = program.blocks().iter().map(|b| b.label.as_str()).collect();
    assert_eq!(labels, ["clip_ray_0", "clip_ray_1", "composite"]);
    set("clip_ray_1", "offset_mm", &[2.5]).unwrap();
    let messages = [
        set("clip_ray_2", "offset_mm", &[0.0]),
        set("clip_ray_0", "offset", &[0.0]),
        set("clip_ray_0", "normal", &[0.0]),
        set("clip_ray_0", "normal", &[0.0, f64::NAN, 0.0]),
        set("composite", "stop_at_transmittance", &[1.5]),
    ]
    .map(Result::unwrap_err);
    insta::assert_snapshot!(messages.join("\n"));
    let at = program.blocks()[1].offset as usize + 12;
    assert_eq!(bytes[at..at + 4], 2.5f32.to_le_bytes());
}

#[test]
fn places_in_the_program_lead_back_to_the_module() {
    let own = "// A comment with classify in it.\nfn half(x: f32) -> f32 { return 0.5 * x; }\nfn classify(value: f32, position: vec3f) -> Surface {\n    return table(half(value));\n}\n";
    let selection = BASE
        .into_iter()
        .fold(Selection::new(), |s, (slot, name)| {
            s.with(built_in(slot, name).unwrap())
        })
        .with(Arc::new(Module::parse("mine", "mine.wgsl", own).unwrap()));
    let program = Linker::new().link(&one(Texels::Float), &selection).unwrap();
    let at = program
        .wgsl()
        .find("return table(classify_half(value))")
        .unwrap();
    let origin = program.origin(at).unwrap();
    assert_eq!(
        (origin.file.as_str(), origin.line, origin.column),
        ("mine.wgsl", 4, 5)
    );
    assert!(program.wgsl().contains("// A comment with classify in it."));
    assert_eq!(program.origin(0), None);
}
