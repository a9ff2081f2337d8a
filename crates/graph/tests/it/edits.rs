//! Edits: what they do, and what they say when two want the same.

use crate::{assert_says, parsed, pixels, refused, showing};
use strahl_graph::{
    Edit, EditList, EditedGraph, Graph, Kind, Node, Patterns, Problem, Reference, Replacement,
    edited,
};

fn base() -> Graph {
    parsed(&showing(
        r#""u": { "uniform": "f32", "value": 0.25 }, "place": { "anchor": "u" }, "v": { "pattern": "rest_of", "inputs": { "a": "place" } }"#,
        "v",
    ))
}

fn list(name: &str, commands: Vec<Edit>) -> EditList {
    EditList {
        name: name.into(),
        commands,
    }
}

fn apply(lists: &[EditList]) -> Result<EditedGraph, Vec<Problem>> {
    edited(base(), lists, &Patterns::new())
}

fn value(edited: &EditedGraph) -> f32 {
    pixels(&edited.graph)[0][0]
}

fn twice(name: &str) -> Edit {
    let node = Node::new(name, Kind::Pattern("multiply".into()));
    Edit::Add(vec![node.input("b", 2.0)])
}

fn insert(node: &str, into: &str) -> Edit {
    Edit::Insert {
        node: node.into(),
        into: into.into(),
        input: None,
        output: None,
    }
}

#[test]
fn connect_overrides_what_was_connected() {
    let done = apply(&[list(
        "mine",
        vec![Edit::Connect(vec![("v.a".into(), 1.0.into())])],
    )])
    .unwrap();
    assert_eq!(value(&done), 0.0);
    assert!(done.conflicts.is_empty());
}

#[test]
fn nodes_are_inserted_between() {
    let done = apply(&[list("mine", vec![twice("t"), insert("t", "place")])]).unwrap();
    assert_eq!(value(&done), 0.5);
    // Two lists at one place stand one behind the other, without a conflict.
    let lists = [
        list("mine", vec![twice("t"), insert("t", "place")]),
        list("yours", vec![twice("s"), insert("s", "place")]),
    ];
    let done = apply(&lists).unwrap();
    assert_eq!(value(&done), 0.0);
    assert!(done.conflicts.is_empty(), "{:?}", done.conflicts);
}

#[test]
fn conflicts_name_both_places_and_the_later_counts() {
    let connect = |number: f64| vec![Edit::Connect(vec![("v.a".into(), number.into())])];
    let done = apply(&[list("mine", connect(1.0)), list("yours", connect(0.5))]).unwrap();
    assert_eq!(value(&done), 0.5);
    let [conflict] = &done.conflicts[..] else {
        panic!("{:?}", done.conflicts)
    };
    assert_says(
        &conflict.to_string(),
        &[
            "edits.yours.commands[0].connect.v.a",
            "`mine`",
            "edits.mine.commands[0].connect.v.a",
            "later",
        ],
    );
    // Within one list there is none: it means what it says.
    let mut both = connect(1.0);
    both.extend(connect(0.5));
    assert!(apply(&[list("mine", both)]).unwrap().conflicts.is_empty());
}

#[test]
fn nodes_of_two_lists_have_different_names() {
    let problems = apply(&[
        list("mine", vec![twice("t")]),
        list("yours", vec![twice("t")]),
    ])
    .unwrap_err();
    assert_says(
        &problems[0].to_string(),
        &[
            "edits.yours.commands[0].add.t",
            "there is a node `t` already",
            "`mine`",
            "edits.mine.commands[0].add.t",
        ],
    );
}

#[test]
fn nodes_are_replaced_and_removed() {
    let by = Replacement::One(Reference::new("t"));
    let commands = vec![
        twice("t"),
        Edit::Connect(vec![("t.a".into(), "u".into())]),
        Edit::ReplaceNode {
            node: "v".into(),
            by,
        },
        Edit::Remove(vec!["v".into()]),
    ];
    let done = apply(&[list("mine", commands)]).unwrap();
    assert_eq!(value(&done), 0.5);
    assert!(done.graph.node("v").is_none());
}

#[test]
fn what_is_not_there_is_named() {
    let commands = vec![
        Edit::Connect(vec![("w.a".into(), 1.0.into())]),
        Edit::Remove(vec!["placee".into()]),
        Edit::RemoveRoot(vec!["depth_mm".into()]),
        insert("nothing", "place"),
        Edit::ReplaceStage {
            stage: "clasify".into(),
            by: Replacement::One(Reference::new("v")),
        },
        Edit::Set(vec![("q.x".into(), vec![1.0])]),
    ];
    let problems = apply(&[list("mine", commands)]).unwrap_err();
    let text: Vec<_> = problems.iter().map(|p| p.to_string()).collect();
    assert_eq!(problems.len(), 6, "{text:?}");
    for (problem, parts) in text.iter().zip([
        ["edits.mine.commands[0].connect.w.a", "no node `w`"],
        ["edits.mine.commands[1].remove", "did you mean `place`"],
        [
            "edits.mine.commands[2].remove_root",
            "no root `depth_mm`; there are color",
        ],
        ["edits.mine.commands[3].insert.node", "no node `nothing`"],
        ["edits.mine.commands[4].replace.stage", "no stage `clasify`"],
        ["edits.mine.commands[5].set.q.x", "no node `q`"],
    ]) {
        assert_says(problem, &parts);
    }
}

#[test]
fn roots_are_added_and_taken_away() {
    let depth = vec![Edit::Root(vec![("depth_mm".into(), Reference::new("u"))])];
    let done = apply(&[list("mine", depth.clone())]).unwrap();
    assert_eq!(done.graph.roots.len(), 2);
    let gone = vec![Edit::RemoveRoot(vec!["depth_mm".into()])];
    let done = apply(&[list("mine", depth), list("yours", gone)]).unwrap();
    assert_eq!(done.graph.roots.len(), 1);
    assert_eq!(done.conflicts.len(), 1);
}

#[test]
fn everything_is_replaced_and_says_whose_work_is_lost() {
    let whole = Edit::Everything(parsed(&showing(
        r#""w": { "uniform": "f32", "value": 9 }"#,
        "w",
    )));
    let lists = [
        list("mine", vec![twice("t"), insert("t", "place")]),
        list("all", vec![whole]),
    ];
    let done = apply(&lists).unwrap();
    assert_eq!(value(&done), 9.0);
    assert_says(
        &done.conflicts[0].to_string(),
        &[
            "edits.all.commands[0].everything",
            "`mine`",
            "edits.mine.commands[",
        ],
    );
}

#[test]
fn loops_get_more_variables_and_values_are_set() {
    let graph = parsed(&showing(
        r#""n": { "uniform": "f32", "value": 2 },
        "w": { "loop": { "carry": { "i": { "type": "f32", "start": 0, "next": "next" } }, "while": "go" } },
        "go": { "pattern": "above", "inputs": { "a": "n", "b": "w.i" } },
        "next": { "pattern": "add", "inputs": { "a": "w.i", "b": 1 } }"#,
        "w.last.i",
    ));
    let carried = strahl_graph::CarriedVariable {
        name: String::new(),
        ty: Some("f32".into()),
        start: Some(1.0.into()),
        next: Some("double".into()),
    };
    let double = Node::new("double", Kind::Pattern("multiply".into()))
        .input("a", "w.p")
        .input("b", 2.0);
    let commands = vec![
        Edit::Add(vec![double]),
        Edit::Carry(vec![("w.p".into(), carried)]),
        Edit::Connect(vec![("out.x".into(), "w.last.p".into())]),
        Edit::Set(vec![("n.value".into(), vec![5.0])]),
    ];
    let done = edited(graph, &[list("mine", commands)], &Patterns::new()).unwrap();
    assert_eq!(value(&done), 32.0);
}

/// A graph as a node: twice what it gets, and a stage.
fn with_group() -> Graph {
    let group = r#""g": {
        "graph": { "strahl_graph": 1, "inputs": { "a": {} }, "nodes": {
            "double": { "pattern": "multiply", "inputs": { "a": "inputs.a", "b": 2 } },
            "after_sample": { "anchor": "double" }
        }, "roots": { "out": "after_sample" } },
        "inputs": { "a": 0.25 }
    }"#;
    parsed(&showing(group, "g"))
}

fn applied(commands: Vec<Edit>) -> Result<EditedGraph, Vec<Problem>> {
    edited(with_group(), &[list("mine", commands)], &Patterns::new())
}

#[test]
fn edits_reach_nodes_inside_a_group() {
    let whole = applied(Vec::new()).unwrap();
    assert_eq!(value(&whole), 0.5);
    assert_eq!(whole.graph, with_group());
    let connected = applied(vec![Edit::Connect(vec![("g_double.b".into(), 3.0.into())])]);
    assert_eq!(value(&connected.unwrap()), 0.75);
    let inserted = applied(vec![twice("t"), insert("t", "g_after_sample")]);
    assert_eq!(value(&inserted.unwrap()), 1.0);
    let stage = Edit::ReplaceStage {
        stage: "g_sample".into(),
        by: Replacement::One(Reference::new("g_inputs_a")),
    };
    assert_eq!(value(&applied(vec![stage]).unwrap()), 0.25);
}

#[test]
fn a_group_is_replaced_as_one_node() {
    let node = Node::new("t", Kind::Pattern("multiply".into()));
    let one = Edit::Add(vec![node.input("a", 0.5).input("b", 0.25)]);
    let by = Replacement::One(Reference::new("t"));
    let node = "g".into();
    let done = applied(vec![one, Edit::ReplaceNode { node, by }]).unwrap();
    assert_eq!(value(&done), 0.125);
}

#[test]
fn a_node_that_no_group_has_is_missing() {
    let wrong = applied(vec![Edit::Connect(vec![("g_treble.b".into(), 3.0.into())])]);
    let why = wrong.unwrap_err()[0].to_string();
    assert_says(&why, &["there is no node `g_treble`"]);
}

#[test]
fn segments_need_a_scene_that_has_them() {
    let text = showing(r#""r": { "pattern": "no_runs" }"#, "r.number");
    let node = r#""n": { "pattern": "add", "technique": 1, "inputs": { "a": 1, "b": 1 } }"#;
    for (text, says) in [
        (text, "the pattern `no_runs` is for the segments of a scene"),
        (
            showing(node, "n"),
            "the scene has no segments with techniques",
        ),
    ] {
        assert_says(&refused(&text), &[says]);
    }
}

/// The standard graph of a lit picture after edits, which are the commands of one list.
fn over_standard(commands: &str) -> Result<Graph, Vec<Problem>> {
    let text = format!(
        r#"{{ "strahl_graph": 1, "edits": [{{ "name": "mine", "commands": [{commands}] }}] }}"#
    );
    let read = strahl_graph::GraphUse::read("test", &text, &mut |_| Err("no files".to_owned()));
    let standard = strahl_graph::standard(&crate::plan("")).unwrap();
    let done = edited(standard, &read.unwrap().edits, &Patterns::new());
    done.map(|done| done.graph)
}

/// Empty space is known for the scene's transfer function and clips: after an edit that may show more, every sample is computed.
#[test]
fn skipping_follows_what_edits_may_show() {
    let skips = |commands: &str| {
        let graph = over_standard(commands).unwrap();
        let nodes = graph.nodes.iter();
        let seen: Vec<_> = nodes
            .filter(|node| matches!(&node.kind, Kind::Pattern(name) if name == "is_seen" || name == "advance"))
            .filter_map(|node| node.reads("empty"))
            .map(|empty| matches!(empty, strahl_graph::Input::From(_)))
            .collect();
        assert!(!seen.is_empty());
        seen.into_iter().all(|skips| skips)
    };
    let fog = r#"{ "add": { "fog": { "wgsl": ["fn fog(seen: Surface) -> Surface { return Surface(seen.color, max(seen.opacity, 0.01)); }"] } } }"#;
    let more =
        r#"{ "add": { "more": { "wgsl": ["fn more(x: f32) -> f32 { return x + 0.1; }"] } } }"#;
    let tint = r#"{ "add": { "tint": { "wgsl": ["fn tint(color: vec3f) -> vec3f { return color.bgr; }"] } } }"#;
    let insert = |node: &str, into: &str| {
        format!(r#"{{ "insert": {{ "node": "{node}", "into": "{into}" }} }}"#)
    };
    assert!(skips(""));
    assert!(skips(&format!(
        "{tint}, {}",
        insert("tint", "after_shade_color")
    )));
    assert!(!skips(&format!(
        "{fog}, {}",
        insert("fog", "after_classify")
    )));
    assert!(!skips(&format!(
        "{more}, {}",
        insert("more", "after_sample")
    )));
    assert!(!skips(&format!(
        "{more}, {}",
        insert("more", "after_shade_opacity")
    )));
    let all =
        r#"{ "add": { "all": { "wgsl": ["fn all(kept: bool) -> bool { return true; }"] } } }"#;
    assert!(!skips(&format!(
        "{all}, {}",
        insert("all", "after_clip_sample")
    )));
}

#[test]
fn a_classification_with_two_outputs_is_told_what_it_has_to_be() {
    let two = r#"{ "add": { "mine": { "wgsl": ["struct Look { color: vec3f, opacity: f32 }", "fn mine(value: f32) -> Look { return Look(vec3f(value), value); }"], "inputs": { "value": "after_sample" } } } }"#;
    let problems = over_standard(&format!(
        r#"{two}, {{ "replace": {{ "stage": "classify", "by": "mine" }} }}"#
    ))
    .unwrap_err();
    assert_eq!(problems.len(), 1, "{problems:?}");
    assert_says(
        &problems[0].to_string(),
        &[
            "edits.mine.commands[1].replace.by",
            "`mine` has the outputs color, opacity",
            "-> Surface",
        ],
    );
}

/// A node that only other settings have is distinguished from a typing error.
#[test]
fn nodes_of_other_settings_are_told_where_to_look() {
    let tone = r#"{ "add": { "f": { "pattern": "tone", "inputs": { "normal": "normal" } } } }, { "insert": { "node": "f", "into": "after_shade_color" } }"#;
    let graph = over_standard(tone).unwrap();
    crate::compile(&graph).unwrap();
    let unlit = crate::plan(r#", "shading": { "model": "unlit" }"#);
    let text = format!(
        r#"{{ "strahl_graph": 1, "edits": [{{ "name": "mine", "commands": [{tone}] }}] }}"#
    );
    let read = strahl_graph::GraphUse::read("test", &text, &mut |_| Err("no files".to_owned()));
    let standard = strahl_graph::standard(&unlit).unwrap();
    let graph = edited(standard, &read.unwrap().edits, &Patterns::new())
        .unwrap()
        .graph;
    let message = crate::compile_over(&unlit, &graph).unwrap_err().to_string();
    assert_says(
        &message,
        &[
            "nodes.f.inputs.normal",
            "`normal`",
            "depends on the settings",
            "`after_shade_color`",
        ],
    );
}

/// Only a GPU has them, and their values are undefined where neighbors have left the loop.
#[test]
fn derivatives_across_the_screen_are_refused() {
    for call in ["dpdx(color)", "fwidthFine(color)", "dpdyCoarse(color)"] {
        let graph = over_standard(&format!(
            r#"{{ "add": {{ "x": {{ "wgsl": ["fn x(color: vec3f) -> vec3f {{ return abs({call}); }}"] }} }} }}"#
        ))
        .unwrap();
        let message = crate::compile(&graph).unwrap_err().to_string();
        assert_says(
            &message,
            &[
                "nodes.x",
                call.split('(').next().unwrap(),
                "which needs neighboring pixels",
            ],
        );
    }
}
