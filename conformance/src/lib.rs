//! What a picture must be, independent of who draws it.
//!
//! - [`truth`]: a Plan integrated by brute force in double precision, as a picture and as the interval
//!   that each pixel of a renderer in single precision must lie in.
//! - [`closed_form`]: answers that are known as formulas.
//! - [`scenes`] and [`golden`]: scenes that every renderer draws, with pictures that a person has looked at.
//! - [`agreement`]: how alike two pictures of the same scene are; [`gallery`]: a scene per variant of every step.
//! - [`renderers`]: the list of renderers that all tests go through; [`twins`]: how far functions may be off in programs.
//!
//! A picture, and how far it is from the truth:
//!
//! ```
//! use strahl_conformance::{renderers, truth};
//! use strahl_scene::{Scene, resolve};
//! use strahl_volume::phantom::Phantom;
//!
//! let volume = Phantom::Shells.volume([16; 3])?;
//! let scene = Scene { size: Some([8, 6]), ..Scene::default() };
//! let plan = resolve(&scene, &volume.header(), None)?;
//! let field = truth::Voxels::new(&volume, plan.field().reconstruct);
//! for renderer in renderers() {
//!     let image = renderer.draw(&volume, &plan);
//!     let bounds = renderer.bounds(&plan, &field);
//!     for (pixel, bounds) in image.pixels().iter().zip(&bounds) {
//!         assert!(bounds.distance(*pixel) <= 2.0 * renderer.tolerance(&plan));
//!     }
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![warn(missing_docs)]

pub mod agreement;
pub mod closed_form;
pub mod gallery;
pub mod golden;
mod renderers;
pub mod scenes;
pub mod truth;
pub mod twins;

pub use renderers::{Renderer, device, renderers};
