//! Shader graphs: rays programmed by wiring typed nodes.
//!
//! A [`Graph`] is nodes, whose inputs read outputs of others, and roots, which are what is wanted.
//! [`standard`] makes the graph that draws what the settings of a scene say; [`EditList`]s change it, and are
//! applied again whenever the settings change; a [`Compiler`] makes a program of it, which any renderer of
//! linked programs runs.
//!
//! ```
//! use strahl_graph::{Compiler, Graph, standard};
//! use strahl_program::{Functions, loop_of};
//! use strahl_scene::{Scene, resolve};
//! use strahl_shader::Texels;
//! use strahl_volume::Phantom;
//!
//! let volume = Phantom::Tree.volume([8, 8, 8])?;
//! let plan = resolve(&Scene::default(), &volume.header(), None)?;
//! let graph = standard(&plan)?;
//! let functions = Functions::of(&plan, true, |_, threshold| f64::from(threshold))?;
//! let what = loop_of(&plan, Texels::Float);
//! let compiled = Compiler::default().compile("standard", &graph, &what, &functions)?;
//! assert!(compiled.program.wgsl().contains("let after_classify = ") == false, "anchors cost nothing");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![warn(missing_docs)]

mod check;
mod compile;
mod dot;
mod edit;
mod emit;
mod error;
mod fold;
mod functions;
mod group;
mod known;
mod literal;
mod model;
mod pre_integrated;
mod slicing;
mod standard;
mod text;
mod types;
mod unread;

pub use check::{MOST_LOOPS, MOST_NODES, MOST_TEXTURES};
pub use compile::{Compiled, Compiler};
pub use dot::{Detail, dot};
pub use edit::{By, Edit, EditList, Edited, STAGES, edited};
pub use error::{Error, Problem};
pub use functions::{Function, Patterns, Port, of_library, of_slot};
pub use group::unfolded;
pub use model::{
    Carried, Constant, Graph, GroupInput, Input, Interpolation, Kind, Loop, Node, Reference, Stage,
    Texture,
};
pub use pre_integrated::{MOST_EDGE, pre_integrated};
pub use standard::standard;
pub use text::{GraphUse, MOST_GRAPH_BYTES, ReadFile, VERSION, schema};
pub use types::{Meaning, Scalar, Type};
