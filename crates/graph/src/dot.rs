//! A graph as a drawing in the language of Graphviz, in the notation of S. Palmer (2008), section 5.2.1.5: a
//! rounded box is a node, its inputs below, its outputs above, so that values rise; triangles are ports, circles
//! the variables of loops; uniforms and textures are not divided; what is computed at the vertices stands in a box of
//! its own, and what is interpolated from there is dashed.

use crate::functions::{self, Patterns};
use crate::model::{Graph, Input, Kind, Node, Reference, Stage};
use std::fmt::Write;

/// How much a drawing says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Detail {
    /// Names of nodes and ports.
    #[default]
    Names,
    /// Types and meanings of ports, constants, and what each node does, too.
    All,
}

/// `graph` in the language of Graphviz. What is wrong with a node is drawn as far as it can be: a drawing helps to
/// find it.
pub fn dot(graph: &Graph, patterns: &Patterns, detail: Detail) -> String {
    let drawing = Drawing {
        graph,
        patterns,
        detail,
    };
    let mut out = String::new();
    let name = quoted(if graph.name.is_empty() {
        "graph"
    } else {
        &graph.name
    });
    let _ = writeln!(out, "digraph {name} {{");
    let _ = writeln!(out, "  rankdir=BT;");
    let _ = writeln!(
        out,
        "  node [shape=record, style=rounded, fontname=\"Helvetica\", fontsize=10];"
    );
    let _ = writeln!(
        out,
        "  edge [fontname=\"Helvetica\", fontsize=9, arrowsize=0.6];"
    );
    let vertex: Vec<_> = graph
        .nodes
        .iter()
        .filter(|n| n.stage != Stage::Pixel)
        .collect();
    if !vertex.is_empty() {
        let _ = writeln!(
            out,
            "  subgraph cluster_vertex {{\n    label=\"vertices\"; style=\"rounded,dashed\";"
        );
        for node in vertex {
            let _ = writeln!(out, "    {}", drawing.node(node));
        }
        let _ = writeln!(out, "  }}");
    }
    for node in graph.nodes.iter().filter(|n| n.stage == Stage::Pixel) {
        let _ = writeln!(out, "  {}", drawing.node(node));
    }
    for (name, _) in &graph.roots {
        let id = quoted(&format!("root {name}"));
        let _ = writeln!(
            out,
            "  {id} [shape=invhouse, style=bold, label={}];",
            quoted(name)
        );
    }
    for node in &graph.nodes {
        for (port, from) in reads(node) {
            drawing.edge(
                &mut out,
                &from,
                &format!("{}:{}", quoted(&node.name), quoted(&format!("in {port}"))),
                !port.ends_with(".next") || !matches!(node.kind, Kind::Loop(_)),
            );
        }
    }
    for (name, from) in &graph.roots {
        drawing.edge(&mut out, from, &quoted(&format!("root {name}")), true);
    }
    out.push_str("}\n");
    out
}

/// Every place of a node that reads another one.
fn reads(node: &Node) -> Vec<(String, Reference)> {
    let mut reads = Vec::new();
    for (name, input) in &node.inputs {
        if let Input::From(from) = input {
            reads.push((name.clone(), from.clone()));
        }
    }
    if let Kind::Loop(region) = &node.kind {
        for carried in &region.carry {
            for (key, input) in [("start", &carried.start), ("next", &carried.next)] {
                if let Some(Input::From(from)) = input {
                    reads.push((format!("{}.{key}", carried.name), from.clone()));
                }
            }
        }
        for (key, from) in [("while", &region.while_), ("until", &region.until)] {
            if let Some(from) = from {
                reads.push((key.to_owned(), from.clone()));
            }
        }
    }
    reads
}

fn quoted(text: &str) -> String {
    format!(
        "\"{}\"",
        text.replace('\\', "\\\\")
            .replace('"', "\\\"")
            .replace('\n', " ")
    )
}

/// As a record's field shows it.
fn plain(text: &str) -> String {
    let mut out = String::new();
    for letter in text.chars() {
        match letter {
            '{' | '}' | '<' | '>' | '|' | '\\' | ' ' => {
                out.push('\\');
                out.push(letter);
            }
            '"' => out.push_str("\\\""),
            '\n' => out.push_str("\\n"),
            _ => out.push(letter),
        }
    }
    out
}

struct Drawing<'d> {
    graph: &'d Graph,
    patterns: &'d Patterns,
    detail: Detail,
}

/// A port as it is drawn: name, and what details say of it.
type Port = (String, String);

impl Drawing<'_> {
    fn ports(&self, node: &Node) -> (Vec<Port>, Vec<Port>) {
        let function = match &node.kind {
            Kind::Slot(slot) => functions::of_slot(slot),
            Kind::Function(path) => functions::of_library(path),
            Kind::Pattern(name) => self.patterns.function(name),
            Kind::Wgsl(source) => functions::of_wgsl(&node.name, &node.name, source),
            Kind::Uniform { ty, .. } => functions::of_uniform(ty),
            Kind::Texture(_) => {
                return (Vec::new(), vec![("out".into(), "texture_2d<f32>".into())]);
            }
            Kind::Anchor => {
                return (
                    vec![("in".into(), String::new())],
                    vec![("out".into(), String::new())],
                );
            }
            Kind::If => {
                let inputs: Vec<Port> = node
                    .inputs
                    .iter()
                    .map(|(name, _)| (name.clone(), String::new()))
                    .collect();
                let outputs = inputs
                    .iter()
                    .filter_map(|(name, _)| name.strip_prefix("then."));
                let outputs = outputs
                    .map(|name| (name.to_owned(), String::new()))
                    .collect();
                return (inputs, outputs);
            }
            Kind::Loop(region) => {
                let (mut inputs, mut outputs) = (Vec::new(), Vec::new());
                for carried in &region.carry {
                    let ty = carried.ty.clone().unwrap_or_default();
                    inputs.push((format!("{}.start", carried.name), ty.clone()));
                    inputs.push((format!("{}.next", carried.name), ty.clone()));
                    outputs.push((carried.name.clone(), ty));
                }
                let conditions = [("while", &region.while_), ("until", &region.until)];
                inputs.extend(
                    conditions
                        .iter()
                        .filter(|(_, c)| c.is_some())
                        .map(|(k, _)| ((*k).to_owned(), "bool".to_owned())),
                );
                return (inputs, outputs);
            }
            Kind::Group(graph) => {
                let inputs = graph
                    .inputs
                    .iter()
                    .map(|i| (i.name.clone(), String::new()))
                    .collect();
                let outputs = graph
                    .roots
                    .iter()
                    .map(|(name, _)| (name.clone(), String::new()))
                    .collect();
                return (inputs, outputs);
            }
        };
        let Ok(function) = function else {
            // What is wrong with it is said when it is compiled.
            let inputs = node
                .inputs
                .iter()
                .map(|(name, _)| (name.clone(), "?".to_owned()))
                .collect();
            return (inputs, vec![("out".into(), "?".into())]);
        };
        let port = |port: &functions::Port| {
            let meaning = port.meaning.map(|m| format!(", {m}")).unwrap_or_default();
            (port.name.clone(), format!("{}{meaning}", port.ty))
        };
        (
            function.inputs.iter().map(port).collect(),
            function.outputs.iter().map(port).collect(),
        )
    }

    fn node(&self, node: &Node) -> String {
        let (inputs, outputs) = self.ports(node);
        let is_loop = matches!(node.kind, Kind::Loop(_));
        let field = |way: &str, (name, details): &Port| {
            let mark = match way {
                _ if is_loop && !["while", "until"].contains(&name.as_str()) => "○",
                "in" => "△",
                _ => "▲",
            };
            let mut label = format!("{mark} {name}");
            if self.detail == Detail::All {
                if !details.is_empty() {
                    let _ = write!(label, ": {details}");
                }
                if way == "in"
                    && let Some(Input::Constant(constant)) = node.reads(name)
                {
                    let _ = write!(label, " = {constant}");
                }
            }
            format!(
                "<{} {}> {}",
                way,
                plain(name).replace("\\ ", " "),
                plain(&label)
            )
        };
        let row = |way: &str, ports: &[Port]| {
            let fields: Vec<_> = ports.iter().map(|port| field(way, port)).collect();
            format!("{{{}}}", fields.join("|"))
        };
        let mut title = node.name.clone();
        if self.detail == Detail::All {
            let what = match &node.kind {
                Kind::Slot(slot) => format!("slot {slot}"),
                Kind::Function(path) => path.clone(),
                Kind::Pattern(name) => format!("pattern {name}"),
                Kind::Wgsl(_) => "WGSL".to_owned(),
                Kind::Anchor => "anchor".to_owned(),
                Kind::Uniform { ty, value } => format!("uniform {ty} {value:?}"),
                Kind::Texture(_) => "texture".to_owned(),
                Kind::Loop(_) => "loop".to_owned(),
                Kind::If => "if".to_owned(),
                Kind::Group(_) => "graph".to_owned(),
            };
            let _ = write!(title, "\n{what}");
            for (name, value) in &node.params {
                let _ = write!(title, "\n{name} = {value:?}");
            }
            if node.object > 0 {
                let _ = write!(title, "\nobject {}", node.object);
            }
            if node.technique > 0 {
                let _ = write!(title, "\ntechnique {}", node.technique);
            }
            if !node.comment.is_empty() {
                let _ = write!(title, "\n{}", node.comment);
            }
        }
        let id = quoted(&node.name);
        // Uniforms and textures are leaves: one box.
        if matches!(node.kind, Kind::Uniform { .. } | Kind::Texture(_)) {
            return format!(
                "{id} [shape=box, style=\"rounded,filled\", fillcolor=\"#eeeeee\", label=\"{}\"];",
                plain(&title).replace("\\ ", " ")
            );
        }
        let mut rows = Vec::new();
        if !outputs.is_empty() {
            rows.push(row("out", &outputs));
        }
        rows.push(plain(&title));
        if !inputs.is_empty() {
            rows.push(row("in", &inputs));
        }
        let style = match node.kind {
            Kind::Anchor => ", style=\"rounded,dashed\", color=\"#2060c0\"",
            Kind::Loop(_) => ", style=\"rounded,bold\"",
            _ => "",
        };
        format!("{id} [label=\"{{{}}}\"{style}];", rows.join("|"))
    }

    /// From what `from` names to a place; what a loop gets for its next turn goes against the flow.
    fn edge(&self, out: &mut String, from: &Reference, to: &str, is_with_flow: bool) {
        let Some(node) = self.graph.node(&from.node) else {
            return;
        };
        let (_, outputs) = self.ports(node);
        let is_leaf = matches!(node.kind, Kind::Uniform { .. } | Kind::Texture(_));
        let path = match from.path.split_first() {
            Some((first, rest)) if first == "last" => rest,
            _ => &from.path[..],
        };
        let named = path
            .first()
            .and_then(|first| outputs.iter().find(|(name, _)| name == first));
        let (port, members) = match (named, outputs.first()) {
            (Some((name, _)), _) => (Some(name), &path[1..]),
            (None, Some((name, _))) => (Some(name), path),
            (None, None) => (None, path),
        };
        let source = match port {
            Some(port) if !is_leaf => {
                format!("{}:{}", quoted(&node.name), quoted(&format!("out {port}")))
            }
            _ => quoted(&node.name),
        };
        let mut style: Vec<String> = Vec::new();
        if !members.is_empty() {
            style.push(format!(
                "label={}",
                quoted(&format!(".{}", members.join(".")))
            ));
        }
        if node.stage != Stage::Pixel {
            style.push("style=dashed".to_owned());
        }
        if !is_with_flow {
            style.push("constraint=false, color=\"#c04020\"".to_owned());
        }
        let style = if style.is_empty() {
            String::new()
        } else {
            format!(" [{}]", style.join(", "))
        };
        let _ = writeln!(out, "  {source} -> {to}{style};");
    }
}
