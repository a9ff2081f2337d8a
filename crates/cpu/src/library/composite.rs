//! Slot composite: how the samples of a ray become a pixel.
//!
//! Every [`Rule`] is the same four functions over one [`State`]: start, add (one lattice point of every
//! ray), done (which rays need no more), finish; and what skipping may ask. One file per rule.

mod grey;
mod rule;
mod state;
mod vector_color;
pub mod visible_values;

pub use rule::{Crossing, Rule, Sample};
pub use state::State;

use strahl_scene::plan::for_each_function;

/// Of linear sRGB.
pub const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// A file per rule of the registry, with a type of the same name that has the parameters as fields.
macro_rules! modules {
    ($(; $meaning:literal $variant:ident $name:ident $word:literal { $($field:ident),* })*) => {
        $(pub mod $name;)*
    };
}

for_each_function! { Composite => modules! {} }
for_each_function! { DebugView => modules! {} }

/// `$body` with the rule of `$composite` as `$rule`: compiled for each rule, chosen once per packet step.
macro_rules! with_rule {
    ($composite:expr, $rule:ident => $body:expr) => {{
        use strahl_scene::plan::{Composite, DebugView, for_each_function};
        use $crate::library::composite::{self as rules, match_rule, match_view};
        for_each_function! { Composite => match_rule! { $composite, $rule, $body } }
    }};
}

/// An arm per rule.
macro_rules! match_rule {
    ($composite:expr, $rule:ident, $body:expr
        $(; $meaning:literal $variant:ident $name:ident $word:literal { $($field:ident),* })*) => {
        match $composite {
            $(Composite::$variant { $($field),* } => {
                let $rule = rules::$name::$variant { $($field),* };
                $body
            })*
            Composite::Debug(view) => {
                for_each_function! { DebugView => match_view! { view, $rule, $body } }
            }
        }
    };
}

/// An arm per debug view.
macro_rules! match_view {
    ($view:expr, $rule:ident, $body:expr
        $(; $meaning:literal $variant:ident $name:ident $word:literal { $($field:ident),* })*) => {
        match $view {
            $(DebugView::$variant { $($field),* } => {
                let $rule = rules::$name::$variant { $($field),* };
                $body
            })*
        }
    };
}

pub(crate) use {match_rule, match_view, with_rule};
