//! Graphs from their texts to programs: by example, and by chance.

mod compiled;
mod edits;
mod texts;

use std::path::Path;
use std::sync::{Arc, LazyLock, Mutex};
use strahl_graph::{Compiler, EditList, Error, Graph, GraphUse, Patterns, edited, standard};
use strahl_program::{Functions, loop_of};
use strahl_scene::plan::Plan;
use strahl_scene::{Scene, resolve};
use strahl_shader::Texels;
use strahl_volume::Phantom;

/// Numbers that look random and are the same for the same seed (G. Steele, D. Lea and C. Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }

    fn chance(&mut self, percent: usize) -> bool {
        self.below(100) < percent
    }

    fn of<'a, T>(&mut self, list: &'a [T]) -> &'a T {
        &list[self.below(list.len())]
    }
}

fn plan(scene: &str) -> Plan {
    let volume = Phantom::Tree.volume([8, 8, 8]).unwrap();
    let scene = Scene::parse("scene", scene).unwrap_or_else(|error| panic!("{error}"));
    resolve(&scene, &volume.header(), None).unwrap_or_else(|error| panic!("{error}"))
}

/// The Plan whose functions fill the slots of all graphs here.
static PLAN: LazyLock<Plan> = LazyLock::new(|| plan("{}"));

fn compiles(graph: &Graph) -> Result<(), Error> {
    static WITH: LazyLock<(Mutex<Compiler>, Functions)> = LazyLock::new(|| {
        let functions = Functions::of(&PLAN, true, |_, threshold| f64::from(threshold)).unwrap();
        (Mutex::default(), functions)
    });
    let (compiler, functions) = &*WITH;
    let what = loop_of(&PLAN, Texels::Float);
    let mut compiler = compiler.lock().unwrap();
    let compiled = compiler.compile("test", graph, &what, functions)?;
    assert!(Arc::strong_count(&compiled.program) > 0);
    Ok(())
}

/// Reads a text that names no files.
fn read(text: &str) -> Result<GraphUse, Error> {
    GraphUse::read("test", text, &mut |_| Err("there are no files".to_owned()))
}

const SCENES: [&str; 5] = [
    "{}",
    r#"{ "preset": "mip" }"#,
    r#"{ "method": "first-hit", "threshold": 0.4 }"#,
    r#"{ "shading": { "model": "unlit" }, "jitter": { "seed": 3 }, "early_termination": 0.001 }"#,
    r#"{ "clips": [{ "box": { "min": [0, 0, 0], "max": [2, 2, 2] } }], "method": "average" }"#,
];

/// Graphs of settings, as they are read from their texts.
static STANDARD: LazyLock<Vec<Graph>> = LazyLock::new(|| {
    let texts = SCENES
        .iter()
        .map(|scene| standard(&plan(scene)).unwrap().to_text());
    texts
        .map(|text| read(&text).unwrap().graph.unwrap())
        .collect()
});

/// The texts of the examples' graphs, as far as they name no files.
static EXAMPLES: LazyLock<Vec<String>> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/graphs");
    let mut texts = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "json") {
            let text = std::fs::read_to_string(path).unwrap();
            let scene = Scene::parse("example", &text).unwrap();
            let graph = scene.graph.unwrap();
            if read(graph.as_str()).is_ok() {
                texts.push(graph.as_str().trim().to_owned());
            }
        }
    }
    texts.sort();
    assert!(texts.len() >= 8, "{}", texts.len());
    texts
});

/// `graph` after `lists`.
fn changed(graph: &Graph, lists: &[EditList]) -> Result<Graph, String> {
    let done = edited(graph.clone(), lists, &Patterns::new());
    let done = done.map_err(|problems| {
        let said: Vec<_> = problems.iter().map(ToString::to_string).collect();
        assert!(!said.is_empty(), "refused without a word");
        said.join("\n")
    })?;
    Ok(done.graph)
}
