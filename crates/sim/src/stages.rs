//! The units of the data path, one file each: what a unit makes of a word, without clocks. Clocks are added by
//! [`processor`](crate::processor).

pub mod absorb;
pub mod address;
pub mod classify;
pub mod composite;
pub mod fetch;
pub mod interpolate;
pub mod material;
pub mod shade;
