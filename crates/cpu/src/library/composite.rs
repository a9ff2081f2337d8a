//! Slot composite: how the samples of a ray become a pixel.
//!
//! Every rule is the same four functions over one [`State`]: start, add (one lattice point of every
//! ray), done (which rays need no more), finish.

pub mod average;
pub mod emission_absorption;
pub mod first_hit;
pub mod maximum;
pub mod minimum;

use crate::lanes::{F32s, Mask, Vec3s, scale};
use crate::library::classify::{Surface, Table};

/// What a rule remembers along the rays; each uses what it needs.
#[derive(Clone, Copy)]
pub struct State {
    /// Premultiplied.
    pub colour: Vec3s,
    /// Opacity so far.
    pub alpha: F32s,
    /// The value so far (largest, smallest, sum).
    pub value: F32s,
    /// What rounding has lost from a sum.
    pub lost: F32s,
    /// Number of samples added.
    pub number: F32s,
}

impl State {
    /// A ray without samples, `value` so far.
    #[inline(always)]
    pub fn start(value: f32) -> State {
        State {
            colour: [F32s::ZERO; 3],
            alpha: F32s::ZERO,
            value: F32s::splat(value),
            lost: F32s::ZERO,
            number: F32s::ZERO,
        }
    }

    /// Ends a rule that keeps a value: `value` classified once, nothing where there was no sample.
    #[inline(always)]
    fn finish_value(self, table: &Table, value: F32s) -> State {
        let Surface { colour, opacity } = table.at(value);
        let alpha: Mask = F32s::ZERO.lt(self.number);
        let alpha = alpha.select(opacity, F32s::ZERO);
        State {
            colour: scale(colour, alpha),
            alpha,
            ..self
        }
    }
}
