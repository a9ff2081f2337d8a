//! The four cases of the document's Table 4, as ray casters: each a scene, a graph, and the `march` that a
//! person would write instead, over the same library.
//!
//! 1: one table of colors, one light. 2: a table per tag of a second volume, three lights, tone shading,
//! boundaries and silhouettes. 3: a ray caster of nodes alone, unlit. 4: pre-integrated, unlit.

#![allow(
    dead_code,
    reason = "who counts, who times the set-up and who draws need different parts"
)]

use std::sync::Arc;
use strahl_graph::{
    CompiledGraph, Compiler, Graph, GraphUse, Patterns, Texture, edited, pre_integrated, standard,
};
use strahl_program::{Functions, Table2d};
use strahl_scene::plan::Plan;
use strahl_scene::{Headers, Scene, resolve_with};
use strahl_shader::{Linker, Module, Program, RayLoop, graph_loop};
use strahl_volume::{Phantom, Volume};

/// A case.
pub struct Case {
    /// What it is called in tables.
    pub name: &'static str,
    scene: &'static str,
    graph: &'static str,
    hand_written: &'static str,
    /// A function of the person's program that gives what can be set.
    settings: Option<&'static str>,
}

/// All of them.
pub static CASES: [Case; 4] = [
    Case {
        name: "1: table, one light",
        scene: r##"{ "size": [256, 256], "preset": "solid", "background": "#000000", "lights": [{ "type": "head" }],
            "shading": { "ambient": 0.25, "diffuse": 0.75, "specular": 0.2, "shininess": 24 } }"##,
        graph: r#"{ "strahl_graph": 1 }"#,
        hand_written: include_str!("hand_written/table_one_light.wgsl"),
        settings: None,
    },
    Case {
        name: "2: tags, three lights, tone, boundary, silhouette",
        scene: r##"{ "size": [256, 256], "preset": "ct-soft-tissue", "background": "#000000",
            "objects": [{ "volume": { "phantom": "shells" }, "transform": { "scale": [2.2, 2.2, 2.6] },
                "transfer_function": { "points": [[0, 0, "#000000"], [1, 0, "#000000"]] } }],
            "camera": { "azimuth_deg": 40, "elevation_deg": 12 } }"##,
        graph: include_str!("hand_written/tags_three_lights.graph.json"),
        hand_written: include_str!("hand_written/tags_three_lights.wgsl"),
        settings: Some(include_str!("hand_written/tags_three_lights_settings.wgsl")),
    },
    Case {
        name: "3: ray caster of nodes, unlit",
        scene: r##"{ "size": [256, 256], "preset": "solid", "background": "#000000", "shading": { "model": "unlit" } }"##,
        graph: include_str!("hand_written/ray_caster.graph.json"),
        hand_written: include_str!("hand_written/ray_caster.wgsl"),
        settings: None,
    },
    Case {
        name: "4: pre-integrated, unlit",
        scene: r##"{ "size": [256, 256], "preset": "solid", "background": "#000000", "shading": { "model": "unlit" }, "step_mm": 1 }"##,
        graph: include_str!("hand_written/pre_integrated.graph.json"),
        hand_written: include_str!("hand_written/pre_integrated.wgsl"),
        settings: None,
    },
];

impl Case {
    /// What it draws: 64³, or the size of the document's case 2.
    pub fn volumes(&self) -> Vec<Volume> {
        let of = |phantom: Phantom, dims| phantom.volume(dims).expect("a phantom");
        if self.name.starts_with('2') {
            return vec![
                of(Phantom::Anatomy, [132, 94, 166]),
                of(Phantom::Shells, [64; 3]),
            ];
        }
        vec![of(Phantom::Tree, [64; 3])]
    }

    /// The settings.
    pub fn plan(&self, volumes: &[Volume]) -> Plan {
        let scene = Scene::parse("case", self.scene).unwrap_or_else(|error| panic!("{error}"));
        let mut headers = Headers::from(volumes[0].header());
        headers.volumes = volumes.iter().map(Volume::header).collect();
        resolve_with(&scene, &headers).unwrap_or_else(|error| panic!("{error}"))
    }

    /// The graph.
    pub fn graph(&self, plan: &Plan) -> Graph {
        let asked = GraphUse::read(self.name, self.graph, &mut |_| Err("no files".to_owned()));
        let asked = asked.unwrap_or_else(|error| panic!("{error}"));
        match asked.graph {
            Some(graph) => graph,
            None => {
                let standard = standard(plan).unwrap_or_else(|error| panic!("{error}"));
                edited(standard, &asked.edits, &Patterns::new())
                    .unwrap_or_else(|problems| panic!("{problems:?}"))
                    .graph
            }
        }
    }

    /// The program that the compiler makes.
    pub fn generated(&self, plan: &Plan, what: &RayLoop, functions: &Functions) -> CompiledGraph {
        Compiler::default()
            .compile(self.name, &self.graph(plan), what, functions)
            .unwrap_or_else(|error| panic!("{error}"))
    }

    /// The program of the person, and its parameters.
    pub fn by_hand(&self, what: &RayLoop, functions: &Functions) -> (Arc<Program>, Vec<u8>) {
        let module = |text| Module::trusted_node("settings", "settings.wgsl", text);
        let settings = self.settings.map(|text| {
            let module = module(text).unwrap_or_else(|error| panic!("{error}"));
            ("settings".to_owned(), Arc::new(module))
        });
        let settings = settings.into_iter().collect();
        let skeleton = graph_loop(what, self.hand_written, None, settings)
            .unwrap_or_else(|error| panic!("{error}"));
        let program = Linker::new()
            .link(&skeleton, &functions.selection)
            .unwrap_or_else(|error| panic!("{error}"));
        let parameters = functions
            .parameters(&program)
            .unwrap_or_else(|error| panic!("{error}"));
        (program, parameters)
    }
}

/// The textures of a compiled case.
pub fn tables(compiled: &CompiledGraph, plan: &Plan) -> Vec<Table2d> {
    let table = |(_, texture, object): &(String, Texture, usize)| match texture {
        Texture::Texels {
            width,
            height,
            texels,
        } => Table2d {
            width: *width,
            height: *height,
            texels: texels.clone(),
        },
        Texture::PreIntegrated { edge } => pre_integrated(
            &plan.technique_of(*object).table,
            plan.lattice.step_mm,
            *edge,
        ),
        Texture::File(path) => panic!("{path} is not read"),
    };
    compiled.textures.iter().map(table).collect()
}
