//! Where rays stand among the segments of a label volume.

use crate::lanes::{F32s, Mask, Vec3s};
use crate::levels::Level;
use crate::segment_numbers::SegmentNumbers;

/// Where rays stand among segments, and what the runs that have ended add up to.
#[derive(Clone, Copy)]
pub struct Runs<S: Level> {
    /// The number of the segment, counted from 1; 0 before the first.
    pub segment: F32s<S>,
    /// Its technique, counted from 1; 0 where it is hidden or nothing of the run is left to be added.
    pub technique: F32s<S>,
    /// Premultiplied.
    pub colour: Vec3s<S>,
    /// Opacity.
    pub alpha: F32s<S>,
    /// Lattice coordinate of the first hit among the runs …
    pub place: F32s<S>,
    /// … if there was one: 1.
    pub has_place: F32s<S>,
}

impl<S: Level> Runs<S> {
    /// Those of rays that have not begun.
    #[inline(always)]
    pub fn none() -> Runs<S> {
        Runs {
            segment: F32s::zero(),
            technique: F32s::zero(),
            colour: [F32s::zero(); 3],
            alpha: F32s::zero(),
            place: F32s::zero(),
            has_place: F32s::zero(),
        }
    }

    /// Where nothing behind would be seen.
    #[inline(always)]
    pub fn is_opaque(&self, segments: &SegmentNumbers) -> Mask<S> {
        let passing = F32s::splat(1.0) - self.alpha;
        passing.lt(F32s::splat(segments.stop_at_transmittance)) | passing.le(F32s::zero())
    }
}
