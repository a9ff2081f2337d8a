//! Whether a volume shows a patient.

use glam::DVec3;
use strahl_volume::{Modality, VolumeHeader};

/// Whether the volume looks like a patient's: it names a clinical modality, or its place in the
/// world is more than what a writer makes up (1 mm steps, centered on the origin). Many programs leave
/// the unit of lengths out; values in Hounsfield units say the same.
pub(crate) fn is_patient(header: &VolumeHeader) -> bool {
    match header.metadata.modality {
        Some(Modality::Ct | Modality::Mr | Modality::Nuclear | Modality::Ultrasound) => true,
        Some(Modality::Microscopy | Modality::Simulation) => false,
        None => {
            let grid = &header.grid;
            let center = grid.center_mm();
            let made_up = grid.spacing_mm() == DVec3::ONE
                && grid.orientation() == "RAS"
                && center.abs().max_element() <= 1.0;
            (header.metadata.has_length_unit || looks_like_hounsfield(header)) && !made_up
        }
    }
}

/// Whether the values may be Hounsfield units: they say so, or they reach from air (−1000, with the
/// fill values that scanners use below it) to bone.
pub(crate) fn looks_like_hounsfield(header: &VolumeHeader) -> bool {
    if header.metadata.value_unit.as_deref() == Some("HU") {
        return true;
    }
    let [lo, hi] = header.statistics.range;
    (-4096.0..=-800.0).contains(&lo) && (200.0..=32_767.0).contains(&hi)
}
