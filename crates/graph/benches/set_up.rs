//! What it takes to make a program of a graph: checking, folding, writing, linking and validating one that was
//! not seen before, and finding one that was.
//!
//!     cargo bench -p strahl-graph

mod cases;

use cases::CASES;
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use strahl_graph::{Compiler, Graph, Kind, Node};
use strahl_program::{Functions, loop_of};
use strahl_shader::Texels;

/// The ray caster with so many more nodes between classification and compositing.
fn longer(graph: &Graph, nodes: usize) -> Graph {
    let mut graph = graph.clone();
    let mut last = "opacity_of_step".to_owned();
    let patterns = ["multiply", "least", "add", "rest_of"];
    for i in 0..nodes {
        let pattern = patterns[i % patterns.len()];
        let mut node = Node::new(format!("more_{i}"), Kind::Pattern(pattern.into()));
        node = node.input("a", last.as_str());
        if pattern != "rest_of" {
            node = node.input("b", "look.opacity");
        }
        last = node.name.clone();
        graph.nodes.push(node);
    }
    let over = graph.node_mut("over").expect("the ray caster has it");
    let opacity = over.inputs.iter_mut().find(|(name, _)| name == "opacity");
    opacity.expect("its input").1 = last.as_str().into();
    graph
}

fn set_up(criterion: &mut Criterion) {
    let mut measure = |name: &str, case: usize, change: &dyn Fn(Graph) -> Graph| {
        let case = &CASES[case];
        let volumes = case.volumes();
        let plan = case.plan(&volumes);
        let functions = Functions::of(&plan, true, |_, t| f64::from(t)).expect("functions");
        let what = loop_of(&plan, Texels::Float);
        let graph = change(case.graph(&plan));
        let name = format!("{name}, {} nodes", graph.nodes.len());
        criterion.bench_function(&format!("{name}, new"), |bench| {
            bench.iter(|| {
                let compiled = Compiler::default().compile("bench", &graph, &what, &functions);
                black_box(compiled.expect("a graph that is right"))
            });
        });
        let mut compiler = Compiler::default();
        criterion.bench_function(&format!("{name}, seen before"), |bench| {
            bench.iter(|| {
                let compiled = compiler.compile("bench", &graph, &what, &functions);
                black_box(compiled.expect("a graph that is right"))
            });
        });
    };
    for (i, case) in CASES.iter().enumerate() {
        measure(case.name, i, &|graph| graph);
    }
    measure("longer", 2, &|graph| {
        longer(&graph, 1000 - graph.nodes.len())
    });
}

criterion_group!(benches, set_up);
criterion_main!(benches);
