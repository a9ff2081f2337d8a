//! Random graphs, compiled and evaluated, against an interpreter of the same nodes.

use crate::{compile, march, parsed, pixels, showing};
use proptest::prelude::*;

/// A node over nodes before it, by their numbers.
#[derive(Clone, Copy, Debug)]
enum Op {
    Constant(f32),
    Uniform(f32),
    PixelX,
    Add(usize, usize),
    Multiply(usize, usize),
    RestOf(usize),
    Least(usize, usize),
    Tame(usize),
    Same(usize),
    /// Both are computed.
    Select(usize, usize, usize),
    /// One is computed.
    If(usize, usize, usize),
    /// So many turns: x becomes tame(x + y + k).
    Loop(u8, usize, usize),
    /// A loop in a loop: what the inner one adds up each turn.
    Nested(u8, usize, usize),
}

fn op(number: usize) -> impl Strategy<Value = Op> {
    let before = 0..number.max(1);
    let small = (-3i8..=3).prop_map(|n| f32::from(n) * 0.5);
    (
        0..13u8,
        before.clone(),
        before.clone(),
        before,
        small,
        0..5u8,
    )
        .prop_map(move |(kind, a, b, c, value, turns)| match kind {
            _ if number == 0 => Op::PixelX,
            0 | 1 => Op::Constant(value),
            2 => Op::Uniform(value),
            3 => Op::Add(a, b),
            4 => Op::Multiply(a, b),
            5 => Op::RestOf(a),
            6 => Op::Least(a, b),
            7 => Op::Tame(a),
            8 => Op::Same(a),
            9 => Op::Select(a, b, c),
            10 => Op::If(a, b, c),
            11 => Op::Loop(turns, a, b),
            _ => Op::Nested(turns, a, b),
        })
}

fn ops() -> impl Strategy<Value = Vec<Op>> {
    (1..24usize).prop_flat_map(|n| (0..n).map(op).collect::<Vec<_>>())
}

fn tame(x: f32) -> f32 {
    x / (1.0 + x.abs())
}

fn interpreted(ops: &[Op], pixel_x: f32) -> f32 {
    let mut values: Vec<f32> = Vec::new();
    for op in ops {
        let value = match *op {
            Op::Constant(value) | Op::Uniform(value) => value,
            Op::PixelX => pixel_x,
            Op::Add(a, b) => values[a] + values[b],
            Op::Multiply(a, b) => values[a] * values[b],
            Op::RestOf(a) => 1.0 - values[a],
            Op::Least(a, b) => values[a].min(values[b]),
            Op::Tame(a) => tame(values[a]),
            Op::Same(a) => values[a],
            Op::Select(a, b, c) | Op::If(a, b, c) => {
                if values[c] > 0.0 {
                    values[b]
                } else {
                    values[a]
                }
            }
            Op::Loop(turns, a, b) => {
                let mut x = values[a];
                for k in 0..turns {
                    x = tame((x + values[b]) + f32::from(k));
                }
                x
            }
            Op::Nested(turns, a, b) => {
                let mut x = values[a];
                for k in 0..turns {
                    let mut y = x;
                    for _ in 0..k {
                        y = tame(y + values[b]);
                    }
                    x = y;
                }
                x
            }
        };
        values.push(value);
    }
    values[ops.len() - 1]
}

fn text(ops: &[Op]) -> String {
    let tame = |name: &str, from: &str| {
        format!(
            r#""{name}": {{ "wgsl": "fn tame(v: f32) -> f32 {{ return v / (1.0 + abs(v)); }}", "inputs": {{ "v": "{from}" }} }}"#
        )
    };
    // What a node is read as.
    let read = |n: usize| match ops[n] {
        Op::If(..) => format!("n{n}.x"),
        Op::Loop(..) | Op::Nested(..) => format!("n{n}.last.x"),
        _ => format!("n{n}"),
    };
    let two = |name: &str, pattern: &str, a: &str, b: &str| {
        format!(r#""{name}": {{ "pattern": "{pattern}", "inputs": {{ "a": "{a}", "b": "{b}" }} }}"#)
    };
    let mut nodes = vec![r#""ray": { "pattern": "ray" }"#.to_owned()];
    for (n, op) in ops.iter().enumerate() {
        let name = format!("n{n}");
        match *op {
            Op::Constant(value) => nodes.push(format!(r#""{name}": {{ "anchor": {value} }}"#)),
            Op::Uniform(value) => {
                nodes.push(format!(r#""{name}": {{ "uniform": "f32", "value": {value} }}"#));
            }
            Op::PixelX => {
                nodes.push(format!(r#""{name}": {{ "pattern": "number_of_index", "inputs": {{ "index": "ray.pixel.x" }} }}"#));
            }
            Op::Add(a, b) => nodes.push(two(&name, "add", &read(a), &read(b))),
            Op::Multiply(a, b) => nodes.push(two(&name, "multiply", &read(a), &read(b))),
            Op::Least(a, b) => nodes.push(two(&name, "least", &read(a), &read(b))),
            Op::RestOf(a) => nodes.push(format!(r#""{name}": {{ "pattern": "rest_of", "inputs": {{ "a": "{}" }} }}"#, read(a))),
            Op::Tame(a) => nodes.push(tame(&name, &read(a))),
            Op::Same(a) => nodes.push(format!(
                r#""{name}": {{ "wgsl": "fn same(v: f32) -> f32 {{ return v; }}", "inputs": {{ "v": "{}" }} }}"#,
                read(a)
            )),
            Op::Select(a, b, c) | Op::If(a, b, c) => {
                nodes.push(format!(r#""{name}_c": {{ "pattern": "above", "inputs": {{ "a": "{}" }} }}"#, read(c)));
                nodes.push(match op {
                    Op::If(..) => format!(
                        r#""{name}": {{ "if": "{name}_c", "then": {{ "x": "{}" }}, "else": {{ "x": "{}" }} }}"#,
                        read(b),
                        read(a)
                    ),
                    _ => format!(
                        r#""{name}": {{ "pattern": "select", "inputs": {{ "a": "{}", "b": "{}", "take_b": "{name}_c" }} }}"#,
                        read(a),
                        read(b)
                    ),
                });
            }
            Op::Loop(turns, a, b) => {
                nodes.push(format!(
                    r#""{name}": {{ "loop": {{ "carry": {{
                        "k": {{ "type": "f32", "start": 0, "next": "{name}_k" }},
                        "x": {{ "type": "f32", "start": "{}", "next": "{name}_x" }}
                    }}, "while": "{name}_go" }} }}"#,
                    read(a)
                ));
                nodes.push(format!(r#""{name}_go": {{ "pattern": "above", "inputs": {{ "a": {turns}, "b": "{name}.k" }} }}"#));
                nodes.push(format!(r#""{name}_k": {{ "pattern": "add", "inputs": {{ "a": "{name}.k", "b": 1 }} }}"#));
                nodes.push(two(&format!("{name}_s"), "add", &format!("{name}.x"), &read(b)));
                nodes.push(two(&format!("{name}_t"), "add", &format!("{name}_s"), &format!("{name}.k")));
                nodes.push(tame(&format!("{name}_x"), &format!("{name}_t")));
            }
            Op::Nested(turns, a, b) => {
                nodes.push(format!(
                    r#""{name}": {{ "loop": {{ "carry": {{
                        "k": {{ "type": "f32", "start": 0, "next": "{name}_k" }},
                        "x": {{ "type": "f32", "start": "{}", "next": "{name}_in.last.y" }}
                    }}, "while": "{name}_go" }} }},
                    "{name}_in": {{ "loop": {{ "carry": {{
                        "j": {{ "type": "f32", "start": 0, "next": "{name}_j" }},
                        "y": {{ "type": "f32", "start": "{name}.x", "next": "{name}_y" }}
                    }}, "while": "{name}_in_go" }} }}"#,
                    read(a)
                ));
                nodes.push(format!(r#""{name}_go": {{ "pattern": "above", "inputs": {{ "a": {turns}, "b": "{name}.k" }} }}"#));
                nodes.push(two(&format!("{name}_in_go"), "above", &format!("{name}.k"), &format!("{name}_in.j")));
                nodes.push(format!(r#""{name}_k": {{ "pattern": "add", "inputs": {{ "a": "{name}.k", "b": 1 }} }}"#));
                nodes.push(format!(r#""{name}_j": {{ "pattern": "add", "inputs": {{ "a": "{name}_in.j", "b": 1 }} }}"#));
                nodes.push(two(&format!("{name}_s"), "add", &format!("{name}_in.y"), &read(b)));
                nodes.push(tame(&format!("{name}_y"), &format!("{name}_s")));
            }
        }
    }
    showing(&nodes.join(",\n"), &read(ops.len() - 1))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_graphs_compute_what_their_nodes_say(ops in ops()) {
        let text = text(&ops);
        let graph = parsed(&text);
        let row = pixels(&graph);
        for (x, pixel) in row.iter().take(4).enumerate() {
            let expected = interpreted(&ops, x as f32);
            // The picture keeps finite numbers as they are.
            prop_assume!(expected.is_finite());
            prop_assert!(
                pixel[0] == expected,
                "{} for {expected} at {x}:\n{text}\n{}",
                pixel[0],
                march(&compile(&graph).unwrap())
            );
        }
    }
}
