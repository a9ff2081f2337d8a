//! Draws Plans on the CPU.
//!
//! [`Renderer::render`] draws a Plan of the renderer's volumes. The renderer keeps derived data, such as
//! min/max bricks, for the next picture. A picture has the same bytes at any number of threads, tile
//! size and SIMD width, with skipping or without.
//!
//! Inside, `tiles` divides the picture among the cores. `march` has the ray loops, compiled for each
//! instruction set (`levels`). They process packets of rays (`lanes`; `doubles` for the lattice) and
//! call the functions of the slots (`library`). `skip` finds lattice points that are invisible.
//!
//! ```
//! use strahl_cpu::{Options, Renderer};
//! use strahl_scene::{Scene, resolve};
//! use strahl_volume::{Control, Phantom};
//!
//! let volume = Phantom::Tree.volume([32, 32, 32])?;
//! let scene = Scene::parse("scene", r#"{ "size": [64, 48] }"#)?;
//! let plan = resolve(&scene, &volume.header(), None)?;
//! let drawn = Renderer::new(&volume).render(&plan, &Options::default(), &Control::NONE)?;
//! assert_eq!((drawn.image.width(), drawn.image.height()), (64, 48));
//! let counts = drawn.stats.counts.expect("this renderer counts");
//! assert!(counts.samples < counts.lattice_points);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![warn(missing_docs)]

mod brick_bytes;
mod brick_number;
mod clipped;
mod doubles;
mod elementary;
mod error;
mod even;
mod important_places;
#[cfg(feature = "bench-kernels")]
#[doc(hidden)]
pub mod kernels;
mod label_bricks;
mod lanes;
mod levels;
mod library;
mod line;
mod making;
mod march;
mod march_rays;
mod mesh_tree;
mod meshes;
mod options;
mod outline;
mod pools;
mod prepared;
mod raster;
mod ray_packet;
mod ray_state;
mod ray_states;
mod rays;
mod refine;
mod rejection;
mod renderer;
mod scenery;
mod segment_looks;
mod segment_numbers;
mod segments_of_bricks;
mod skip;
mod strides;
mod technique_bricks;
mod tiles;
mod unseen_segments;

pub use error::Error;
pub use levels::InstructionSet;
pub use options::Options;
pub use pools::{MOST_THREADS, Pool, Pools};
pub use ray_state::RayState;
pub use ray_states::RayStates;
pub use refine::Stage;
pub use renderer::Renderer;
pub use strahl_scene::{Counts, Rendered, Stats};
