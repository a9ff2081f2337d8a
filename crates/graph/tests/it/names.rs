//! Names: which are allowed, and that they never collide.

use crate::{assert_says, compiled, computed, refused, showing, shown};

fn named(name: &str) -> String {
    showing(
        &format!(r#""{name}": {{ "uniform": "f32", "value": 1 }}"#),
        name,
    )
}

#[test]
fn words_of_wgsl_are_no_names() {
    for word in [
        "of",
        "fn",
        "loop",
        "let",
        "texture_2d",
        "vec3f",
        "struct",
        "self",
        "class",
    ] {
        let is_reserved = naga::keywords::wgsl::RESERVED.contains(&word);
        if is_reserved {
            assert_says(
                &refused(&named(word)),
                &[
                    &format!("nodes.{word}"),
                    "is a word of WGSL",
                    "another name",
                ],
            );
        } else {
            // Names of types can be hidden; whoever reads them must still get the type.
            assert_eq!(computed(&named(word))[0], 1.0, "{word}");
        }
    }
    assert!(naga::keywords::wgsl::RESERVED.contains(&"of"));
}

#[test]
fn names_have_letters_digits_and_underscores() {
    for name in ["", "1st", "_a", "a-b", "a b", "ä"] {
        assert_says(
            &refused(&named(name)),
            &["letters, digits and `_`, and begins with a letter"],
        );
    }
    let long = "a".repeat(101);
    assert_says(&refused(&named(&long)), &["more than 100 letters"]);
    assert_eq!(computed(&named(&"a".repeat(100)))[0], 1.0);
}

#[test]
fn variables_of_loops_have_names_of_the_same_kind() {
    let nodes = r#""w": { "loop": { "carry": { "of": { "type": "f32", "start": 0, "next": 1 } }, "while": "go" } },
        "go": { "pattern": "above", "inputs": { "a": 1, "b": "w.of" } }"#;
    assert_says(
        &refused(&showing(nodes, "w.last.of")),
        &["nodes.w.loop.carry.of", "is a word of WGSL"],
    );
}

#[test]
fn a_name_stands_once() {
    let text = showing(
        r#""a": { "uniform": "f32", "value": 1 }, "a": { "uniform": "f32", "value": 2 }"#,
        "a",
    );
    assert_says(&refused(&text), &["test:1", "`a`", "twice"]);
    let mut graph = crate::parsed(&named("a"));
    let second = graph.nodes[0].clone();
    graph.nodes.push(second);
    let message = crate::compile(&graph).unwrap_err().to_string();
    assert_says(&message, &["nodes.a", "two nodes of this name"]);
}

#[test]
fn names_do_not_collide_when_they_are_joined() {
    // `a_b` and its output `c` against `a` and its output `b_c`.
    let two = |node: &str, output: &str, plus: f32| {
        format!(
            r#""{node}": {{ "wgsl": [
                "fn f(v: f32) -> R {{ return R(v + {plus:?}, v); }}", "struct R {{ {output}: f32, rest: f32 }}"
            ], "inputs": {{ "v": "u" }} }}"#
        )
    };
    let nodes = format!(
        r#""u": {{ "uniform": "f32", "value": 1 }}, {}, {}"#,
        two("a_b", "c", 10.0),
        two("a", "b_c", 20.0)
    );
    let text = shown(&nodes, r#"{ "x": "a_b.c", "y": "a.b_c" }"#);
    assert_eq!(computed(&text)[..2], [11.0, 21.0]);
    // As outputs of ifs and variables of loops, which are variables of the program.
    let nodes = r#""u": { "uniform": "f32", "value": 1 },
        "c": { "pattern": "above", "inputs": { "a": "u" } },
        "a_b": { "if": "c", "then": { "c": 11 }, "else": { "c": "u" } },
        "a": { "if": "c", "then": { "b_c": 21 }, "else": { "b_c": "u" } },
        "a_b_c": { "pattern": "rest_of", "inputs": { "a": "u" } }"#;
    let text = shown(nodes, r#"{ "x": "a_b.c", "y": "a.b_c", "z": "a_b_c" }"#);
    assert_eq!(computed(&text), [11.0, 21.0, 0.0]);
}

#[test]
fn names_of_the_surroundings_can_be_given_again() {
    // Functions and variables of the ray loop, and words that the linker writes.
    for name in [
        "frame",
        "march",
        "ray_of",
        "hit_mm",
        "parameters",
        "volume",
        "color",
        "pixel",
        "node_u",
        "current",
        "table",
        "Surface",
    ] {
        assert_eq!(computed(&named(name))[0], 1.0, "{name}");
    }
}

#[test]
fn words_of_a_function_are_its_own() {
    let nodes = r#""v": { "uniform": "f32", "value": 4 }, "inner": { "uniform": "f32", "value": 5 },
        "f": { "wgsl": "fn f(v: f32) -> f32 { let inner = 2.0 * v; return inner + helper(inner); } fn helper(out: f32) -> f32 { return out; }", "inputs": { "v": "v" } },
        "g": { "wgsl": "fn f(v: f32) -> f32 { return helper(v); } fn helper(out: f32) -> f32 { return -out; }", "inputs": { "v": "inner" } }"#;
    let text = shown(nodes, r#"{ "x": "f", "y": "g", "z": "inner" }"#);
    assert_eq!(computed(&text), [16.0, -5.0, 5.0]);
}

#[test]
fn what_is_meant_is_guessed_in_the_message() {
    let nodes = r#""opacity": { "uniform": "f32", "value": 4 }"#;
    assert_says(
        &refused(&showing(nodes, "opacty")),
        &[
            "nodes.out.inputs.x",
            "no node `opacty`",
            "did you mean `opacity`",
        ],
    );
}

#[test]
fn one_function_of_many_nodes_stands_once_in_the_program() {
    let node = |name: &str, from: &str| {
        format!(
            r#""{name}": {{ "wgsl": "fn twice(v: f32) -> f32 {{ return 2.0 * v; }}", "inputs": {{ "v": "{from}" }} }}"#
        )
    };
    let nodes = format!(
        r#""u": {{ "uniform": "f32", "value": 1.5 }}, {}, {}, {}"#,
        node("a", "u"),
        node("b", "a"),
        node("c", "b")
    );
    let text = showing(&nodes, "c");
    let compiled = compiled(&text);
    assert_eq!(
        compiled.program.wgsl().matches("return 2.0 * v;").count(),
        1
    );
    assert_eq!(computed(&text)[0], 12.0);
}

/// A function may have the name of one that every module may call: it hides that one within its text.
#[test]
fn functions_may_be_called_as_those_that_every_module_may_call() {
    let node = r#""n": { "wgsl": [
        "fn look(dims: f32) -> f32 { return dims + 1.0; }",
        "fn own_table() -> f32 { return 0.5; }",
        "fn table(x: f32) -> f32 { return look(x) * own_table(); }"
    ], "inputs": { "x": 0.25 } }"#;
    assert_eq!(computed(&showing(node, "n"))[0], 0.625);
}
