//! What is no graph: each with its place, none with a crash.

use crate::{assert_says, refused, showing};
use strahl_graph::GraphUse;

#[test]
fn a_circle_is_named() {
    let nodes = r#""a": { "pattern": "rest_of", "inputs": { "a": "c" } },
        "b": { "pattern": "rest_of", "inputs": { "a": "a" } },
        "c": { "pattern": "rest_of", "inputs": { "a": "b" } }"#;
    assert_says(
        &refused(&showing(nodes, "c")),
        &["in a circle", "b → c → a → b", "a loop's carried variable"],
    );
    let own = r#""a": { "pattern": "rest_of", "inputs": { "a": "a" } }"#;
    assert_says(
        &refused(&showing(own, "a")),
        &["nodes.a", "in a circle: a → a"],
    );
}

#[test]
fn anchors_in_a_circle_are_named() {
    let nodes = r#""a": { "anchor": "b" }, "b": { "anchor": "a" }"#;
    assert_says(&refused(&showing(nodes, "a")), &["reads itself"]);
}

#[test]
fn unknown_functions_are_named_with_what_is_near() {
    let with = |node: &str| refused(&showing(&format!(r#""n": {{ {node} }}"#), "n"));
    assert_says(
        &with(r#""pattern": "ad""#),
        &["nodes.n", "no pattern `ad`", "did you mean `add`"],
    );
    assert_says(
        &with(r#""slot": "jiter""#),
        &["no slot jiter", "reconstruct"],
    );
    assert_says(
        &with(r#""slot": "composite""#),
        &["is not one function", "over"],
    );
    assert_says(
        &with(r#""function": "classify""#),
        &["`classify` is no function of the library", "slot/name"],
    );
    assert_says(
        &with(r#""function": "classify/tabel""#),
        &["tabel", "table"],
    );
    assert_says(
        &with(r#""uniform": "mat4x4f", "value": 1"#),
        &["uniform cannot be a mat4x4f", "vec3f"],
    );
}

#[test]
fn errors_in_wgsl_name_node_and_line() {
    let nodes = r#""mine": { "wgsl": ["fn mine(a: f32) -> f32 {", "    let b = a + 1.0;", "    return b + nothing;", "}"], "inputs": { "a": 1 } }"#;
    assert_says(
        &refused(&showing(nodes, "mine")),
        &["nodes.mine", "nodes.mine.wgsl:3", "nothing"],
    );
    let types = nodes.replace("b + nothing", "vec2f(b)");
    assert_says(
        &refused(&showing(&types, "mine")),
        &["nodes.mine", "nodes.mine.wgsl:", "f32"],
    );
    let syntax = nodes.replace("let b = a", "let b = = a");
    assert_says(&refused(&showing(&syntax, "mine")), &["nodes.mine.wgsl:2"]);
}

#[test]
fn wgsl_that_is_no_node_is_refused() {
    let with = |wgsl: &str| refused(&showing(&format!(r#""n": {{ "wgsl": "{wgsl}" }}"#), "n"));
    assert_says(
        &with("const A: f32 = 1.0;"),
        &["nodes.n", "defines no function"],
    );
    assert_says(
        &with("fn a() -> f32 { return 1.0; } fn b() -> f32 { return 2.0; }"),
        &["both `a` and `b` could be the node"],
    );
    assert_says(&with("fn a() { }"), &["`a` gives no result"]);
    assert_says(
        &with("fn classify(v: f32) -> f32 { return v; }"),
        &["`classify` is that of a slot"],
    );
    assert_says(
        &with("var<private> m: f32; fn a() -> f32 { m += 1.0; return m; }"),
        &["carries what it remembers openly"],
    );
    let binding =
        &with("@group(0) @binding(0) var t: texture_2d<f32>; fn a() -> f32 { return 1.0; }");
    assert_says(binding, &["cannot bind resources", "as arguments"]);
    assert!(!binding.contains("var<private>"), "{binding}");
    let other = with("fn a(s: sampler) -> f32 { return 1.0; }");
    assert_says(&other, &["nodes.n", "sampler"]);
    assert!(!other.contains(" a a"), "{other}");
}

#[test]
fn texts_of_newer_versions_are_refused_as_such() {
    let text = showing(r#""u": { "uniform": "f32", "value": 1 }"#, "u");
    let newer = text.replace(
        r#""strahl_graph": 1"#,
        r#""strahl_graph": 7, "new_things": {}"#,
    );
    assert_says(
        &refused(&newer),
        &["test", "strahl_graph is 7", "up to 1", "newer"],
    );
}

#[test]
fn texts_that_are_no_json_name_the_line() {
    assert_says(
        &refused("{ \"strahl_graph\": 1,\n \"nodes\": { \"a\": ] } }"),
        &["test:2:"],
    );
    assert_says(
        &refused("{ \"strahl_graph\": 1,\n \"nodez\": {} }"),
        &["test:2:", "nodez"],
    );
    let two_kinds = showing(
        r#""u": { "uniform": "f32", "value": 1, "pattern": "add" }"#,
        "u",
    );
    assert_says(&refused(&two_kinds), &["u"]);
}

#[test]
fn an_input_is_connected_once() {
    let mut graph = crate::parsed(&showing(
        r#""u": { "uniform": "f32", "value": 1 }, "a": { "pattern": "rest_of", "inputs": { "a": "u" } }"#,
        "a",
    ));
    let node = graph.node_mut("a").unwrap();
    node.inputs.push(("a".into(), 1.0.into()));
    let message = crate::compile(&graph).unwrap_err().to_string();
    assert_says(
        &message,
        &[
            "nodes.a.inputs.a",
            "connected twice",
            "an input reads one output",
        ],
    );
}

#[test]
fn objects_and_outputs_that_are_not_there_are_named() {
    let nodes = r#""s": { "slot": "reconstruct", "object": 2, "inputs": { "position": 1 } }"#;
    assert_says(
        &refused(&showing(nodes, "s")),
        &["nodes.s.object", "object 2", "the scene has 1", "from 0"],
    );
    let nodes = r#""ray": { "pattern": "ray" }"#;
    assert_says(
        &refused(&showing(nodes, "ray.way")),
        &["`ray` has no output `way`", "origin_mm"],
    );
    assert_says(
        &refused(&showing(nodes, "ray")),
        &["name an output of `ray`"],
    );
}

#[test]
fn remembering_functions_of_the_library_are_refused() {
    let nodes = r#""s": { "function": "shade/lit_last_normal" }"#;
    assert_says(
        &refused(&showing(nodes, "s")),
        &["nodes.s", "remembers", "carried variable"],
    );
}

/// A few small texts that name one another often would be millions of nodes.
#[test]
fn files_and_groups_that_multiply_are_refused() {
    let text = |inner: &str, times: usize| {
        let nodes: Vec<_> = (0..times).map(|i| format!(r#""n{i}": {inner}"#)).collect();
        let nodes = nodes.join(", ");
        format!(r#"{{ "strahl_graph": 1, "nodes": {{ {nodes} }}, "roots": {{ "color": "n0" }} }}"#)
    };
    let read = |times: usize, files: usize| {
        let mut opened = 0;
        let outermost = text(r#"{ "graph_file": "1" }"#, times);
        let asked = GraphUse::read("0", &outermost, &mut |path| {
            opened += 1;
            let number: usize = path.parse().unwrap();
            Ok(match number < files {
                true => text(&format!(r#"{{ "graph_file": "{}" }}"#, number + 1), times),
                false => text(r#"{ "wgsl": "fn f() -> vec4f { return vec4f(1.0); }" }"#, 1),
            })
        });
        (opened, asked.err().map(|error| error.to_string()))
    };
    for (times, files) in [(10, 15), (2, 15)] {
        let (opened, said) = read(times, files);
        assert!(opened <= 1000, "{opened}");
        assert_says(&said.unwrap(), &["more than 1000 files are named"]);
    }
    assert_eq!(read(2, 5), (62, None));

    // In one text, where each stands.
    let mut inner = r#"{ "wgsl": "fn f() -> vec4f { return vec4f(1.0); }" }"#.to_owned();
    for _ in 0..4 {
        inner = format!(r#"{{ "graph": {} }}"#, text(&inner, 10));
    }
    let said = refused(&text(&inner, 2));
    assert_says(&said, &["groups unfold to more nodes"]);
    // And so are few with long names.
    let long = "n".repeat(1 << 14);
    let mut inner = r#"{ "wgsl": "fn f() -> vec4f { return vec4f(1.0); }" }"#.to_owned();
    for _ in 0..30 {
        let node = format!(r#""{long}": {inner}"#);
        inner = format!(
            r#"{{ "graph": {{ "strahl_graph": 1, "nodes": {{ {node} }}, "roots": {{ "out": "{long}" }} }} }}"#
        );
    }
    let said = refused(&text(&inner, 10));
    assert_says(&said, &["longer names"]);
}

#[test]
fn large_graphs_full_of_mistakes_are_refused_soon() {
    let mut nodes = Vec::new();
    for i in 0..15_000 {
        nodes.push(format!(
            r#""n{i}": {{ "pattern": "rest_of", "inputs": {{ "a": "m{i}" }} }}"#
        ));
    }
    let said = refused(&showing(&nodes.join(", "), "n0"));
    assert_says(&said, &["there is no node `m0`"]);
    assert!(said.lines().count() < 60, "{}", said.lines().count());
    for i in 15_000..20_001 {
        nodes.push(format!(
            r#""n{i}": {{ "pattern": "rest_of", "inputs": {{ "a": "m{i}" }} }}"#
        ));
    }
    let said = refused(&showing(&nodes.join(", "), "n0"));
    assert_says(&said, &["a graph has at most 20000"]);
    assert_eq!(said.lines().count(), 1);
}
