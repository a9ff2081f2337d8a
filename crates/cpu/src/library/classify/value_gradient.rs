use super::sample::Sample;
use super::surface::Surface;
use crate::lanes::{F32s, length};
use crate::levels::Level;

/// The table of value and gradient magnitude; without rows that of the value alone.
#[inline(always)]
pub fn surface<S: Level>(
    sample: &Sample<S>,
    full_per_mm: f32,
    _columns: u32,
    rows: u32,
) -> Surface<S> {
    let most = sample.table.at(sample.value);
    let asked = sample.asked & F32s::zero().lt(most.opacity);
    if rows < 2 || !asked.any() {
        return most;
    }
    let share = length(sample.gradient(asked)).over(F32s::splat(full_per_mm));
    sample.table.at_2d(sample.value, share, asked)
}
