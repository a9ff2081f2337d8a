use super::sample::Sample;
use super::surface::Surface;
use crate::lanes::{F32s, length};
use crate::levels::Level;

/// The table, its opacity scaled by the steepness of the value.
#[inline(always)]
pub fn surface<S: Level>(sample: &Sample<S>, low_per_mm: f32, high_per_mm: f32) -> Surface<S> {
    let mut surface = sample.table.at(sample.value);
    let asked = sample.asked & F32s::zero().lt(surface.opacity);
    if asked.any() {
        let above = length(sample.gradient(asked)) - F32s::splat(low_per_mm);
        let span = F32s::splat((high_per_mm - low_per_mm).max(1e-30));
        let part = above.over(span).max(F32s::zero()).min(F32s::splat(1.0));
        surface.opacity = surface.opacity * part;
    }
    surface
}
