//! Slot fetch: stored numbers of single voxels, or those that a function gives.

mod linear;
mod outlined_voxels;
mod shape;
mod voxels;

pub use linear::Linear;
pub use outlined_voxels::OutlinedVoxels;
pub use shape::Shape;
pub use voxels::{Corners, Fetch};

use crate::levels::Level;
use strahl_scene::plan::{self, for_each_function};

/// A file per function of the registry, with a type of the same name: the shape of the grid and the function's parameters.
/// What is stored, the first one, is [`Linear`].
macro_rules! functions {
    (
        ; $of_stored:literal Stored stored $word_of_stored:literal {}
        $(; $meaning:literal $variant:ident $name:ident $word:literal { $($field:ident),* })*
    ) => {
        $(mod $name;)*

        /// The numbers that a function gives; `None` where they are stored.
        pub fn of_function<S: Level>(
            function: plan::Fetch,
            shape: Shape,
        ) -> Option<OutlinedVoxels<'static, S>> {
            match function {
                plan::Fetch::Stored => None,
                $(plan::Fetch::$variant { $($field),* } => {
                    Some(OutlinedVoxels::new($name::$variant { shape, $($field),* }))
                })*
            }
        }
    };
}

for_each_function! { Fetch => functions! {} }
