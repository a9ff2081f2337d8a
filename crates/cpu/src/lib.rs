//! Draws a Plan on the CPU.
//!
//! [`Renderer::render`] draws Plans of a volume; what it makes of the volume for that (min/max bricks) it
//! keeps. A picture has the same bytes whatever the number of threads, the size of tiles and the SIMD
//! width, and with skipping or without.
//!
//! Inside, `march` holds the one ray loop, compiled for each instruction set (`levels`); it goes over
//! packets of rays (`lanes`, and `doubles` where the lattice is laid) and calls the
//! functions of the slots (`library`). `skip` says which lattice points cannot matter, `tiles`
//! spreads the picture over the cores.
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

mod brick_number;
mod clipped;
mod doubles;
mod elementary;
mod error;
mod even;
mod hidden_segments;
#[cfg(feature = "bench-kernels")]
#[doc(hidden)]
pub mod kernels;
mod lanes;
mod levels;
mod library;
mod line;
mod making;
mod march;
mod march_rays;
mod meshes;
mod of_bricks;
mod options;
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
mod segment_numbers;
mod skip;
mod strides;
mod tiles;

pub use error::Error;
pub use levels::InstructionSet;
pub use options::Options;
pub use pools::{MOST_THREADS, Pool, Pools};
pub use ray_state::RayState;
pub use ray_states::RayStates;
pub use refine::Stage;
pub use renderer::Renderer;
pub use strahl_scene::{Counts, Rendered, Stats};
