//! Slot classify: value → colour and opacity.

mod between;
mod grey;
mod integrals;
mod pre_classified;
mod surface;
mod table;

pub use between::Between;
pub use integrals::Integrals;
pub use surface::Surface;
pub use table::Table;

use crate::lanes::{F32s, Mask, Vec3s, length};
use crate::levels::Level;
use crate::library::gradient::Gradients;
use crate::library::reconstruct::Values;
use strahl_scene::plan::Classify;

/// Colour and opacity of `value` at `position` (voxel space) where `asked`; anything elsewhere.
#[inline(always)]
pub fn classify<S: Level>(
    method: Classify,
    table: &Table,
    gradients: &Gradients,
    values: &dyn Values<S>,
    value: F32s<S>,
    position: Vec3s<S>,
    asked: Mask<S>,
) -> Surface<S> {
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
            let asked = asked & F32s::zero().lt(surface.opacity);
            if asked.any() {
                // The gradient of the value: that of the opacity would ask for this very function.
                let gradient = gradients.of_values(values, position, asked);
                let above = length(gradient) - F32s::splat(low_per_mm);
                let span = F32s::splat((high_per_mm - low_per_mm).max(1e-30));
                let part = above.over(span).max(F32s::zero()).min(F32s::splat(1.0));
                surface.opacity = surface.opacity * part;
            }
            surface
        }
        Classify::PreClassified => pre_classified::at(table, values, position),
    }
}
