//! Edits by chance: what is carried out is there afterwards, and all else is refused.

use super::*;
use proptest::prelude::*;
use strahl_graph::{
    CarriedVariable, Constant, Edit, Input, Kind, Meaning, Node, Reference, Replacement, STAGES,
    Type,
};

/// A graph whose nodes read, mostly, what fits.
pub fn random_graph(random: &mut Random) -> Graph {
    let patterns = Patterns::new();
    let names = patterns.names();
    let mut graph = Graph::default();
    let mut known: Vec<(String, Type, Option<Meaning>)> = Vec::new();
    for i in 0..3 + random.below(12) {
        let pattern = random.of(&names);
        let function = patterns.function(pattern).unwrap();
        // What needs a slice, a corner or a texture is seldom right by chance.
        let is_special = ["slice", "slice_mm", "corner"].contains(&pattern.as_str());
        if (is_special || function.inputs.iter().any(|port| port.ty == Type::Texture))
            && !random.chance(3)
        {
            continue;
        }
        let mut node = Node::new(format!("n{i}"), Kind::Pattern(pattern.clone()));
        for port in &function.inputs {
            let fits = |meaning: &Option<Meaning>| match (meaning, port.meaning) {
                (Some(given), Some(wanted)) => *given == wanted,
                _ => true,
            };
            let fitting: Vec<_> = (known.iter())
                .filter(|(_, ty, meaning)| *ty == port.ty && fits(meaning))
                .collect();
            if !fitting.is_empty() && random.chance(80) {
                node = node.input(&port.name, random.of(&fitting).0.as_str());
            } else if port.default.is_none() || random.chance(20) {
                node = match &port.ty {
                    ty if *ty == Type::BOOL => node.input(&port.name, random.chance(50)),
                    _ => node.input(&port.name, (random.below(9) as f64 - 4.0) / 4.0),
                };
            }
        }
        for port in &function.outputs {
            known.push((format!("n{i}.{}", port.name), port.ty.clone(), port.meaning));
        }
        if random.chance(10) {
            node.comment = "by chance\n\"and\" more".to_owned();
        }
        graph.nodes.push(node);
    }
    let pixels: Vec<_> = known
        .iter()
        .filter(|(_, ty, _)| *ty == Type::of("vec4f"))
        .collect();
    let color = match &pixels[..] {
        [] => {
            let pixel = Node::new("pixel", Kind::Pattern("pixel".to_owned()));
            graph
                .nodes
                .push(pixel.input("color", 0.5).input("opacity", 0.5));
            "pixel".to_owned()
        }
        some => random.of(some).0.clone(),
    };
    graph
        .roots
        .push(("color".to_owned(), Reference::new(&color)));
    graph
}

/// A name of the graph, or one that is like it.
fn name(graph: &Graph, random: &mut Random) -> String {
    let names: Vec<_> = graph.nodes.iter().map(|n| n.name.clone()).collect();
    match random.below(12) {
        0 => "nobody".to_owned(),
        1 => String::new(),
        _ if names.is_empty() => "gone".to_owned(),
        _ => random.of(&names).clone(),
    }
}

fn reference(graph: &Graph, random: &mut Random) -> Reference {
    let mut reference = Reference::new(&name(graph, random));
    while random.chance(40) && reference.path.len() < 3 {
        let path = [
            "out", "color", "opacity", "last", "xyz", "k", "position", "",
        ];
        reference.path.push((*random.of(&path)).to_owned());
    }
    reference
}

fn input(graph: &Graph, random: &mut Random) -> Input {
    match random.below(6) {
        0 => Input::Constant(Constant::Numbers(vec![0.5; random.below(5)])),
        1 => Input::Constant(Constant::Bool(true)),
        _ => Input::From(reference(graph, random)),
    }
}

/// `NODE.INPUT`, a place of a loop, or an anchor.
fn place(graph: &Graph, random: &mut Random) -> String {
    let name = name(graph, random);
    let inputs = graph
        .node(&name)
        .map(|node| &node.inputs[..])
        .unwrap_or_default();
    match random.below(6) {
        0 => name,
        1 => format!("{name}.{}.next", random.of(&["k", "color", "opacity"])),
        2 => format!(
            "{name}.{}",
            random.of(&["while", "until", "value", "k.start"])
        ),
        _ if !inputs.is_empty() => format!("{name}.{}", random.of(inputs).0),
        _ => format!("{name}.in"),
    }
}

fn by(graph: &Graph, random: &mut Random) -> Replacement {
    match random.below(3) {
        0 => Replacement::Parts(
            (0..random.below(3))
                .map(|i| {
                    (
                        ["color", "opacity", "out"][i].to_owned(),
                        input(graph, random),
                    )
                })
                .collect(),
        ),
        _ => Replacement::One(reference(graph, random)),
    }
}

fn edit(graph: &Graph, random: &mut Random) -> Edit {
    match random.below(11) {
        0 => {
            let mut added = random_graph(random);
            for node in &mut added.nodes {
                if random.chance(95) {
                    node.name = format!("added{}", random.below(1000));
                }
            }
            added.nodes.truncate(1 + random.below(2));
            Edit::Add(added.nodes)
        }
        1 => Edit::Connect(vec![(place(graph, random), input(graph, random))]),
        2 => Edit::Insert {
            node: name(graph, random),
            into: place(graph, random),
            input: random.chance(50).then(|| "color".to_owned()),
            output: random.chance(20).then(|| "out".to_owned()),
        },
        3 => Edit::ReplaceNode {
            node: name(graph, random),
            by: by(graph, random),
        },
        4 => {
            let stages: Vec<_> = STAGES
                .iter()
                .map(|(stage, _)| *stage)
                .chain(["light"])
                .collect();
            Edit::ReplaceStage {
                stage: (*random.of(&stages)).to_owned(),
                by: by(graph, random),
            }
        }
        5 => {
            let to = format!("{}.v{}", name(graph, random), random.below(3));
            let carried = CarriedVariable {
                name: String::new(),
                ty: random.chance(60).then(|| "f32".to_owned()),
                start: random.chance(80).then(|| input(graph, random)),
                next: random.chance(60).then(|| input(graph, random)),
            };
            Edit::Carry(vec![(to, carried)])
        }
        6 => {
            let to = format!(
                "{}.{}",
                name(graph, random),
                random.of(&["value", "ambient", "x"])
            );
            Edit::Set(vec![(to, vec![0.25; 1 + random.below(3)])])
        }
        7 => {
            let root = random.of(&["color", "depth_mm", "other"]);
            Edit::Root(vec![((*root).to_owned(), reference(graph, random))])
        }
        8 => Edit::RemoveRoot(vec![(*random.of(&["color", "depth_mm"])).to_owned()]),
        9 => Edit::Remove(vec![name(graph, random)]),
        _ => Edit::Everything(random_graph(random)),
    }
}

/// What `to` names reads in `graph`.
fn reads(graph: &Graph, to: &str) -> Option<Input> {
    let (name, rest) = to.split_once('.').unwrap_or((to, "in"));
    let node = graph.node(name)?;
    let Kind::Loop(region) = &node.kind else {
        return node.reads(rest).cloned();
    };
    match rest {
        "while" => region.while_.clone().map(Input::From),
        "until" => region.until.clone().map(Input::From),
        _ => {
            let (variable, key) = rest.split_once('.')?;
            let carried = region.carry.iter().find(|c| c.name == variable)?;
            if key == "start" {
                carried.start.clone()
            } else {
                carried.next.clone()
            }
        }
    }
}

/// Whether skipping stopped because the edit reaches what decides what is seen: then the input `empty` of
/// `to` is the constant 0 in place of the map of empty space, or of `from` that is computed from it.
fn stopped_skipping(before: &Graph, to: &str, from: &Input, there: &Option<Input>) -> bool {
    let Input::From(from) = from else {
        return false;
    };
    let none = Input::Constant(Constant::Numbers(vec![0.0]));
    let is_map = |name: &str| {
        let node = before.node(name);
        node.is_some_and(|n| matches!(&n.kind, Kind::Pattern(p) if p == "empty_points"))
    };
    let is_inserted = |input: &Input| matches!(input, Input::From(one) if is_map(&one.node));
    to.ends_with(".empty")
        && there.as_ref() == Some(&none)
        && (is_map(&from.node) || reads(before, to).is_some_and(|old| is_inserted(&old)))
}

/// Whether `after` is `before` with `edit` carried out.
fn assert_done(before: &Graph, edit: &Edit, after: &Graph) {
    match edit {
        Edit::Add(nodes) => {
            assert_eq!(after.nodes.len(), before.nodes.len() + nodes.len());
            assert!(
                nodes
                    .iter()
                    .all(|node| after.node(&node.name) == Some(node))
            );
        }
        Edit::Connect(inputs) => {
            for (to, from) in inputs {
                let there = reads(after, to);
                assert!(
                    there.as_ref() == Some(from) || stopped_skipping(before, to, from, &there),
                    "{to}: {there:?}"
                );
            }
        }
        Edit::Insert {
            node, into, output, ..
        } => {
            let mut from = Reference::new(node);
            from.path.extend(output.clone());
            let there = reads(before, into).unwrap();
            // A node that is inserted before itself reads itself, which the compiler refuses.
            if into.split('.').next() != Some(node) {
                let now = reads(after, into);
                let from = Input::From(from);
                assert!(
                    now.as_ref() == Some(&from) || stopped_skipping(before, into, &from, &now),
                    "{into}: {now:?}"
                );
                let between = after.node(node).unwrap();
                assert!(
                    between.inputs.iter().any(|(_, i)| *i == there)
                        || matches!(between.kind, Kind::Loop(_)),
                    "{between:?} {there:?}"
                );
            }
        }
        Edit::ReplaceNode { node, by } => {
            let is_node = |from: &Input| matches!(from, Input::From(one) if one.node == *node);
            let is_itself = match by {
                Replacement::One(one) => one.node == *node,
                Replacement::Parts(parts) => parts.iter().any(|(_, from)| is_node(from)),
            };
            assert!(is_itself || after != before, "{node} {by:?}");
        }
        Edit::ReplaceStage { stage, by } => {
            let ends = match by {
                Replacement::One(one) if after.node(&format!("after_{stage}")).is_some() => {
                    vec![(format!("after_{stage}"), Input::From(one.clone()))]
                }
                Replacement::One(one) => (["color", "opacity"].iter())
                    .map(|part| {
                        let mut one = one.clone();
                        one.path.push((*part).to_owned());
                        (format!("after_{stage}_{part}"), Input::From(one))
                    })
                    .collect(),
                Replacement::Parts(parts) => (parts.iter())
                    .map(|(part, from)| (format!("after_{stage}_{part}"), from.clone()))
                    .collect(),
            };
            assert!(!ends.is_empty());
            for (to, from) in ends {
                assert_eq!(reads(after, &to), Some(from), "{to}");
            }
        }
        Edit::Carry(variables) => {
            for (to, carried) in variables {
                let (name, variable) = to.split_once('.').unwrap();
                let Kind::Loop(region) = &after.node(name).unwrap().kind else {
                    panic!("{name} is no loop")
                };
                let there = region.carry.iter().find(|c| c.name == variable).unwrap();
                assert_eq!((&there.start, &there.next), (&carried.start, &carried.next));
            }
        }
        Edit::Set(values) => {
            for (to, value) in values {
                let (name, parameter) = to.split_once('.').unwrap();
                let node = after.node(name).unwrap();
                let set = match &node.kind {
                    Kind::Uniform { value, .. } if parameter == "value" => value,
                    _ => &node.params.iter().find(|(n, _)| n == parameter).unwrap().1,
                };
                assert_eq!(set, value);
            }
        }
        Edit::Root(roots) => assert!(roots.iter().all(|root| after.roots.contains(root))),
        Edit::RemoveRoot(names) => {
            assert!(after.roots.iter().all(|(name, _)| !names.contains(name)));
        }
        Edit::Remove(names) => assert!(names.iter().all(|name| after.node(name).is_none())),
        Edit::Everything(graph) => assert_eq!(after, graph),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    /// One command after the other: each is there afterwards, or refused; and whatever comes of all of them
    /// is a graph that compiles or is refused, and is written so that it means the same.
    #[test]
    fn edits_are_carried_out_or_refused(seed: u64) {
        let mut random = Random(seed);
        let mut graph = match random.below(3) {
            0 => random_graph(&mut random),
            _ => random.of(&STANDARD).clone(),
        };
        let first = graph.clone();
        let mut done = Vec::new();
        for i in 0..1 + random.below(8) {
            let list = EditList {
                name: format!("list {i}"),
                commands: vec![edit(&graph, &mut random)],
            };
            if let Ok(after) = changed(&graph, std::slice::from_ref(&list)) {
                assert_done(&graph, &list.commands[0], &after);
                graph = after;
                done.push(list);
            }
        }
        // All at once is one after the other.
        prop_assert_eq!(changed(&first, &done), Ok(graph.clone()));
        let asked = GraphUse { graph: Some(first), edits: done, patterns: Vec::new() };
        prop_assert_eq!(&read(&asked.to_text()).unwrap(), &asked);
        if let Err(error) = compiles(&graph) {
            prop_assert!(error.to_string().contains(": "), "{}", error);
        }
    }

    /// Nodes that fit are a program.
    #[test]
    fn random_graphs_compile_or_say_why(seed: u64) {
        let graph = random_graph(&mut Random(seed));
        let again = read(&graph.to_text()).unwrap().graph;
        prop_assert_eq!(again.as_ref(), Some(&graph));
        if let Err(error) = compiles(&graph) {
            prop_assert!(error.to_string().contains(": "), "{}", error);
        }
    }
}

/// The tests above try something: many random graphs are right, and many edits are carried out.
#[test]
fn chance_is_not_always_wrong() {
    let mut random = Random(7);
    let (mut compiled, mut carried_out) = (0, 0);
    for _ in 0..200 {
        compiled += usize::from(compiles(&random_graph(&mut random)).is_ok());
        let graph = random.of(&STANDARD).clone();
        let list = EditList {
            name: "one".to_owned(),
            commands: vec![edit(&graph, &mut random)],
        };
        carried_out += usize::from(changed(&graph, &[list]).is_ok());
    }
    println!("{compiled} of 200 graphs, {carried_out} of 200 edits");
    assert!(
        compiled > 10 && carried_out > 60,
        "{compiled}, {carried_out}"
    );
}
