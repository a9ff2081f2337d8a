//! What is known is not computed, what is a copy is not copied, what is equal is there once.

use crate::{compiled, computed, march, showing, shown};

const U: &str = r#""u": { "uniform": "f32", "value": 3 }"#;

fn march_of(nodes: &str, from: &str) -> String {
    march(&compiled(&showing(&format!("{U}, {nodes}"), from)))
}

#[test]
fn constants_are_computed_when_the_graph_is_compiled() {
    let nodes = r#""a": { "pattern": "add", "inputs": { "a": 0.5, "b": 2 } },
        "b": { "pattern": "multiply", "inputs": { "a": "a", "b": "a" } },
        "c": { "pattern": "rest_of", "inputs": { "a": "b" } },
        "d": { "pattern": "least", "inputs": { "a": "c", "b": 7 } }"#;
    let text = showing(nodes, "d");
    assert_eq!(
        march(&compiled(&text)).lines().nth(1).unwrap().trim(),
        "return vec4f(-5.25, 0.0, 0.0, 1.0);"
    );
    assert_eq!(computed(&text)[0], -5.25);
}

#[test]
fn vectors_and_members_are_computed_too() {
    let nodes = r#""v": { "pattern": "scale", "inputs": { "v": [1, 2, 3], "factor": 2 } },
        "w": { "pattern": "mix", "inputs": { "a": "v", "b": "v.zyx", "share_of_b": 0.5 } }"#;
    let text = shown(nodes, r#"{ "x": "v.z", "y": "w.x", "z": "v.yx.y" }"#);
    assert_eq!(
        march(&compiled(&text)).lines().nth(1).unwrap().trim(),
        "return vec4f(6.0, 4.0, 2.0, 1.0);"
    );
    assert_eq!(computed(&text), [6.0, 4.0, 2.0]);
}

#[test]
fn functions_with_branches_and_structs_are_computed() {
    let nodes = r#""l": { "pattern": "larger", "inputs": { "value": 3, "lattice_point": 8, "best": 2, "best_point": 1, "found": true } },
        "m": { "pattern": "larger", "inputs": { "value": 1, "lattice_point": 8, "best": "l.value", "best_point": "l.lattice_point", "found": "l.found" } }"#;
    let text = shown(nodes, r#"{ "x": "m.value", "y": "m.lattice_point" }"#);
    assert_eq!(
        march(&compiled(&text)).lines().nth(1).unwrap().trim(),
        "return vec4f(3.0, 8.0, 0.0, 1.0);"
    );
}

#[test]
fn what_is_no_number_stays_in_the_program() {
    // 1 / 0 and the root of -1 are what the CPU makes of them.
    let nodes = r#""a": { "pattern": "mean", "inputs": { "sum": 1, "number": 0 } }"#;
    assert!(march_of(nodes, "a").contains("node_mean("));
    let nodes =
        r#""a": { "wgsl": "fn root(v: f32) -> f32 { return sqrt(v); }", "inputs": { "v": -1 } }"#;
    assert!(march_of(nodes, "a").contains("node_root("));
}

#[test]
fn functions_that_read_more_than_their_arguments_stay() {
    let nodes = r#""a": { "pattern": "step_opacity", "inputs": { "opacity": 0.5 } }"#;
    assert!(march_of(nodes, "a").contains("node_step_opacity("));
    // So do parameters, which can be set.
    let nodes = r#""o": { "pattern": "is_opaque", "inputs": { "opacity": 0.5 } }, "a": { "if": "o", "then": { "x": 1 }, "else": { "x": "u" } }"#;
    assert!(march_of(nodes, "a.x").contains("node_o("));
}

#[test]
fn copies_vanish() {
    let nodes = r#""same": { "wgsl": "fn same(v: f32) -> f32 { return v; }", "inputs": { "v": "u" } },
        "again": { "wgsl": "fn same(v: f32) -> f32 { let w = v; return w; }", "inputs": { "v": "same" } },
        "first": { "pattern": "interval_start", "inputs": { "interval_mm": "pair" } },
        "pair": { "wgsl": "fn pair(v: f32) -> vec2f { return vec2f(sin(v), v); }", "inputs": { "v": "again" } }"#;
    let text = march_of(nodes, "first");
    assert!(
        !text.contains("same(") && !text.contains("interval_start("),
        "{text}"
    );
    assert!(
        text.contains("node_pair(u)") && text.contains("node_out(pair.x,"),
        "{text}"
    );
}

#[test]
fn one_times_and_nothing_less_are_copies() {
    for (node, is_copy) in [
        (
            r#""pattern": "multiply", "inputs": { "a": "u", "b": 1 }"#,
            true,
        ),
        (
            r#""pattern": "multiply", "inputs": { "a": 1, "b": "u" }"#,
            true,
        ),
        (
            r#""pattern": "mean", "inputs": { "sum": "u", "number": 1 }"#,
            true,
        ),
        (
            r#""pattern": "select", "inputs": { "a": "u", "b": 1, "take_b": false }"#,
            true,
        ),
        (
            r#""pattern": "select", "inputs": { "a": "u", "b": "u", "take_b": "c" }"#,
            true,
        ),
        (
            r#""pattern": "multiply", "inputs": { "a": "u", "b": 2 }"#,
            false,
        ),
        (
            r#""pattern": "mean", "inputs": { "sum": 1, "number": "u" }"#,
            false,
        ),
        (
            r#""pattern": "select", "inputs": { "a": "u", "b": 1, "take_b": "c" }"#,
            false,
        ),
    ] {
        let nodes = format!(
            r#""c": {{ "pattern": "above", "inputs": {{ "a": "u" }} }}, "a": {{ {node} }}"#
        );
        let text = march_of(&nodes, "a");
        assert_eq!(text.contains("node_out(u,"), is_copy, "{node}\n{text}");
    }
}

#[test]
fn equal_nodes_are_one_also_when_they_become_equal() {
    let nodes = r#""a": { "wgsl": "fn wave(v: f32) -> f32 { return sin(v); }", "inputs": { "v": "u" } },
        "same": { "wgsl": "fn same(v: f32) -> f32 { return v; }", "inputs": { "v": "u" } },
        "b": { "wgsl": "fn wave(v: f32) -> f32 { return sin(v); }", "inputs": { "v": "same" } },
        "sum": { "pattern": "add", "inputs": { "a": "a", "b": "b" } }"#;
    let text = march_of(nodes, "sum");
    assert_eq!(text.matches("node_wave(").count(), 1, "{text}");
    assert!(text.contains("node_sum(a, a)"), "{text}");
}

#[test]
fn what_can_be_set_is_never_equal() {
    let nodes = r#""v": { "uniform": "f32", "value": 3 }, "sum": { "pattern": "add", "inputs": { "a": "u", "b": "v" } }"#;
    assert!(march_of(nodes, "sum").contains("node_sum(u, v)"));
}

#[test]
fn ifs_are_decided_when_the_condition_is_known() {
    let nodes = r#""is": { "pattern": "above", "inputs": { "a": 2, "b": 1 } },
        "a": { "wgsl": "fn wave(v: f32) -> f32 { return sin(v); }", "inputs": { "v": "u" } },
        "b": { "wgsl": "fn other(v: f32) -> f32 { return cos(v); }", "inputs": { "v": "u" } },
        "i": { "if": "is", "then": { "x": "a" }, "else": { "x": "b" } }"#;
    let text = march_of(nodes, "i.x");
    assert!(
        text.contains("node_wave(") && !text.contains("if ") && !text.contains("other"),
        "{text}"
    );
}

#[test]
fn ifs_with_equal_branches_and_outputs_that_nobody_reads_are_left_out() {
    let nodes = r#""c": { "pattern": "above", "inputs": { "a": "u" } },
        "a": { "wgsl": "fn wave(v: f32) -> f32 { return sin(v); }", "inputs": { "v": "u" } },
        "i": { "if": "c", "then": { "x": "a", "y": 1, "z": 5 }, "else": { "x": "a", "y": "u", "z": "u" } }"#;
    let text = march(&compiled(&shown(
        &format!("{U}, {nodes}"),
        r#"{ "x": "i.x", "y": "i.z" }"#,
    )));
    assert!(
        text.contains("i_z") && !text.contains("i_x") && !text.contains("i_y"),
        "{text}"
    );
}

#[test]
fn variables_of_loops_that_nobody_reads_or_that_never_change_are_left_out() {
    let nodes = r#""w": { "loop": { "carry": {
            "i": { "type": "f32", "start": 0, "next": "next" },
            "still": { "type": "f32", "start": "u", "next": "w.still" },
            "unread": { "type": "f32", "start": 0, "next": "odd" },
            "sum": { "type": "f32", "start": 0, "next": "added" }
        }, "while": "go" } },
        "go": { "pattern": "above", "inputs": { "a": "w.still", "b": "w.i" } },
        "odd": { "wgsl": "fn wave(v: f32) -> f32 { return sin(v); }", "inputs": { "v": "w.unread" } },
        "next": { "pattern": "add", "inputs": { "a": "w.i", "b": 1 } },
        "added": { "pattern": "add", "inputs": { "a": "w.sum", "b": "w.still" } }"#;
    let text = march_of(nodes, "w.last.sum");
    assert!(
        !text.contains("w_still") && !text.contains("w_unread") && !text.contains("wave"),
        "{text}"
    );
    assert_eq!(
        computed(&showing(&format!("{U}, {nodes}"), "w.last.sum"))[0],
        9.0
    );
}

#[test]
fn whole_numbers_wrap_as_on_the_processor() {
    let whole = |expression: &str, a: &str, b: &str| {
        format!(
            r#""a": {{ "wgsl": "fn f(a: u32, b: u32) -> u32 {{ return {expression}; }}", "inputs": {{ "a": {a}, "b": {b} }} }},
            "x": {{ "wgsl": "fn g(a: u32) -> f32 {{ return f32(a); }}", "inputs": {{ "a": "a" }} }}"#
        )
    };
    for (expression, a, b, expected) in [
        ("a + b", 4294967295u32, 2u32, 1u32),
        ("a * b", 2147483648, 3, 2147483648),
        ("a / b", 17, 5, 3),
        ("a % b", 17, 5, 2),
        ("(a & b) | (a ^ b)", 12, 10, 14),
        ("a >> b", 48, 4, 3),
        ("min(a, b) + max(a, b)", 7, 9, 16),
    ] {
        let text = showing(&whole(expression, &a.to_string(), &b.to_string()), "x");
        let march = march(&compiled(&text));
        assert!(
            march.contains(&format!("vec4f({:?},", expected as f32)),
            "{expression}: {march}"
        );
        // The same where it is not known.
        let uniform = format!(r#""ua": {{ "uniform": "u32", "value": {a} }}, "#)
            + &whole(expression, r#""ua""#, &b.to_string());
        assert_eq!(
            computed(&showing(&uniform, "x"))[0],
            expected as f32,
            "{expression}"
        );
    }
}
