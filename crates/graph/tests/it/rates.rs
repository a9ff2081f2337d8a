//! Where nodes are computed: once, at the vertices, per ray, or per turn.

use crate::{assert_says, compiled, computed, march, refused, showing, shown};

#[test]
fn what_depends_on_uniforms_only_is_outside_of_loops() {
    let (_, graph, _) = crate::standard_of("");
    let mut graph = graph;
    let uniform = strahl_graph::Kind::Uniform {
        ty: "f32".into(),
        value: vec![0.5],
    };
    graph
        .nodes
        .push(strahl_graph::Node::new("strength", uniform));
    let square = strahl_graph::Node::new("square", strahl_graph::Kind::Pattern("multiply".into()));
    graph
        .nodes
        .push(square.input("a", "strength").input("b", "strength"));
    let scaled = strahl_graph::Node::new("weaker", strahl_graph::Kind::Pattern("multiply".into()));
    let scaled = scaled.input("a", "square").input("b", "step_opacity");
    graph.nodes.push(scaled);
    graph.node_mut("before_composite_opacity").unwrap().inputs[0].1 = "weaker".into();
    let compiled = crate::compile(&graph).unwrap();
    let text = march(&compiled);
    let at = |what: &str| text.find(what).unwrap_or_else(|| panic!("{what}:\n{text}"));
    assert!(at("let square = ") < at("loop {") && at("loop {") < at("let weaker = "));
}

#[test]
fn the_ray_is_computed_once_and_samples_in_the_loop() {
    let (_, graph, _) = crate::standard_of("");
    let text = march(&crate::compile(&graph).unwrap());
    let at = |what: &str| text.find(what).unwrap_or_else(|| panic!("{what}:\n{text}"));
    for per_ray in ["ray_of_pixel(", "line_of_ray(", "lattice_of_line("] {
        assert_eq!(text.matches(per_ray).count(), 1, "{text}");
        assert!(at(per_ray) < at("loop {"));
    }
    for per_sample in ["reconstruct(", "classify("] {
        assert!(at(per_sample) > at("loop {"), "{text}");
    }
}

const VERTEX: &str = r#""u": { "uniform": "f32", "value": 2 },
    "at_corner": { "wgsl": "fn at_corner(a: f32) -> f32 { return sin(a); }", "stage": "vertex", "inputs": { "a": "u" } }"#;

#[test]
fn a_node_of_the_vertex_stage_becomes_a_varying() {
    let wgsl = |how: &str| {
        let nodes = VERTEX.replace(
            r#""stage": "vertex""#,
            &format!(r#""stage": "vertex"{how}"#),
        );
        compiled(&showing(&nodes, "at_corner"))
            .program
            .wgsl()
            .to_owned()
    };
    for (how, attribute) in [
        ("", "@interpolate(perspective)"),
        (r#", "interpolation": "linear""#, "@interpolate(linear)"),
        (r#", "interpolation": "flat""#, "@interpolate(flat)"),
    ] {
        let text = wgsl(how);
        assert!(text.contains(attribute), "{text}");
        let start = text.find("fn march(").unwrap();
        let end = start + text[start..].find("\n}").unwrap();
        assert!(!text[start..end].contains("node_at_corner("), "{text}");
        assert!(text.contains("@location(0)") && !text.contains("@location(2)"));
    }
}

#[test]
fn the_vertex_stage_reads_what_is_known_there() {
    let nodes = r#""ray": { "pattern": "ray" },
        "late": { "wgsl": "fn late(a: vec3f) -> f32 { return a.x; }", "stage": "vertex", "inputs": { "a": "ray.direction" } }"#;
    assert_says(
        &refused(&showing(nodes, "late")),
        &[
            "nodes.late",
            "vertex stage",
            "constants, uniforms and nodes of that stage only",
        ],
    );
}

#[test]
fn whole_numbers_are_not_interpolated() {
    let nodes = r#""u": { "uniform": "i32", "value": 2 },
        "v": { "wgsl": "fn v(a: i32) -> i32 { return a * a; }", "stage": "vertex", "inputs": { "a": "u" } },
        "f": { "wgsl": "fn f(a: i32) -> f32 { return f32(a); }", "inputs": { "a": "v" } }"#;
    assert_says(
        &refused(&showing(nodes, "f")),
        &["nodes.v", "a i32, cannot be interpolated", "\"flat\""],
    );
    let flat = nodes.replace(
        r#""stage": "vertex""#,
        r#""stage": "vertex", "interpolation": "flat""#,
    );
    compiled(&showing(&flat, "f"));
}

#[test]
fn varyings_are_counted() {
    let mut nodes = r#""u": { "uniform": "f32", "value": 2 }"#.to_owned();
    let mut last = "u".to_owned();
    for i in 0..13 {
        nodes += &format!(
            r#", "v{i}": {{ "wgsl": "fn v{i}(a: f32) -> f32 {{ return sin(a) + {i}.0; }}", "stage": "vertex", "inputs": {{ "a": "u" }} }},
            "s{i}": {{ "pattern": "add", "inputs": {{ "a": "{last}", "b": "v{i}" }} }}"#
        );
        last = format!("s{i}");
    }
    assert_says(
        &refused(&showing(&nodes, &last)),
        &["13 outputs of the vertex stage", "at most 12"],
    );
}

#[test]
fn what_one_branch_needs_is_computed_there_only() {
    let nodes = r#""ray": { "pattern": "ray" },
        "left": { "wgsl": "fn left(p: vec2u) -> f32 { return sqrt(f32(p.x)); }", "inputs": { "p": "ray.pixel" } },
        "right": { "wgsl": "fn right(p: vec2u) -> f32 { return sqrt(f32(p.y)) + 5.0; }", "inputs": { "p": "ray.pixel" } },
        "is_left": { "wgsl": "fn is_left(p: vec2u) -> bool { return p.x < 2u; }", "inputs": { "p": "ray.pixel" } },
        "choice": { "if": "is_left", "then": { "x": "left" }, "else": { "x": "right" } }"#;
    let text = showing(nodes, "choice.x");
    let march = march(&compiled(&text));
    let at = |what: &str| march.find(what).unwrap();
    assert!(
        at("if is_left {") < at("node_left(") && at("node_left(") < at("} else {"),
        "{march}"
    );
    assert!(at("} else {") < at("node_right("), "{march}");
    let row: Vec<f32> = crate::pixels(&crate::parsed(&text))
        .iter()
        .map(|p| p[0])
        .collect();
    assert_eq!(row, [0.0, 1.0, 5.0, 5.0, 0.0, 1.0, 6.0, 6.0]);
}

#[test]
fn what_both_branches_need_is_computed_before() {
    let nodes = r#""ray": { "pattern": "ray" },
        "both": { "wgsl": "fn both(p: vec2u) -> f32 { return sqrt(f32(p.x)); }", "inputs": { "p": "ray.pixel" } },
        "is_left": { "wgsl": "fn is_left(p: vec2u) -> bool { return p.x < 2u; }", "inputs": { "p": "ray.pixel" } },
        "negative": { "pattern": "rest_of", "inputs": { "a": "both" } },
        "choice": { "if": "is_left", "then": { "x": "both" }, "else": { "x": "negative" } }"#;
    let march = march(&compiled(&showing(nodes, "choice.x")));
    assert!(
        march.find("node_both(").unwrap() < march.find("if is_left").unwrap(),
        "{march}"
    );
    assert_eq!(march.matches("node_both(").count(), 1);
}

#[test]
fn values_change_without_compiling() {
    let mut compiler = strahl_graph::Compiler::default();
    let plan = crate::plan("");
    let functions = strahl_program::Functions::of(&plan, true, |_, t| f64::from(t)).unwrap();
    let what = strahl_program::loop_of(&plan, strahl_shader::Texels::Float);
    let mut programs = Vec::new();
    for value in [1.0, 2.5] {
        let text = shown(
            &format!(r#""u": {{ "uniform": "f32", "value": {value} }}"#),
            r#"{ "x": "u" }"#,
        );
        let compiled = compiler
            .compile("test", &crate::parsed(&text), &what, &functions)
            .unwrap();
        programs.push((compiled.program, compiled.parameters));
        assert_eq!(computed(&text)[0], value as f32);
    }
    assert!(std::sync::Arc::ptr_eq(&programs[0].0, &programs[1].0));
    assert_ne!(programs[0].1, programs[1].1);
}

#[test]
fn what_was_compiled_last_is_remembered() {
    let mut compiler = strahl_graph::Compiler::default();
    let plan = crate::plan("");
    let functions = strahl_program::Functions::of(&plan, true, |_, t| f64::from(t)).unwrap();
    let what = strahl_program::loop_of(&plan, strahl_shader::Texels::Float);
    let mut compile = |number: usize| {
        let node = format!(r#""u{number}": {{ "uniform": "f32", "value": 1 }}"#);
        let graph = crate::parsed(&showing(&node, &format!("u{number}")));
        let compiled = compiler.compile("test", &graph, &what, &functions);
        compiled.unwrap().program
    };
    let programs: Vec<_> = (0..64).map(&mut compile).collect();
    // All are there, and this one is used again.
    assert!(std::sync::Arc::ptr_eq(&compile(0), &programs[0]));
    // One more, and what was not used for longest is gone.
    compile(64);
    assert!(std::sync::Arc::ptr_eq(&compile(0), &programs[0]));
    assert!(std::sync::Arc::ptr_eq(&compile(2), &programs[2]));
    let again = compile(1);
    assert!(!std::sync::Arc::ptr_eq(&again, &programs[1]));
    assert_eq!(again.wgsl(), programs[1].wgsl());
}
