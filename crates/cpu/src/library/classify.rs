//! Slot classify: value → colour and opacity.

mod grey;
mod pre_classified;
mod table;

pub use table::Table;

use crate::lanes::{F32s, Vec3s, length};
use crate::library::gradient::Gradients;
use crate::library::reconstruct::Values;
use strahl_scene::plan::Classify;

/// What a value looks like.
#[derive(Clone, Copy)]
pub struct Surface {
    /// Not premultiplied.
    pub colour: Vec3s,
    /// Per reference length.
    pub opacity: F32s,
}

/// Colour and opacity of `value` at `position` (voxel space).
#[inline(always)]
pub fn classify(
    method: Classify,
    table: &Table,
    gradients: &Gradients,
    values: &dyn Values,
    value: F32s,
    position: Vec3s,
) -> Surface {
    match method {
        Classify::Table => table.at(value),
        Classify::Identity { black, white } => grey::at(value, black, white),
        Classify::Threshold {
            threshold,
            black,
            white,
        } => grey::above(value, threshold, black, white),
        Classify::GradientTable {
            low_per_mm,
            high_per_mm,
        } => {
            let mut surface = table.at(value);
            if F32s::ZERO.lt(surface.opacity).any() {
                // The gradient of the value: that of the opacity would ask for this very function.
                let gradient = gradients.of_values(values, position);
                let above = length(gradient) - F32s::splat(low_per_mm);
                let span = F32s::splat((high_per_mm - low_per_mm).max(1e-30));
                let part = above.over(span).max(F32s::ZERO).min(F32s::splat(1.0));
                surface.opacity = surface.opacity * part;
            }
            surface
        }
        Classify::PreClassified => pre_classified::at(table, values, position),
    }
}
