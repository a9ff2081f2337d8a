//! Slot fetch: stored numbers of single voxels, or those that a function gives.

mod apart;
mod linear;
mod marschner_lobb;
mod noise;
mod shape;
mod voxels;

pub use apart::Apart;
pub use linear::Linear;
pub use marschner_lobb::MarschnerLobb;
pub use noise::Noise;
pub use shape::Shape;
pub use voxels::{Corners, Fetch};
