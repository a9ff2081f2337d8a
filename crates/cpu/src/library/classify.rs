//! Slot classify: value → colour and opacity.

mod table;

pub use table::Table;

use crate::lanes::{F32s, Vec3s};

/// What a value looks like.
#[derive(Clone, Copy)]
pub struct Surface {
    /// Linear RGB, not premultiplied.
    pub colour: Vec3s,
    /// Per reference length.
    pub opacity: F32s,
}
