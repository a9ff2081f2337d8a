//! Parts of a graph that nothing would read: each is a mistake, as leaving it out in silence would be.

use crate::error::Problem;
use crate::model::{Graph, Kind, Node, Stage};

/// What `graph`, with its groups unfolded, says in vain.
pub fn unread(graph: &Graph) -> Vec<Problem> {
    let mut problems = Vec::new();
    if let Some(input) = graph.inputs.first() {
        problems.push(Problem::new(
            format!("inputs.{}", input.name),
            "only a graph that stands as a node in another one has inputs; make it a node there (`graph`, `graph_file`), or nodes of what it reads",
        ));
    }
    for node in &graph.nodes {
        let what = match &node.kind {
            Kind::Anchor => "an anchor",
            Kind::If => "an `if`",
            Kind::Loop(_) => "a loop",
            Kind::Texture(_) => "a texture",
            Kind::Uniform { .. } => "a uniform",
            _ => continue,
        };
        of_node(node, what, &mut problems);
    }
    problems
}

/// What `node`, which is no function, says in vain.
pub fn of_node(node: &Node, what: &str, problems: &mut Vec<Problem>) {
    let place = format!("nodes.{}", node.name);
    if let Some((name, _)) = node.params.first() {
        let own = match &node.kind {
            Kind::Uniform { .. } => "; its value is `value`",
            Kind::Group(_) => "; nodes inside it have some, or inputs that are numbers",
            _ => "",
        };
        problems.push(Problem::new(
            format!("{place}.params.{name}"),
            format!("{what} has no parameters{own}"),
        ));
    }
    if node.stage != Stage::Pixel && !matches!(node.kind, Kind::Uniform { .. }) {
        problems.push(Problem::new(
            format!("{place}.stage"),
            format!("{what} is in no stage; nodes that are functions can be in the vertex stage"),
        ));
    }
}
