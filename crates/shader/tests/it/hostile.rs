//! Modules that mean harm, or are careless enough.

use crate::one;
use std::sync::Arc;
use strahl_shader::{Linker, MOST_TURNS, Module, Selection, Texels, built_in};

fn program(source: &str) -> String {
    let mine = Module::parse("mine", "mine.wgsl", source).unwrap();
    let selection = [
        ("fetch", "stored"),
        ("reconstruct", "trilinear"),
        ("composite", "emission_absorption"),
    ]
    .into_iter()
    .fold(Selection::new(), |s, (slot, name)| {
        s.with(built_in(slot, name).unwrap())
    })
    .with(Arc::new(mine));
    let program = Linker::new().link(&one(Texels::Float), &selection).unwrap();
    program.wgsl().to_owned()
}

#[test]
fn loops_of_users_are_bounded() {
    for body in [
        "var x = value; loop { x += 1.0; if x < 0.0 { break; } } return table(x);",
        "var x = value; while true { x += 1.0; } return table(x);",
        "var x = value; for (var i = 0; i >= 0; i = 0) { x += 1.0; } return table(x);",
        "var x = value; for (;;) { for (;;) { x += 1.0; } } return table(x);",
        "var x = value; loop { x += 1.0; continuing { break if x < 0.0; } } return table(x);",
    ] {
        let text = program(&format!(
            "fn classify(value: f32, position: vec3f) -> Surface {{ {body} }}"
        ));
        let loops = body.matches("loop {").count()
            + body.matches("while ").count()
            + body.matches("for (").count();
        let bounds = text.matches("if loop_turns_of_ray() { break; }").count();
        assert_eq!(bounds, loops, "{body}");
        assert!(text.contains(&format!("loop_turns > {MOST_TURNS}u")));
    }
    let plain =
        program("fn classify(value: f32, position: vec3f) -> Surface { return table(value); }");
    assert!(!plain.contains("loop_turns"));
}

#[test]
fn huge_types_are_refused() {
    for ty in ["array<f32, 100000>", "array<array<f32, 65536>, 65536>"] {
        let source = format!(
            "fn classify(value: f32, position: vec3f) -> Surface {{ var big: {ty}; return table(value); }}"
        );
        let error = Module::parse("mine", "mine.wgsl", &source)
            .unwrap_err()
            .to_string();
        assert!(error.contains("bytes"), "{error}");
    }
}

#[test]
fn names_never_clash() {
    // Names that the linker, the skeleton or another module would like to have.
    let text = program(
        "struct Params {\n/// default 1\nframe: f32,\n/// default 1\nclassify_table: f32,\n}
        struct ClassifyParams { parameters: f32, table: f32 }
        const classify_limit = 2.0;
        fn transfer(params_: ClassifyParams) -> f32 { return params_.table + params_.parameters; }
        fn entry_in_voxel() -> f32 { let loop_turns = params.frame; return loop_turns; }
        fn classify(value: f32, position: vec3f) -> Surface {
            let frame = ClassifyParams(entry_in_voxel(), params.classify_table);
            return table(value * transfer(frame) * classify_limit);
        }",
    );
    assert!(text.contains("classify_transfer("));
}

#[test]
fn deep_nesting_and_long_texts_end_in_a_message() {
    let deep = |n: usize| {
        format!(
            "fn classify(value: f32, position: vec3f) -> Surface {{ return table({}value{}); }}",
            "(".repeat(n),
            ")".repeat(n)
        )
    };
    assert!(Module::parse("mine", "mine.wgsl", &deep(100_000)).is_err());
    let long = format!("// {}\n", "x".repeat(1 << 20));
    let error = Module::parse("mine", "mine.wgsl", &long).unwrap_err();
    assert!(error.to_string().contains("bytes"), "{error}");
}
