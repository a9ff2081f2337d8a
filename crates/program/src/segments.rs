//! Which segments a Plan draws by which techniques, as programs read it.

use crate::frame::rows;
use strahl_scene::plan::{GlobalRule, NumberedSegments, Plan};
use strahl_shader::TABLE_ROW;

/// Where segments are found, and which technique each has.
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentTable {
    /// The rows of the map from the voxels of the field to those of the label volume; the number of the segment
    /// beyond its extent, below which transmittance a ray ends, how runs become a pixel, and the largest importance;
    /// what the importance of a place is worth to its run; of each group its rule, opacity and importance.
    pub(crate) found_by: Vec<[f32; 4]>,
    /// Seven for each segment, by its number: its technique, from 1, 0 if it is hidden; then the bits of
    /// what its runs, premultiplied, are multiplied by, and of their importance; its group, from 1. Whole rows of [`TABLE_ROW`] entries.
    pub entries: Vec<u32>,
}

impl SegmentTable {
    /// The segments of `plan`, if it has those of a label volume; `ids` are the ids of its voxels, ascending.
    pub fn of(plan: &Plan, ids: &[u32]) -> Option<SegmentTable> {
        let labeled = plan.labeled()?;
        let NumberedSegments {
            techniques,
            factors,
            importances,
            groups,
            outside,
        } = labeled.numbered(ids);
        let entry = |i: usize| {
            let [r, g, b, a] = factors[i].map(f32::to_bits);
            [
                techniques[i],
                r,
                g,
                b,
                a,
                importances[i].to_bits(),
                groups[i],
            ]
        };
        let mut entries: Vec<_> = (0..techniques.len()).flat_map(entry).collect();
        entries.resize(entries.len().next_multiple_of(TABLE_ROW as usize), 0);
        let [x, y, z] = rows(&labeled.label_from_voxel(plan.field()));
        let most = importances.iter().fold(0.0f32, |most, own| most.max(*own));
        let of_groups = labeled.groups.iter();
        let most = of_groups.fold(most, |most, group| most.max(group.importance));
        let rule = number_of(plan.global_rule);
        let by_place = plan.importance.map_or(0.0, |places| places.gain_of_runs);
        let stop = plan.global_rule.stop_at_transmittance();
        let mut found_by = vec![
            x,
            y,
            z,
            [outside as f32, stop, rule, most + by_place],
            [by_place, 0.0, 0.0, 0.0],
        ];
        found_by.extend(labeled.groups.iter().map(|group| {
            let rule = number_of(group.rule);
            [rule, group.opacity, group.importance, 0.0]
        }));
        Some(SegmentTable { found_by, entries })
    }
}

/// The number by which programs call a rule.
fn number_of(rule: GlobalRule) -> f32 {
    match rule {
        GlobalRule::EmissionAbsorption { .. } => 0.0,
        GlobalRule::Mip => 1.0,
        GlobalRule::Average => 2.0,
        GlobalRule::First => 3.0,
        GlobalRule::ImportanceAware => 4.0,
    }
}
