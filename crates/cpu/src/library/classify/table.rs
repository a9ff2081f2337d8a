use super::sample::Sample;
use super::surface::Surface;
use crate::levels::Level;

/// Color and opacity by the table.
#[inline(always)]
pub fn surface<S: Level>(sample: &Sample<S>) -> Surface<S> {
    sample.table.at(sample.value)
}
