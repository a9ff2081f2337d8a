//! Slot composite: how the samples of a ray become a pixel.
//!
//! Every [`Rule`] is the same four functions over one [`State`]: start, add (one lattice point of every
//! ray), done (which rays need no more), finish; and what skipping may ask. One file per rule.

pub mod average;
pub mod back_to_front;
pub mod depth;
pub mod emission_absorption;
pub mod entry;
pub mod exit;
pub mod first_hit;
pub mod gmip;
pub mod gradient_magnitude;
pub mod gradient_raw;
mod grey;
pub mod mida;
pub mod minip;
pub mod mip;
pub mod normal;
mod rule;
pub mod sample_count;
pub mod sees;
mod state;
mod vector_colour;

pub use rule::{Crossing, Rule, Sample};
pub use state::State;

/// `$body` with the rule of `$composite` as `$rule`: compiled for each rule, chosen once per packet step.
macro_rules! with_rule {
    ($composite:expr, $rule:ident => $body:expr) => {{
        use strahl_scene::plan::{Composite, DebugView};
        use $crate::library::composite as rules;
        match $composite {
            Composite::EmissionAbsorption {
                stop_at_transmittance,
            } => {
                let $rule = rules::emission_absorption::EmissionAbsorption {
                    stop_at_transmittance,
                };
                $body
            }
            Composite::BackToFront => {
                let $rule = rules::back_to_front::BackToFront;
                $body
            }
            Composite::Mip => {
                let $rule = rules::mip::Mip;
                $body
            }
            Composite::Minip => {
                let $rule = rules::minip::Minip;
                $body
            }
            Composite::Average => {
                let $rule = rules::average::Average;
                $body
            }
            Composite::Gmip { white_per_mm } => {
                let $rule = rules::gmip::Gmip { white_per_mm };
                $body
            }
            Composite::Mida {
                low,
                high,
                blend,
                stop_at_transmittance,
            } => {
                let $rule = rules::mida::Mida {
                    low,
                    high,
                    blend,
                    stop_at_transmittance,
                };
                $body
            }
            Composite::FirstHit { threshold } => {
                let $rule = rules::first_hit::FirstHit { threshold };
                $body
            }
            Composite::Debug(DebugView::Entry) => {
                let $rule = rules::entry::Entry;
                $body
            }
            Composite::Debug(DebugView::Exit) => {
                let $rule = rules::exit::Exit;
                $body
            }
            Composite::Debug(DebugView::Normal) => {
                let $rule = rules::normal::Normal;
                $body
            }
            Composite::Debug(DebugView::GradientRaw) => {
                let $rule = rules::gradient_raw::GradientRaw;
                $body
            }
            Composite::Debug(DebugView::GradientMagnitude { white_per_mm }) => {
                let $rule = rules::gradient_magnitude::GradientMagnitude { white_per_mm };
                $body
            }
            Composite::Debug(DebugView::SampleCount { white }) => {
                let $rule = rules::sample_count::SampleCount { white };
                $body
            }
            Composite::Debug(DebugView::Depth { near_mm, far_mm }) => {
                let $rule = rules::depth::Depth { near_mm, far_mm };
                $body
            }
        }
    }};
}
pub(crate) use with_rule;
