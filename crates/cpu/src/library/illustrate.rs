//! Slot illustrate: what illustration changes in the color of a shaded sample.

mod places;

pub use places::IllustratedPlace;

use crate::lanes::Vec3s;
use crate::levels::Level;
use strahl_scene::plan::{Illustrate, for_each_function};

/// A file per function of the registry, each with a function `color` of the color, its place and the function's parameters.
macro_rules! functions {
    ($(; $meaning:literal $variant:ident $name:ident $word:literal { $($field:ident),* })*) => {
        $(mod $name;)*

        /// The color as it is illustrated.
        #[inline(always)]
        pub fn illustrate<S: Level>(
            function: Illustrate,
            color: Vec3s<S>,
            place: &impl IllustratedPlace<S>,
        ) -> Vec3s<S> {
            match function {
                Illustrate::Plain => color,
                $(Illustrate::$variant { $($field),* } => $name::color(color, place, $($field),*),)*
            }
        }
    };
}

for_each_function! { Illustrate => functions! {} }
