//! Which segments a Plan draws by which techniques, as programs read it.

use crate::frame::rows;
use strahl_scene::plan::{Composite, NumberedSegments, Plan};
use strahl_shader::TABLE_ROW;

/// Where segments are found, and which technique each has.
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentTable {
    /// The rows of the map from the voxels of the field to those of the label volume; the number of the segment
    /// beyond its extent, and below which transmittance a ray ends.
    pub(crate) found_by: [[f32; 4]; 4],
    /// By the number of a segment its technique, from 1; 0 hides it. Whole rows of [`TABLE_ROW`] entries.
    pub techniques: Vec<u32>,
}

impl SegmentTable {
    /// The segments of `plan`, if it has those of a label volume; `ids` are the ids of its voxels, ascending.
    pub fn of(plan: &Plan, ids: &[u32]) -> Option<SegmentTable> {
        let labelled = plan.labelled()?;
        let NumberedSegments {
            mut techniques,
            outside,
        } = labelled.numbered(ids);
        techniques.resize(techniques.len().next_multiple_of(TABLE_ROW as usize), 0);
        let [x, y, z] = rows(&labelled.label_from_voxel(plan.field()));
        let stop = match plan.global_composite {
            Composite::EmissionAbsorption {
                stop_at_transmittance,
            } => stop_at_transmittance,
            _ => 0.0,
        };
        Some(SegmentTable {
            found_by: [x, y, z, [outside as f32, stop, 0.0, 0.0]],
            techniques,
        })
    }
}
