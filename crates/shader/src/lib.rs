//! Shader functions: every step of the ray is a function with a fixed signature, chosen at run time.
//!
//! A [`Module`] is the WGSL text of one function for one [`Slot`]. Signature, parameters and needs are
//! read from the text, and error messages mark their place in it. A [`Linker`] links a [`Selection`]
//! of modules into a [`Skeleton`], the ray loop. The result is a [`Program`]: readable WGSL for any
//! WebGPU backend. The linker works on tokens. naga checks each module on its own, and then the
//! program.
//!
#![cfg_attr(feature = "link", doc = "```")]
#![cfg_attr(not(feature = "link"), doc = "```ignore")]
//! use std::sync::Arc;
//! use strahl_shader::{Linker, Module, RayLoop, Selection, Techniques, Texels, built_in, ray_loop};
//!
//! let halved = Module::parse("halved", "halved.wgsl", "
//!     struct Params {
//!         /// Share of the opacity that stays.
//!         /// default 0.5, range 0 to 1
//!         share: f32,
//!     }
//!     fn classify(value: f32, position: vec3f) -> Surface {
//!         let surface = table(value);
//!         return Surface(surface.color, params.share * surface.opacity);
//!     }
//! ")?;
//! let selection = Selection::new()
//!     .with(built_in("fetch", "stored")?)
//!     .with(built_in("reconstruct", "trilinear")?)
//!     .with(Arc::new(halved))
//!     .with(built_in("composite", "emission_absorption")?);
//! let one = RayLoop {
//!     volumes: vec![Texels::Float],
//!     objects: 1,
//!     is_before_geometry: false,
//!     techniques: Techniques::One,
//!     is_finite: false,
//!     has_important_places: false,
//! };
//! let program = Linker::new().link(&ray_loop(&one)?, &selection)?;
//! let mut parameters = program.default_parameters();
//! program.set(&mut parameters, "classify", "share", &[0.25])?;
//! assert!(program.wgsl().contains("parameters.classify.share"));
//! # Ok::<(), strahl_shader::Error>(())
//! ```

#![warn(missing_docs)]

#[cfg(feature = "link")]
mod cost;
mod error;
#[cfg(feature = "link")]
mod library;
mod limits;
#[cfg(feature = "link")]
mod link;
#[cfg(feature = "link")]
mod module;
#[cfg(feature = "link")]
mod nesting;
#[cfg(not(feature = "link"))]
mod no_module;
#[cfg_attr(
    not(feature = "link"),
    expect(dead_code, reason = "the build script reads comments by it")
)]
mod parameter;
#[cfg(feature = "link")]
mod program;
pub mod registry;
#[cfg(feature = "link")]
mod report;
#[cfg(feature = "link")]
mod skeleton;
mod slot;
#[cfg(feature = "link")]
mod technique;
#[cfg(feature = "link")]
mod token;

pub use error::Error;
pub use limits::{BRICK_VOXELS, MOST_MASKS, MOST_OBJECTS};
#[cfg(not(feature = "link"))]
pub use no_module::Module;
pub use parameter::{Parameter, ParameterRelation, Scalar};
pub use slot::{Fold, SLOTS, SUPPLIED, Signature, Slot, slot};

#[cfg(feature = "link")]
pub use {
    cost::{Cost, Work},
    library::{built_in, library},
    link::{Linker, MOST_TURNS, Selection},
    module::{MOST_MODULE_BYTES, Module, PRELUDE, Ports},
    nesting::is_shallow,
    program::{Block, Origin, Program},
    report::Report,
    skeleton::{
        NOWHERE_MM, PAGE_VOXELS, RayLoop, Skeleton, TABLE_ROW, Techniques, Texels, bindings,
        graph_loop, ray_loop, surrounding_words,
    },
    technique::{TECHNIQUE_SLOTS, TECHNIQUE_TEXELS, TechniqueTexels},
};
