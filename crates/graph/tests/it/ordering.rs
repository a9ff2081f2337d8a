//! Which nodes are computed, and in which order.

use crate::{compiled, computed, march, parsed, showing, shown, values_of};

/// Fig. 32 of the source: two roots; n1 reads n4 and n7, n4 reads n7; n2 reads n5 and n6; nobody reads n3.
fn test_vector(order: [&str; 7]) -> String {
    let node = |name: &str| {
        let (inputs, ty, args) = match name {
            "n1" => (r#""a": "n4", "b": "n7""#, "vec4f", "a: f32, b: f32"),
            "n4" => (r#""a": "n7""#, "f32", "a: f32"),
            "n2" => (r#""a": "n5", "b": "n6""#, "f32", "a: f32, b: f32"),
            _ => (r#""a": "u""#, "f32", "a: f32"),
        };
        // Each its own function, so that no two are equal.
        let b = if args.contains("b:") { " + b" } else { "" };
        format!(
            r#""{name}": {{ "wgsl": "fn of_{name}({args}) -> {ty} {{ return {ty}(sin(a){b} * 0.{}); }}", "inputs": {{ {inputs} }} }}"#,
            &name[1..]
        )
    };
    let nodes: Vec<_> = order.iter().map(|name| node(name)).collect();
    format!(
        r#"{{ "strahl_graph": 1, "nodes": {{ "u": {{ "uniform": "f32", "value": 1 }}, {} }},
        "roots": {{ "color": "n1", "depth_mm": "n2" }} }}"#,
        nodes.join(",\n")
    )
}

#[test]
fn the_test_vector_of_the_source_comes_by_depth() {
    let text = test_vector(["n1", "n2", "n3", "n4", "n5", "n6", "n7"]);
    let order = values_of(&compiled(&text));
    assert_eq!(order, ["u", "n7", "n4", "n5", "n6", "n1", "n2"]);
}

#[test]
fn sources_come_before_readers_whatever_the_text_says() {
    let text = test_vector(["n7", "n6", "n5", "n4", "n3", "n2", "n1"]);
    let order = values_of(&compiled(&text));
    let place = |name: &str| order.iter().position(|n| n == name).unwrap();
    for (source, reader) in [("n7", "n4"), ("n4", "n1"), ("n5", "n2"), ("n6", "n2")] {
        assert!(place(source) < place(reader), "{order:?}");
    }
    assert_eq!(order.len(), 7);
}

#[test]
fn the_same_graph_makes_the_same_text_each_time() {
    let text = test_vector(["n3", "n1", "n5", "n2", "n7", "n4", "n6"]);
    let first = compiled(&text).program.wgsl().to_owned();
    for _ in 0..5 {
        assert_eq!(compiled(&text).program.wgsl(), first);
    }
}

#[test]
fn what_nobody_needs_is_left_out_with_a_warning() {
    let text = test_vector(["n1", "n2", "n3", "n4", "n5", "n6", "n7"]);
    let compiled = compiled(&text);
    let warnings: Vec<_> = compiled.warnings.iter().map(|w| w.to_string()).collect();
    assert_eq!(warnings, ["nodes.n3: no root needs it; it is left out"]);
    assert!(!compiled.program.wgsl().contains("of_n3"));
}

#[test]
fn uniforms_and_textures_that_nobody_reads_are_not_declared() {
    let nodes = r#"
        "used": { "uniform": "f32", "value": 2 },
        "unused": { "uniform": "f32", "value": 3 },
        "first": { "texture": { "size": [1, 1], "texels": [[0.1, 0, 0, 0]] } },
        "second": { "texture": { "size": [1, 1], "texels": [[0.7, 0, 0, 0]] } },
        "third": { "texture": { "size": [1, 1], "texels": [[0.9, 0, 0, 0]] } },
        "read": { "pattern": "sample_2d", "inputs": { "image": "second", "place": 0.5 } },
        "unread": { "pattern": "sample_2d", "inputs": { "image": "third", "place": 0.5 } },
        "choice": { "if": true, "then": { "x": "read.x" }, "else": { "x": "unread.x" } }"#;
    let text = shown(nodes, r#"{ "x": "choice.x", "y": "used" }"#);
    let compiled = compiled(&text);
    let wgsl = compiled.program.wgsl();
    assert!(wgsl.contains("texture_second") && wgsl.contains("node_used"));
    for absent in ["texture_first", "texture_third", "unused", "unread"] {
        assert!(!wgsl.contains(absent), "{absent}:\n{wgsl}");
    }
    let names: Vec<_> = compiled.textures.iter().map(|(name, ..)| name).collect();
    assert_eq!(names, ["second"]);
    assert_eq!(compiled.program.blocks().len(), 1);
    assert_eq!(computed(&text)[..2], [0.7, 2.0]);
}

#[test]
fn a_graph_may_have_one_root_or_two() {
    let nodes = r#""u": { "uniform": "f32", "value": 7 }"#;
    let two =
        showing(nodes, "u").replace(r#""color": "out""#, r#""color": "out", "depth_mm": "u""#);
    assert!(march(&compiled(&two)).contains("hit_mm = u;"));
    assert!(!march(&compiled(&showing(nodes, "u"))).contains("hit_mm"));
}

#[test]
fn comments_of_nodes_stand_before_them() {
    let nodes = r#""u": { "uniform": "f32", "value": 7 },
        "d": { "pattern": "rest_of", "comment": "what\nremains", "inputs": { "a": "u" } }"#;
    let text = march(&compiled(&showing(nodes, "d")));
    assert!(text.contains("// what remains\n    let d = "), "{text}");
}

#[test]
fn outputs_are_read_by_any_number() {
    let nodes = r#""u": { "uniform": "f32", "value": 3 },
        "a": { "pattern": "multiply", "inputs": { "a": "u", "b": "u" } },
        "b": { "pattern": "add", "inputs": { "a": "a", "b": "u" } },
        "c": { "pattern": "add", "inputs": { "a": "a", "b": "b" } }"#;
    let text = shown(nodes, r#"{ "x": "a", "y": "b", "z": "c" }"#);
    assert_eq!(computed(&text), [9.0, 12.0, 21.0]);
    let calls = march(&compiled(&text));
    assert_eq!(calls.matches("node_product(").count(), 1, "{calls}");
    assert_eq!(parsed(&text).nodes.len(), 5);
}
