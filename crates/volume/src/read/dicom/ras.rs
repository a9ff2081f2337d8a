//! From the axes of DICOM to those of the world.

use glam::DVec3;

/// LPS to RAS: left and back change their sign. (Subtracted, so that 0 stays 0 instead of −0.)
pub(super) fn ras(lps: DVec3) -> DVec3 {
    DVec3::new(0.0 - lps.x, 0.0 - lps.y, lps.z)
}
