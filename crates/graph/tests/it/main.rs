//! The compiler of graphs: what it refuses and in which words, what it makes, and what that computes.

mod anchors;
mod bad_input;
mod conversions;
mod cost;
mod edits;
mod folding;
mod large;
mod loops;
mod names;
mod ordering;
mod random;
mod rates;
mod types;

use std::collections::HashMap;
use strahl_evaluate::Evaluator;
use strahl_graph::{CompiledGraph, Compiler, Error, Graph, GraphUse, Texture, standard};
use strahl_program::{Functions, Table2d, loop_of};
use strahl_scene::plan::Plan;
use strahl_scene::{Scene, resolve};
use strahl_shader::Texels;
use strahl_volume::{Control, Phantom, Volume};

/// A node that shows up to three numbers as a color.
pub const OUT: &str = r#""out": { "wgsl": [
    "/// x: default 0", "/// y: default 0", "/// z: default 0",
    "fn out(x: f32, y: f32, z: f32) -> vec4f { return vec4f(x, y, z, 1.0); }"
], "inputs": "#;

/// A graph whose first color component is `from`.
pub fn showing(nodes: &str, from: &str) -> String {
    shown(nodes, &format!(r#"{{ "x": "{from}" }}"#))
}

/// A graph that shows what `inputs` of the node `out` read.
pub fn shown(nodes: &str, inputs: &str) -> String {
    let comma = if nodes.trim().is_empty() { "" } else { ",\n" };
    format!(
        r#"{{ "strahl_graph": 1, "nodes": {{ {nodes}{comma} {OUT} {inputs} }} }}, "roots": {{ "color": "out" }} }}"#
    )
}

/// The graph of a text.
pub fn parsed(text: &str) -> Graph {
    let read = GraphUse::read("test", text, &mut |_| Err("no files".to_owned()));
    read.unwrap_or_else(|error| panic!("{error}\n{text}"))
        .graph
        .expect("a graph of its own")
}

fn volume() -> Volume {
    Phantom::Tree.volume([8, 8, 8]).unwrap()
}

/// The settings under which graphs are tried: a picture of 4 by 2 pixels.
pub fn plan(settings: &str) -> Plan {
    let scene = Scene::parse("scene", &format!(r#"{{ "size": [4, 2]{settings} }}"#)).unwrap();
    resolve(&scene, &volume().header(), None).unwrap()
}

/// Compiles a graph over the usual settings.
pub fn compile(graph: &Graph) -> Result<CompiledGraph, Error> {
    compile_over(&plan(""), graph)
}

/// Compiles a graph over settings.
pub fn compile_over(plan: &Plan, graph: &Graph) -> Result<CompiledGraph, Error> {
    let functions = Functions::of(plan, true, |_, threshold| f64::from(threshold)).unwrap();
    let what = loop_of(plan, Texels::Float);
    Compiler::default().compile("test", graph, &what, &functions)
}

/// Compiles a text that is right.
pub fn compiled(text: &str) -> CompiledGraph {
    compile(&parsed(text)).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// The message for a graph that is refused, by its text or by what it says.
pub fn refused(text: &str) -> String {
    let read = GraphUse::read("test", text, &mut |_| Err("no files".to_owned()));
    let result = read.and_then(|asked| compile(&asked.graph.expect("a graph of its own")));
    match result {
        Ok(compiled) => panic!("this was taken:\n{text}\n{}", march(&compiled)),
        Err(error) => error.to_string(),
    }
}

/// All of these parts are in the message.
#[track_caller]
pub fn assert_says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "`{part}` is missing in:\n{message}");
    }
}

/// The text of `march`, with names as they are in the graph where a `_` was put behind them.
pub fn march(compiled: &CompiledGraph) -> String {
    let wgsl = compiled.program.wgsl();
    let start = wgsl.find("fn march(").unwrap();
    let end = start + wgsl[start..].find("\n}").unwrap();
    let mut text = String::new();
    for part in wgsl[start..end].split_inclusive(|c: char| !c.is_ascii_alphanumeric() && c != '_') {
        let word = part.trim_end_matches(|c: char| !c.is_ascii_alphanumeric() && c != '_');
        text.push_str(word.trim_end_matches('_'));
        text.push_str(&part[word.len()..]);
    }
    text
}

/// The names of the values in `march`, in their order.
pub fn values_of(compiled: &CompiledGraph) -> Vec<String> {
    let march = march(compiled);
    let lines = march.lines().filter_map(|line| {
        let rest = line.trim_start().strip_prefix("let ")?;
        Some(rest.split(' ').next()?.to_owned())
    });
    lines.collect()
}

/// The four pixels of the upper row and the four of the lower.
pub fn pixels(graph: &Graph) -> Vec<[f32; 4]> {
    let (volume, plan) = (volume(), plan(""));
    let mut evaluator = Evaluator::new(&volume);
    let functions = evaluator.functions(&plan).unwrap();
    let what = evaluator.loop_of(&plan).unwrap();
    let compiled = Compiler::default()
        .compile("test", graph, &what, &functions)
        .unwrap_or_else(|error| panic!("{error}"));
    let tables: Vec<_> = (compiled.textures.iter())
        .map(|(_, texture, _)| match texture {
            Texture::Texels {
                width,
                height,
                texels,
            } => Table2d {
                width: *width,
                height: *height,
                texels: texels.clone(),
            },
            other => panic!("{other:?}"),
        })
        .collect();
    let (program, parameters) = (&compiled.program, &compiled.parameters);
    let drawn = evaluator.render_by(&plan, program, parameters, &tables, &Control::NONE);
    drawn
        .unwrap_or_else(|error| panic!("{error}\n{}", program.wgsl()))
        .image
        .pixels()
        .to_vec()
}

/// What a graph computes for the first pixel.
pub fn computed(text: &str) -> [f32; 3] {
    let [x, y, z, _] = pixels(&parsed(text))[0];
    [x, y, z]
}

/// The standard graph of some settings, and the nodes by their names.
pub fn standard_of(settings: &str) -> (Plan, Graph, HashMap<String, usize>) {
    let plan = plan(settings);
    let graph = standard(&plan).unwrap();
    let names = graph.nodes.iter().enumerate();
    let names = names.map(|(i, node)| (node.name.clone(), i)).collect();
    (plan, graph, names)
}
