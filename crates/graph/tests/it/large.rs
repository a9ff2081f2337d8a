//! Graphs that are large, long or deep.

use crate::{assert_says, compile, computed, parsed, refused, showing};
use strahl_graph::{Graph, Input, Kind, Node, Reference};

/// A chain of `n` nodes after a uniform.
fn chain(n: usize, kind: impl Fn(usize) -> Node) -> Graph {
    let mut graph = parsed(&showing(r#""u": { "uniform": "f32", "value": 1 }"#, "u"));
    let mut last = "u".to_owned();
    for i in 0..n {
        let mut node = kind(i);
        node.name = format!("n{i}");
        let port = node
            .inputs
            .iter_mut()
            .find(|(_, input)| *input == Input::from("before"));
        port.unwrap().1 = last.as_str().into();
        last = node.name.clone();
        graph.nodes.push(node);
    }
    let out = graph.node_mut("out").unwrap();
    out.inputs[0].1 = last.as_str().into();
    graph
}

fn pattern(name: &str) -> Node {
    Node::new("", Kind::Pattern(name.into()))
}

#[test]
fn ten_thousand_nodes_in_a_chain() {
    let graph = chain(10_000, |_| {
        pattern("add").input("a", "before").input("b", 1.0)
    });
    assert_eq!(crate::pixels(&graph)[0][0], 10_001.0);
}

#[test]
fn ten_thousand_nodes_that_are_known() {
    let mut graph = chain(10_000, |_| {
        pattern("add").input("a", "before").input("b", 1.0)
    });
    graph.node_mut("n0").unwrap().inputs[0].1 = 0.0.into();
    let compiled = compile(&graph).unwrap();
    assert!(
        crate::march(&compiled).contains("vec4f(10000.0, 0.0, 0.0, 1.0)"),
        "{}",
        crate::march(&compiled)
    );
}

#[test]
fn ten_thousand_anchors_and_ifs() {
    let anchors = chain(10_000, |_| {
        Node::new("", Kind::Anchor).input("in", "before")
    });
    assert_eq!(crate::pixels(&anchors)[0][0], 1.0);
    // From the other end, where the way to the type is long.
    let mut backwards = anchors.clone();
    backwards.nodes.reverse();
    assert_eq!(crate::pixels(&backwards)[0][0], 1.0);
}

#[test]
fn a_circle_of_ten_thousand_is_cut_short() {
    let mut graph = chain(10_000, |_| pattern("rest_of").input("a", "before"));
    graph.node_mut("n0").unwrap().inputs[0].1 = "n9999".into();
    let message = compile(&graph).unwrap_err().to_string();
    assert_says(&message, &["in a circle", "→ … →"]);
    assert!(message.len() < 2000, "{message}");
}

#[test]
fn more_nodes_than_allowed() {
    let mut graph = chain(1, |_| pattern("rest_of").input("a", "before"));
    let node = graph.nodes[0].clone();
    for i in 0..strahl_graph::MOST_NODES {
        graph.nodes.push(Node {
            name: format!("m{i}"),
            ..node.clone()
        });
    }
    assert_says(
        &compile(&graph).unwrap_err().to_string(),
        &["nodes", "at most 20000"],
    );
}

/// Ifs in one another: the value of each is read by the next in its branch only.
fn nested(depth: usize) -> Graph {
    let mut nodes = r#""u": { "uniform": "f32", "value": 0.5 }, "c": { "pattern": "above", "inputs": { "a": "u" } }, "i0": { "pattern": "rest_of", "inputs": { "a": "u" } }"#.to_owned();
    for i in 0..depth {
        nodes += &format!(
            r#", "c{0}": {{ "wgsl": "fn c(a: f32) -> bool {{ return sin(a) > -2.0 - {0}.0; }}", "inputs": {{ "a": "u" }} }},
            "i{0}": {{ "if": "c{0}", "then": {{ "x": "{1}" }}, "else": {{ "x": "u" }} }}"#,
            i + 1,
            if i == 0 {
                "i0".to_owned()
            } else {
                format!("i{i}.x")
            }
        );
    }
    parsed(&showing(&nodes, &format!("i{depth}.x")))
}

#[test]
fn ifs_stand_in_one_another_up_to_a_depth() {
    assert_eq!(crate::pixels(&nested(40))[0][0], 0.5);
    let message = compile(&nested(60)).unwrap_err().to_string();
    assert_says(
        &message,
        &["nodes.i", "60 deep in one another", "at most 48"],
    );
    // And no stack overflows where there is no end of it.
    let message = compile(&nested(5000)).unwrap_err().to_string();
    assert_says(&message, &["at most 48"]);
}

#[test]
fn groups_stand_in_one_another_up_to_a_depth() {
    let group = |depth: usize| {
        let mut graph = Graph {
            slicing: None,
            name: "inner".into(),
            nodes: vec![pattern("rest_of").input("a", 0.25)],
            roots: vec![("out".into(), Reference::new("n"))],
            inputs: Vec::new(),
        };
        graph.nodes[0].name = "n".into();
        for _ in 0..depth {
            graph = Graph {
                slicing: None,
                name: "outer".into(),
                nodes: vec![Node::new("n", Kind::Group(Box::new(graph)))],
                roots: vec![("out".into(), Reference::new("n"))],
                inputs: Vec::new(),
            };
        }
        let mut whole = parsed(&showing(r#""u": { "uniform": "f32", "value": 1 }"#, "u"));
        let n = Node::new("n", Kind::Group(Box::new(graph)));
        whole.nodes.push(n);
        whole.node_mut("out").unwrap().inputs[0].1 = "n".into();
        whole
    };
    assert_eq!(crate::pixels(&group(20))[0][0], 0.75);
    let message = compile(&group(40)).unwrap_err().to_string();
    assert_says(&message, &["nodes.n", "more than 32 deep"]);
}

#[test]
fn too_many_loops_and_textures_are_counted() {
    let mut nodes = r#""u": { "uniform": "f32", "value": 1 }"#.to_owned();
    for i in 0..9 {
        nodes += &format!(
            r#", "t{i}": {{ "texture": {{ "size": [1, 1], "texels": [[0, 0, 0, 0]] }} }}"#
        );
    }
    assert_says(
        &refused(&showing(&nodes, "u")),
        &["9 textures", "at most 8"],
    );
    let mut nodes = r#""u": { "uniform": "f32", "value": 1 }"#.to_owned();
    for i in 0..65 {
        nodes += &format!(
            r#", "l{i}": {{ "loop": {{ "carry": {{ "x": {{ "type": "f32", "start": 0, "next": "u" }} }}, "while": "u" }} }}"#
        );
    }
    assert_says(&refused(&showing(&nodes, "u")), &["65 loops", "at most 64"]);
}

#[test]
fn a_text_that_nests_deeply_is_refused() {
    let text = format!(
        r#"{{ "strahl_graph": 1, "nodes": {} 1 {} }}"#,
        "[".repeat(5000),
        "]".repeat(5000)
    );
    assert_says(&refused(&text), &["test:1"]);
}

#[test]
fn a_chain_in_a_loop_is_as_long_as_one_likes() {
    let mut nodes = r#""n": { "uniform": "f32", "value": 3 },
        "w": { "loop": { "carry": { "i": { "type": "f32", "start": 0, "next": "next" }, "s": { "type": "f32", "start": 0, "next": "a999" } }, "while": "go" } },
        "go": { "pattern": "above", "inputs": { "a": "n", "b": "w.i" } },
        "next": { "pattern": "add", "inputs": { "a": "w.i", "b": 1 } }"#.to_owned();
    for i in 0..1000 {
        let from = if i == 0 {
            "w.s".to_owned()
        } else {
            format!("a{}", i - 1)
        };
        nodes += &format!(
            r#", "a{i}": {{ "pattern": "add", "inputs": {{ "a": "{from}", "b": "n" }} }}"#
        );
    }
    assert_eq!(computed(&showing(&nodes, "w.last.s"))[0], 9000.0);
}
