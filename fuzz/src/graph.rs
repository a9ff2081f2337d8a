//! What must hold for whatever was read as a graph.

use std::sync::{LazyLock, Mutex};
use strahl_graph::{Compiler, Detail, EditList, Error, Graph, GraphUse, Patterns, dot, edited};
use strahl_program::{Functions, loop_of};
use strahl_scene::plan::Plan;
use strahl_scene::{Scene, resolve};
use strahl_shader::Texels;
use strahl_volume::Phantom;

/// Programs that are kept before the compiler begins anew.
const KEPT: usize = 64;

static PLAN: LazyLock<Plan> = LazyLock::new(|| {
    let volume = Phantom::Tree.volume([8, 8, 8]).unwrap();
    resolve(&Scene::default(), &volume.header(), None).unwrap()
});

static FUNCTIONS: LazyLock<Functions> =
    LazyLock::new(|| Functions::of(&PLAN, true, |_, threshold| f64::from(threshold)).unwrap());

/// The graph that the settings of a scene make.
pub fn standard() -> Graph {
    strahl_graph::standard(&PLAN).unwrap()
}

fn parsed(text: &str) -> Result<GraphUse, Error> {
    GraphUse::read("fuzz.graph.json", text, &mut |_| {
        Err("there are no files".to_owned())
    })
}

/// What a text asks for, if it is right; it is written so that it means the same, and the same again.
pub fn read(text: &str) -> Option<GraphUse> {
    let asked = match parsed(text) {
        Ok(asked) => asked,
        Err(error) => {
            assert!(error.to_string().len() > "fuzz.graph.json: ".len());
            return None;
        }
    };
    let written = asked.to_text();
    let again = parsed(&written).unwrap();
    assert_eq!(again, asked);
    assert_eq!(again.to_text(), written);
    Some(asked)
}

/// `graph` after `lists`, if all of them can be carried out.
pub fn changed(graph: &Graph, lists: &[EditList]) -> Option<Graph> {
    match edited(graph.clone(), lists, &Patterns::new()) {
        Ok(done) => Some(done.graph),
        Err(problems) => {
            assert!(!problems.is_empty());
            assert!(problems.iter().all(|problem| !problem.why.is_empty()));
            None
        }
    }
}

/// Compiles a graph and draws it as nodes; whatever is wrong with it is said.
pub fn compile(graph: &Graph) {
    static COMPILER: LazyLock<Mutex<(Compiler, usize)>> = LazyLock::new(Mutex::default);
    let Ok(mut compiler) = COMPILER.lock() else {
        return;
    };
    if compiler.1 == KEPT {
        *compiler = Default::default();
    }
    compiler.1 += 1;
    let what = loop_of(&PLAN, Texels::Float);
    match compiler.0.compile("fuzz", graph, &what, &FUNCTIONS) {
        Ok(compiled) => assert!(compiled.program.wgsl().contains("fn march")),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    assert!(dot(graph, &Patterns::new(), Detail::All).starts_with("digraph"));
}
