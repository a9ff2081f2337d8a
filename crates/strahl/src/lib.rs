//! A volume renderer: reads CT, MR, microscopy and simulation data and draws it.
//!
//! One call draws a file. It detects the format by content, and chooses preset, window and camera by the
//! data:
//!
//! ```no_run
//! strahl::render_file("head.nii.gz", "head.png")?;
//! # Ok::<(), strahl::Error>(())
//! ```
//!
//! [`Render`] gives control over everything: a volume from a file, from memory or a built-in
//! [`Phantom`], a preset, a camera, a transfer function.
//!
//! ```
//! use strahl::{Background, Method, Phantom, Render, View};
//!
//! let picture = Render::phantom(Phantom::Tree)
//!     .method(Method::Mip)
//!     .view(View::Top)
//!     .background(Background::Transparent)
//!     .size(80, 60)
//!     .picture()?;
//! // The image is linear and premultiplied; `picture.save("tree.png")` writes a file.
//! let brightest = picture.image.pixels().iter().map(|p| p[1]).fold(0.0, f32::max);
//! assert!(brightest > 0.5);
//! # Ok::<(), strahl::Error>(())
//! ```
//!
//! To draw several pictures, share a [`Session`]: it keeps files and derived data.
//!
//! # Layers
//!
//! | step | where |
//! |---|---|
//! | bytes → [`Volume`] | [`load`], the readers in [`volume::read`] |
//! | text → [`Scene`] | [`Scene::parse`], [`SceneFile::open`] |
//! | scene + headers → [`Plan`](scene::plan::Plan) | [`scene::resolve`], which reports all problems at once |
//! | plan + voxels → [`Image`] | [`cpu::Renderer`] |
//! | image → file | [`write_picture`] into an [`Output`], which never leaves an incomplete file |
//!
//! World space is patient space (RAS, mm). A picture has the same bytes at any number of threads. The
//! programs in the folder `examples` lead from a slice in the terminal to an orbit of pictures.

#![warn(missing_docs)]

mod backend;
mod budget;
mod clipped;
mod confinement;
#[cfg(feature = "gpu")]
mod devices;
mod error;
mod estimate;
mod folder;
mod load;
#[cfg(feature = "gpu")]
mod locked;
mod note;
mod output;
mod picture;
mod render;
mod scene_data;
mod scene_file;
#[cfg(feature = "graph")]
mod scene_graph;
#[cfg(not(feature = "graph"))]
#[path = "no_graph.rs"]
mod scene_graph;
mod session;
mod show_stage;

pub use backend::{Backend, DrawnBy};
pub use budget::Budget;
pub use confinement::{Confinement, read_text};
pub use error::Error;
pub use estimate::Estimate;
pub use folder::Folder;
pub use load::{load, load_components_under, load_label_table, load_under};
pub use note::Note;
pub use output::{Output, abandon_outputs};
pub use picture::{CarriedFiles, Encoding, MadeFrom, Recipe, SOFTWARE, write_picture};
pub use render::{Picture, Render, ShownPicture, Told, render_file};
pub use scene_file::{SceneFile, seen_from};
#[cfg(feature = "graph")]
pub use scene_graph::{ReadyGraph, SceneGraph};
pub use session::Session;
pub use show_stage::ShowStage;

/// Vectors and matrices of the interfaces.
pub use glam;
/// The renderer on the CPU.
pub use strahl_cpu as cpu;
/// Linked programs without a GPU.
#[cfg(feature = "graph")]
pub use strahl_evaluate as evaluate;
/// The renderer on the GPU.
#[cfg(feature = "gpu")]
pub use strahl_gpu as gpu;
/// Graphs: rays programmed by wiring typed nodes.
#[cfg(feature = "graph")]
pub use strahl_graph as graph;
/// From a Plan to its linked program.
#[cfg(feature = "graph")]
pub use strahl_program as program;
/// What is to be drawn: scenes, plans, pictures.
pub use strahl_scene as scene;
/// Shader functions: every step of the ray.
pub use strahl_shader as shader;
/// The model of a ray-casting processor.
#[cfg(feature = "sim")]
pub use strahl_sim as sim;
/// Stored data and the files it comes from.
pub use strahl_volume as volume;

pub use strahl_scene::{
    Background, Camera, Clip, Color, ColorMap, Image, Method, Projection, Scene, TransferFunction,
    TransferPoint, View, presets,
};
pub use strahl_volume::{Control, Phantom, Volume, Work};

/// The examples of README.md, which have to compile.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
