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
    // A person's function may nest as deep as this, and is checked.
    Module::parse("mine", "mine.wgsl", &deep(60)).unwrap();
    let calls = |n: usize| format!("{}value{}", "abs(".repeat(n), ")".repeat(n));
    let value = |value: &str| {
        format!("fn classify(value: f32, position: vec3f) -> Surface {{ return table({value}); }}")
    };
    let many = 50_000;
    for text in [
        value(&format!("f32({}true)", "!".repeat(many))),
        value(&format!("{}value", "-".repeat(many))),
        value(&format!("value{}", " + value".repeat(many / 4))),
        value(&format!("position{}", ".xyz".repeat(many))),
        value(&calls(many / 4)),
        value(&format!(
            "f32({}1{})",
            "vec3<".repeat(many / 4),
            ">".repeat(many / 4)
        )),
        format!(
            "fn classify(value: f32, position: vec3f) -> Surface {{ if value < 0.0 {{ }} {} return table(value); }}",
            "else if value < 1.0 { } ".repeat(many / 10)
        ),
        format!(
            "fn classify(value: f32, position: vec3f) -> Surface {{ {} {} return table(value); }}",
            "{".repeat(many),
            "}".repeat(many)
        ),
    ] {
        let error = Module::parse("mine", "mine.wgsl", &text).unwrap_err();
        assert!(
            error.to_string().contains("deep"),
            "{}",
            error.to_string().lines().next().unwrap()
        );
    }
    // As deep as is read, in every way.
    for text in [
        value(&calls(120)),
        value(&format!("value{}", " + value".repeat(380))),
    ] {
        Module::parse("mine", "mine.wgsl", &text).unwrap();
    }
    let long = format!("// {}\n", "x".repeat(1 << 20));
    let error = Module::parse("mine", "mine.wgsl", &long).unwrap_err();
    assert!(error.to_string().contains("bytes"), "{error}");
}

#[test]
fn trees_and_chains_of_calls_are_refused() {
    let functions = |number: usize, body: &dyn Fn(usize) -> String| {
        let mut text = "fn c0(a: f32) -> f32 { return a; }\n".to_owned();
        for i in 1..number {
            text += &format!("fn c{i}(a: f32) -> f32 {{ return {}; }}\n", body(i - 1));
        }
        let last = number - 1;
        text + &format!(
            "fn classify(value: f32, position: vec3f) -> Surface {{ return table(c{last}(value)); }}"
        )
    };
    let tree = functions(31, &|below| format!("c{below}(a) + c{below}(a + 1.0)"));
    let chain = functions(2000, &|below| format!("c{below}(a)"));
    for (text, words) in [
        (tree, "calls of functions; at most"),
        (chain, "functions 201 deep"),
    ] {
        let error = Module::parse("mine", "mine.wgsl", &text)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains(words) && error.contains("mine.wgsl:"),
            "{error}"
        );
    }
    let few = functions(10, &|below| format!("c{below}(a) + c{below}(a + 1.0)"));
    Module::parse("mine", "mine.wgsl", &few).unwrap();
}

#[test]
fn barriers_are_refused() {
    let text = "fn classify(value: f32, position: vec3f) -> Surface {\nworkgroupBarrier(); return table(value); }";
    let error = Module::parse("mine", "mine.wgsl", text)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("workgroupBarrier") && error.contains("mine.wgsl:2:1"),
        "{error}"
    );
}
