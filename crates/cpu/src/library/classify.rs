//! Slot classify: value → color and opacity.

mod integrals;
mod interval_visibility;
mod sample;
mod surface;
mod tables;
mod transfer;

pub use integrals::Integrals;
pub use interval_visibility::IntervalVisibility;
pub use sample::Sample;
pub use surface::Surface;
pub use tables::Tables;
pub use transfer::Table;

use crate::levels::Level;
use strahl_scene::plan::{Classify, for_each_function};

/// A file per function of the registry, each with a function `surface` of the sample and the function's parameters.
macro_rules! functions {
    ($(; $meaning:literal $variant:ident $name:ident $word:literal { $($field:ident),* })*) => {
        $(mod $name;)*

        /// Color and opacity of a sample where it is asked for; anything elsewhere.
        #[inline(always)]
        pub fn classify<S: Level>(method: Classify, sample: &Sample<S>) -> Surface<S> {
            match method {
                $(Classify::$variant { $($field),* } => $name::surface(sample, $($field),*),)*
            }
        }
    };
}

for_each_function! { Classify => functions! {} }
