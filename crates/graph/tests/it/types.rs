//! Types have to be equal, and meanings as well.

use crate::{assert_says, computed, refused, showing, shown};

#[test]
fn types_have_to_be_equal() {
    let nodes = r#""ray": { "pattern": "ray" },
        "one": { "pattern": "rest_of", "inputs": { "a": "ray.direction" } }"#;
    assert_says(
        &refused(&showing(nodes, "one")),
        &[
            "nodes.one.inputs.a",
            "`ray.direction` is vec3f",
            "`a` needs f32",
        ],
    );
}

#[test]
fn a_component_is_a_number() {
    let nodes = r#""u": { "uniform": "vec3f", "value": [1, 2, 3] },
        "one": { "pattern": "rest_of", "inputs": { "a": "u.z" } }"#;
    assert_eq!(computed(&showing(nodes, "one"))[0], -2.0);
    let wrong = nodes.replace("u.z", "u.w");
    assert_says(
        &refused(&showing(&wrong, "one")),
        &["a vec3f has no member `w`", "x, y, z"],
    );
}

#[test]
fn whole_numbers_do_not_become_floats_by_themselves() {
    let nodes = r#""u": { "uniform": "u32", "value": 3 },
        "one": { "pattern": "rest_of", "inputs": { "a": "u" } }"#;
    assert_says(
        &refused(&showing(nodes, "one")),
        &["`u` is u32", "needs f32"],
    );
    let explicit = r#""u": { "uniform": "u32", "value": 3 },
        "f": { "pattern": "number_of_index", "inputs": { "index": "u" } },
        "one": { "pattern": "rest_of", "inputs": { "a": "f" } }"#;
    assert_eq!(computed(&showing(explicit, "one"))[0], -2.0);
}

#[test]
fn a_number_fills_a_vector_and_takes_the_type_of_its_port() {
    let nodes = r#""v": { "wgsl": "fn v(a: vec3f, b: i32, c: u32) -> vec3f { return a * f32(b) + f32(c); }",
        "inputs": { "a": 2, "b": -3, "c": 4 } }"#;
    let text = shown(nodes, r#"{ "x": "v.x", "y": "v.y", "z": "v.zxy.x" }"#);
    assert_eq!(computed(&text), [-2.0; 3]);
}

#[test]
fn constants_fit_their_ports() {
    let with = |inputs: &str| {
        let nodes = format!(
            r#""v": {{ "wgsl": "/// v: default (0, 0, 0)\n/// n: default 0\n/// b: default false\nfn v(v: vec3f, n: u32, b: bool) -> f32 {{ return v.x + f32(n); }}", "inputs": {{ {inputs} }} }}"#
        );
        refused(&showing(&nodes, "v"))
    };
    assert_says(
        &with(r#""v": [1, 2]"#),
        &["nodes.v.inputs.v", "[1.0, 2.0] is no vec3f"],
    );
    assert_says(&with(r#""n": -1"#), &["nodes.v.inputs.n", "-1 is no u32"]);
    assert_says(&with(r#""n": 1.5"#), &["1.5 is no u32"]);
    assert_says(&with(r#""b": 1"#), &["1 is no bool"]);
    assert_says(&with(r#""v": true"#), &["true is no vec3f"]);
    assert_says(&with(r#""v": 1e300"#), &["no number that an f32 can hold"]);
}

#[test]
fn inputs_without_a_default_have_to_be_connected() {
    let nodes = r#""s": { "pattern": "add", "inputs": { "a": 1 } }"#;
    assert_says(
        &refused(&showing(nodes, "s")),
        &[
            "nodes.s.inputs.b",
            "not connected",
            "no default",
            "needs f32",
        ],
    );
}

#[test]
fn every_problem_is_said_at_once() {
    let nodes = r#""a": { "pattern": "add", "inputs": { "a": 1 } },
        "b": { "pattern": "add", "inputs": { "a": true, "b": "a", "d": 2 } }"#;
    assert_says(
        &refused(&showing(nodes, "b")),
        &[
            "nodes.a.inputs.b",
            "nodes.b.inputs.a",
            "true is no f32",
            "nodes.b.inputs.d",
            "no such input",
        ],
    );
}

#[test]
fn roots_have_types_and_names() {
    let text = |roots: &str| {
        format!(
            r#"{{ "strahl_graph": 1, "nodes": {{ "u": {{ "uniform": "f32", "value": 1 }} }}, "roots": {{ {roots} }} }}"#
        )
    };
    assert_says(
        &refused(&text(r#""color": "u""#)),
        &["roots.color", "`u` is f32", "needs vec4f"],
    );
    assert_says(
        &refused(&text(r#""colour": "u""#)),
        &["roots.colour", "`color`", "`depth_mm`"],
    );
    assert_says(&refused(&text("")), &["roots", "nothing is wanted"]);
}

#[test]
fn both_branches_of_an_if_have_one_type() {
    let nodes = r#""u": { "uniform": "f32", "value": 1 }, "i": { "uniform": "u32", "value": 1 },
        "c": { "pattern": "above", "inputs": { "a": "u" } },
        "either": { "if": "c", "then": { "x": "u" }, "else": { "x": "i" } }"#;
    assert_says(
        &refused(&showing(nodes, "either.x")),
        &["nodes.either.inputs.else.x", "`i` is u32", "needs f32"],
    );
    let missing = nodes.replace(r#""else": { "x": "i" }"#, r#""else": { "y": "u" }"#);
    assert_says(
        &refused(&showing(&missing, "either.x")),
        &["nodes.either.inputs.else.x", "missing"],
    );
}

#[test]
fn an_if_asks_for_a_truth() {
    let nodes = r#""u": { "uniform": "f32", "value": 1 },
        "either": { "if": "u", "then": { "x": 1 }, "else": { "x": "u" } }"#;
    assert_says(
        &refused(&showing(nodes, "either.x")),
        &["nodes.either", "`u` is f32", "needs bool"],
    );
}

#[test]
fn parameters_are_checked() {
    let with = |params: &str| {
        let nodes = format!(
            r#""u": {{ "uniform": "f32", "value": 1 }},
            "o": {{ "pattern": "is_opaque", "inputs": {{ "opacity": "u" }}, "params": {{ {params} }} }},
            "e": {{ "if": "o", "then": {{ "x": 1 }}, "else": {{ "x": "u" }} }}"#
        );
        refused(&showing(&nodes, "e.x"))
    };
    assert_says(
        &with(r#""stop": 0.1"#),
        &[
            "nodes.o.params.stop",
            "no such parameter",
            "stop_at_transmittance",
        ],
    );
    assert_says(
        &with(r#""stop_at_transmittance": 2"#),
        &["nodes.o.params.stop_at_transmittance", "2"],
    );
}
