//! Loops: what they carry, when they end, and what may leave them.

use crate::{assert_says, compiled, computed, march, refused, showing, shown};

/// Sums 0 + 1 + … as long as the number is below `limit`.
fn counting(limit: f64, more: &str) -> String {
    format!(
        r#""n": {{ "uniform": "f32", "value": {limit} }},
        "count": {{ "loop": {{ "carry": {{
            "i": {{ "type": "f32", "start": 0, "next": "next" }},
            "sum": {{ "type": "f32", "start": 0, "next": "added" }}
        }}, "while": "goes_on" }} }},
        "goes_on": {{ "pattern": "above", "inputs": {{ "a": "n", "b": "count.i" }} }},
        "next": {{ "pattern": "add", "inputs": {{ "a": "count.i", "b": 1 }} }},
        "added": {{ "pattern": "add", "inputs": {{ "a": "count.sum", "b": "count.i" }} }}{more}"#
    )
}

#[test]
fn a_loop_hands_its_variables_on() {
    let text = shown(
        &counting(10.0, ""),
        r#"{ "x": "count.last.sum", "y": "count.last.i" }"#,
    );
    assert_eq!(computed(&text)[..2], [45.0, 10.0]);
}

#[test]
fn a_loop_without_a_turn_gives_its_start() {
    assert_eq!(
        computed(&showing(&counting(-1.0, ""), "count.last.sum"))[0],
        0.0
    );
}

#[test]
fn until_ends_a_loop_after_the_turn() {
    let nodes = r#""u": { "uniform": "f32", "value": 3 },
        "count": { "loop": { "carry": { "i": { "type": "f32", "start": 0, "next": "next" } }, "until": "enough" } },
        "next": { "pattern": "add", "inputs": { "a": "count.i", "b": 1 } },
        "enough": { "pattern": "reaches", "inputs": { "a": "next", "b": "u" } }"#;
    assert_eq!(computed(&showing(nodes, "count.last.i"))[0], 3.0);
    let at_once = nodes.replace(r#""value": 3"#, r#""value": -5"#);
    assert_eq!(computed(&showing(&at_once, "count.last.i"))[0], 1.0);
}

#[test]
fn a_variable_needs_an_initial_value() {
    let nodes = counting(3.0, "").replace(
        r#""type": "f32", "start": 0, "next": "added""#,
        r#""type": "f32", "next": "added""#,
    );
    assert_says(
        &refused(&showing(&nodes, "count.last.sum")),
        &["nodes.count.loop.carry.sum", "no initial value", "`start`"],
    );
}

#[test]
fn the_type_of_a_number_is_not_guessed() {
    let nodes = counting(3.0, "").replace(r#""sum": { "type": "f32", "#, r#""sum": { "#);
    assert_says(
        &refused(&showing(&nodes, "count.last.sum")),
        &["count.sum", "does not follow from a number", "`type`"],
    );
}

#[test]
fn a_variable_takes_the_type_of_the_output_that_it_starts_with() {
    let nodes = counting(4.0, "").replace(
        r#""sum": { "type": "f32", "start": 0,"#,
        r#""sum": { "start": "n","#,
    );
    assert_eq!(computed(&showing(&nodes, "count.last.sum"))[0], 4.0 + 6.0);
}

#[test]
fn a_loop_needs_an_end() {
    let nodes = counting(3.0, "").replace(r#", "while": "goes_on""#, "");
    assert_says(
        &refused(&showing(&nodes, "count.last.sum")),
        &["nodes.count.loop", "never ends", "`while` or `until`"],
    );
}

#[test]
fn a_variable_is_carried_by_the_name_of_an_output() {
    let nodes = r#""u": { "uniform": "f32", "value": 4 },
        "walk": { "loop": { "carry": {
            "i": { "type": "f32", "start": 0 }, "power": { "type": "f32", "start": 1 }
        }, "while": "goes_on" } },
        "goes_on": { "pattern": "above", "inputs": { "a": "u", "b": "walk.i" } },
        "turn": { "wgsl": [
            "fn turn(i_now: f32, power_now: f32) -> Turn { return Turn(i_now + 1.0, 2.0 * power_now); }",
            "struct Turn { i: f32, power: f32 }"
        ], "inputs": { "i_now": "walk.i", "power_now": "walk.power" } }"#;
    assert_eq!(computed(&showing(nodes, "walk.last.power"))[0], 16.0);
    let none = nodes.replace("power: f32 }", "force: f32 }");
    assert_says(
        &refused(&showing(&none, "walk.last.power")),
        &[
            "nodes.walk.loop.carry.power",
            "no next value",
            "output `power`",
        ],
    );
    let several = format!(
        "{nodes}, {}",
        r#""other": { "wgsl": [
            "fn other(a: f32) -> Other { return Other(a, a); }", "struct Other { power: f32, b: f32 }"
        ], "inputs": { "a": "walk.i" } }"#
    );
    assert_says(
        &refused(&showing(&several, "walk.last.power")),
        &[
            "several nodes have the output `power`",
            "turn, other",
            "set `next`",
        ],
    );
}

#[test]
fn loops_stand_in_one_another() {
    // Σ over i < 4 of Σ over j < i of j.
    let nodes = r#""n": { "uniform": "f32", "value": 4 },
        "outer": { "loop": { "carry": {
            "i": { "type": "f32", "start": 0, "next": "next_i" },
            "sum": { "type": "f32", "start": 0, "next": "inner.last.sum" }
        }, "while": "outer_goes_on" } },
        "outer_goes_on": { "pattern": "above", "inputs": { "a": "n", "b": "outer.i" } },
        "next_i": { "pattern": "add", "inputs": { "a": "outer.i", "b": 1 } },
        "inner": { "loop": { "carry": {
            "j": { "type": "f32", "start": 0, "next": "next_j" },
            "sum": { "type": "f32", "start": "outer.sum", "next": "added" }
        }, "while": "inner_goes_on" } },
        "inner_goes_on": { "pattern": "above", "inputs": { "a": "outer.i", "b": "inner.j" } },
        "next_j": { "pattern": "add", "inputs": { "a": "inner.j", "b": 1 } },
        "added": { "pattern": "add", "inputs": { "a": "inner.sum", "b": "inner.j" } }"#;
    let text = showing(nodes, "outer.last.sum");
    assert_eq!(computed(&text)[0], 0.0 + 0.0 + 1.0 + 3.0);
    let march = march(&compiled(&text));
    assert_eq!(march.matches("loop {").count(), 2, "{march}");
}

#[test]
fn variables_that_read_one_another_change_at_once() {
    // Fibonacci by two variables that swap.
    let nodes = r#""n": { "uniform": "f32", "value": 9 },
        "walk": { "loop": { "carry": {
            "i": { "type": "f32", "start": 0, "next": "next" },
            "a": { "type": "f32", "start": 0, "next": "walk.b" },
            "b": { "type": "f32", "start": 1, "next": "sum" }
        }, "while": "goes_on" } },
        "goes_on": { "pattern": "above", "inputs": { "a": "n", "b": "walk.i" } },
        "next": { "pattern": "add", "inputs": { "a": "walk.i", "b": 1 } },
        "sum": { "pattern": "add", "inputs": { "a": "walk.a", "b": "walk.b" } }"#;
    assert_eq!(
        computed(&shown(
            nodes,
            r#"{ "x": "walk.last.a", "y": "walk.last.b" }"#
        ))[..2],
        [34.0, 55.0]
    );
    // Two that change places, by copies that vanish.
    let nodes = nodes.replace(r#""next": "sum""#, r#""next": "same""#)
        + r#", "same": { "wgsl": "fn same(v: f32) -> f32 { return v; }", "inputs": { "v": "walk.a" } }"#;
    assert_eq!(
        computed(&shown(
            &nodes,
            r#"{ "x": "walk.last.a", "y": "walk.last.b" }"#
        ))[..2],
        [1.0, 0.0]
    );
}

#[test]
fn what_is_inside_cannot_be_read_from_outside() {
    let text = showing(
        &counting(
            3.0,
            r#", "leak": { "pattern": "rest_of", "inputs": { "a": "added" } }"#,
        ),
        "leak",
    );
    assert_says(
        &refused(&text),
        &[
            "roots.color",
            "inside the loop count",
            "count → added → leak → out",
            "NAME.last.VARIABLE",
        ],
    );
}

#[test]
fn a_carried_variable_is_no_root() {
    let message = refused(&showing(&counting(3.0, ""), "count.sum"));
    assert_says(&message, &["roots.color", "count → out"]);
}

#[test]
fn loops_cannot_be_each_inside_the_other() {
    let nodes = r#""a": { "loop": { "carry": { "x": { "type": "f32", "start": 0, "next": "both" } }, "while": "go" } },
        "b": { "loop": { "carry": { "x": { "type": "f32", "start": 0, "next": "both" } }, "while": "go" } },
        "both": { "pattern": "add", "inputs": { "a": "a.x", "b": "b.x" } },
        "go": { "pattern": "above", "inputs": { "a": "both" } }"#;
    assert_says(
        &refused(&showing(nodes, "a.last.x")),
        &["the loops `a` and `b` are each inside the other"],
    );
}

#[test]
fn a_node_is_in_loops_that_are_nested_only() {
    let walk = |name: &str| {
        format!(
            r#""{name}": {{ "loop": {{ "carry": {{ "x": {{ "type": "f32", "start": 0, "next": "next_{name}" }} }}, "while": "go_{name}" }} }},
            "next_{name}": {{ "pattern": "add", "inputs": {{ "a": "{name}.x", "b": 1 }} }},
            "go_{name}": {{ "pattern": "above", "inputs": {{ "a": 3, "b": "{name}.x" }} }}"#
        )
    };
    let nodes = format!(
        r#"{}, {}, "mixed": {{ "pattern": "add", "inputs": {{ "a": "a.x", "b": "b.x" }} }}"#,
        walk("a"),
        walk("b")
    );
    let text = showing(&nodes, "mixed");
    assert_says(
        &refused(&text),
        &["nodes.mixed", "none is in the other", "a, b"],
    );
}

#[test]
fn what_does_not_change_is_computed_before_the_loop() {
    let nodes = counting(5.0, r#", "still": { "wgsl": "fn still(a: f32) -> f32 { return sin(a); }", "inputs": { "a": "n" } }"#)
        .replace(r#""a": "count.sum", "b": "count.i""#, r#""a": "count.sum", "b": "still""#);
    let text = showing(&nodes, "count.last.sum");
    let march = march(&compiled(&text));
    assert!(
        march.find("node_still(").unwrap() < march.find("loop {").unwrap(),
        "{march}"
    );
    let expected = (0..5).fold(0.0f32, |sum, _| sum + 5.0f32.sin());
    assert!((computed(&text)[0] - expected).abs() < 1e-5);
}

#[test]
fn a_loop_that_may_not_end_is_ended() {
    let nodes = r#""n": { "uniform": "f32", "value": 1 },
        "walk": { "loop": { "carry": { "i": { "type": "u32", "start": 0, "next": "next" } }, "while": "goes_on" } },
        "goes_on": { "pattern": "above", "inputs": { "a": "n" } },
        "next": { "wgsl": "fn next(i: u32) -> u32 { return i + 1u; }", "inputs": { "i": "walk.i" } },
        "turns": { "pattern": "number_of_index", "inputs": { "index": "walk.last.i" } }"#;
    let text = showing(nodes, "turns");
    // Nobody shall take what it has got to for what it means.
    assert!(computed(&text).iter().all(|number| number.is_nan()));
    let turns = |n: u32| {
        text.replace("\"pattern\": \"above\", \"inputs\": { \"a\": \"n\" }", &format!(
        "\"wgsl\": \"fn below(i: u32) -> bool {{ return i < {n}u; }}\", \"inputs\": {{ \"i\": \"walk.i\" }}"
    ))
    };
    let most = strahl_shader::MOST_TURNS;
    assert_eq!(computed(&turns(most - 1))[0], (most - 1) as f32);
    assert!(computed(&turns(most + 1))[0].is_nan());
}

#[test]
fn variables_are_named_in_messages() {
    assert_says(
        &refused(&showing(&counting(3.0, ""), "count.last.summ")),
        &["the loop `count` has no variable `summ`", "i, sum"],
    );
    assert_says(
        &refused(&showing(&counting(3.0, ""), "count")),
        &["name a variable of `count`", "count.last.NAME"],
    );
    let twice = counting(3.0, "")
        .replace(r#""sum": {"#, r#""last": {"#)
        .replace("count.sum", "count.last");
    assert_says(
        &refused(&showing(&twice, "count.last.i")),
        &["nodes.count.loop.carry.last", "taken"],
    );
}
