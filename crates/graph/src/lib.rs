//! Render graphs: programs for rays, made of typed nodes.
//!
//! A [`Graph`] consists of nodes, whose inputs read outputs of other nodes, and of roots, which are the
//! results. [`standard`] makes the graph that corresponds to a Plan. [`EditList`]s change a graph and are
//! applied again whenever the settings change. A [`Compiler`] compiles a graph to a program, which
//! any renderer of linked programs runs.
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
//! // Anchors are not in the program.
//! assert!(!compiled.program.wgsl().contains("let after_classify = "));
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
pub use compile::{CompiledGraph, Compiler};
pub use dot::{Detail, dot};
pub use edit::{Edit, EditList, EditedGraph, Replacement, STAGES, edited};
pub use error::{Error, Problem};
pub use functions::{Function, Patterns, Port, of_library, of_slot};
pub use group::unfolded;
pub use model::{
    CarriedVariable, Constant, Graph, GroupInput, Input, Interpolation, Kind, Loop, Node,
    Reference, Stage, Texture,
};
pub use pre_integrated::{MOST_EDGE, pre_integrated};
pub use standard::standard;
pub use text::{GraphUse, MOST_GRAPH_BYTES, ReadFile, VERSION, schema};
pub use types::{Meaning, Scalar, Type};
