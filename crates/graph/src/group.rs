//! Graphs as nodes of graphs, unfolded into one.

use crate::error::Problem;
use crate::model::{Graph, Input, Kind, Node, Reference};
use std::collections::{HashMap, HashSet};

/// Groups in one another.
const DEEPEST: usize = 32;

/// `graph` without groups: the nodes inside `group` are called `group_node`, and their places in messages
/// follow.
pub fn unfolded(graph: &Graph) -> Result<Graph, Vec<Problem>> {
    check_size(graph)?;
    let mut graph = graph.clone();
    for _ in 0..DEEPEST {
        if !graph.nodes.iter().any(|n| matches!(n.kind, Kind::Group(_))) {
            return Ok(graph);
        }
        graph = one_level(graph)?;
    }
    match graph
        .nodes
        .iter()
        .find(|n| matches!(n.kind, Kind::Group(_)))
    {
        None => Ok(graph),
        Some(deep) => Err(vec![Problem::new(
            format!("nodes.{}", deep.name),
            format!("groups stand more than {DEEPEST} deep in one another"),
        )]),
    }
}

/// Bytes that the names of all nodes may have once they are unfolded.
const MOST_NAME_BYTES: usize = 64 << 20;

/// That groups unfold to no more nodes, with no longer names, than a graph can have; told without unfolding them.
fn check_size(graph: &Graph) -> Result<(), Vec<Problem>> {
    let (mut nodes, mut bytes) = (0, 0usize);
    // Graphs with the length of the names that they stand in.
    let mut open = vec![(graph, 0)];
    while let Some((graph, before)) = open.pop() {
        for node in &graph.nodes {
            let name = before + node.name.len();
            nodes += 1;
            bytes = bytes.saturating_add(name);
            if let Kind::Group(inner) = &node.kind {
                // An anchor for each input.
                nodes += inner.inputs.len();
                let inputs = inner.inputs.iter();
                let of_inputs: usize = inputs.map(|input| name + input.name.len()).sum();
                bytes = bytes.saturating_add(of_inputs);
                open.push((inner, name + 1));
            }
        }
        if nodes > crate::check::MOST_NODES || bytes > MOST_NAME_BYTES {
            return Err(vec![Problem::new(
                "nodes",
                format!(
                    "groups unfold to more nodes than a graph can have ({}), or to longer names ({MOST_NAME_BYTES} bytes in all)",
                    crate::check::MOST_NODES
                ),
            )]);
        }
    }
    Ok(())
}

fn one_level(mut graph: Graph) -> Result<Graph, Vec<Problem>> {
    let mut problems = Vec::new();
    let mut nodes = Vec::new();
    // Group output → node inside.
    let mut outputs: Vec<(String, String, Reference)> = Vec::new();
    for node in std::mem::take(&mut graph.nodes) {
        if let Kind::Group(_) = node.kind {
            crate::unread::of_node(&node, "a graph in a graph", &mut problems);
        }
        let Kind::Group(inner) = node.kind else {
            nodes.push(node);
            continue;
        };
        let place = format!("nodes.{}", node.name);
        let mut inner = *inner;
        for (input, _) in &node.inputs {
            if !inner.inputs.iter().any(|i| i.name == *input) {
                let names: Vec<_> = inner.inputs.iter().map(|i| i.name.as_str()).collect();
                problems.push(Problem::new(
                    format!("{place}.inputs.{input}"),
                    format!("the group has no such input; it has {}", names.join(", ")),
                ));
            }
        }
        // Each input is an anchor, so that whoever reads it finds its type.
        let inputs = inner.inputs.iter().filter_map(|input| {
            let given = node.inputs.iter().find(|(name, _)| *name == input.name);
            let from = match (given, &input.default) {
                (Some((_, from)), _) => from.clone(),
                (None, Some(default)) => Input::Constant(default.clone()),
                (None, None) => {
                    problems.push(Problem::new(
                        format!("{place}.inputs.{}", input.name),
                        "not connected, and it has no default",
                    ));
                    return None;
                }
            };
            let name = format!("{}_inputs_{}", node.name, input.name);
            Some(Node::new(name, Kind::Anchor).input("in", from))
        });
        nodes.extend(inputs.collect::<Vec<_>>());
        let known: HashSet<String> = inner.nodes.iter().map(|n| n.name.clone()).collect();
        inner.for_each_reference_mut(|key, reference| {
            if reference.node == "inputs" {
                if reference.path.is_empty() {
                    problems.push(Problem::new(
                        format!("{place}.graph.{key}"),
                        "name the input: inputs.NAME",
                    ));
                    return;
                }
                let input = reference.path.remove(0);
                reference.node = format!("{}_inputs_{input}", node.name);
            } else if known.contains(&reference.node) {
                reference.node = format!("{}_{}", node.name, reference.node);
            } else {
                problems.push(Problem::new(
                    format!("{place}.graph.{key}"),
                    format!("there is no node `{}` in the group", reference.node),
                ));
            }
        });
        for (output, reference) in &inner.roots {
            outputs.push((node.name.clone(), output.clone(), reference.clone()));
        }
        for mut within in inner.nodes {
            within.name = format!("{}_{}", node.name, within.name);
            within.object = within.object.max(node.object);
            within.technique = within.technique.max(node.technique);
            nodes.push(within);
        }
    }
    graph.nodes = nodes;
    let mut of_groups: HashMap<&str, Vec<(&str, &Reference)>> = HashMap::new();
    for (group, output, target) in &outputs {
        of_groups.entry(group).or_default().push((output, target));
    }
    // A root of a group may be an output of another: all groups of this level are resolved together.
    for _ in 0..=DEEPEST {
        let mut is_changed = false;
        graph.for_each_reference_mut(|place, reference| {
            let Some(of_group) = of_groups.get(reference.node.as_str()) else {
                return;
            };
            let named = reference
                .path
                .first()
                .and_then(|first| of_group.iter().find(|(output, _)| output == first));
            let (target, rest) = match (named, &of_group[..]) {
                (Some((_, target)), _) => (target, &reference.path[1..]),
                (None, [(_, target)]) => (target, &reference.path[..]),
                _ => {
                    let names: Vec<_> = of_group.iter().map(|(output, _)| *output).collect();
                    problems.push(Problem::new(
                        place,
                        format!(
                            "name an output of `{}`: it has {}",
                            reference.node,
                            names.join(", ")
                        ),
                    ));
                    reference.node = "unknown".into();
                    return;
                }
            };
            let mut path = target.path.clone();
            path.extend(rest.iter().cloned());
            *reference = Reference {
                node: target.node.clone(),
                path,
            };
            is_changed = true;
        });
        if !is_changed {
            break;
        }
    }
    if problems.is_empty() {
        Ok(graph)
    } else {
        Err(problems)
    }
}
