//! Slot composite: how the samples of a ray become a pixel.
//!
//! Every rule is the same four functions over one [`State`]: start, add (one lattice point of every
//! ray), done (which rays need no more), finish.

pub mod average;
pub mod debug;
pub mod emission_absorption;
pub mod first_hit;
pub mod maximum;
pub mod mida;
pub mod minimum;
pub mod state;
