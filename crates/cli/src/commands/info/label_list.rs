//! The labels of a label volume with the size of each.

use crate::print::number;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use strahl::volume::{Error, Label, LabelVolume, Volume};

/// All ids that voxels have or names belong to, ascending.
pub struct LabelList {
    rows: Vec<Row>,
    voxel_ml: f64,
}

struct Row {
    label: Label,
    voxels: u64,
}

impl LabelList {
    /// Counts the voxels of every id.
    ///
    /// # Errors
    /// Numbers that are no ids.
    pub fn of(volume: Volume, labels: Vec<Label>) -> Result<LabelList, Error> {
        let mm3 = volume.grid().world_from_voxel().matrix3.determinant().abs();
        let labels = LabelVolume::from_volume(volume, labels)?;
        let mut rows: BTreeMap<u32, Row> = BTreeMap::new();
        let unnamed = labels
            .counts()
            .into_iter()
            .map(|(id, n)| (Label::new(id, ""), n));
        let named = labels.labels().iter().map(|label| (label.clone(), 0));
        for (label, voxels) in unnamed.chain(named) {
            let row = rows.entry(label.id).or_insert(Row {
                label: label.clone(),
                voxels,
            });
            row.label = label;
        }
        Ok(LabelList {
            rows: rows.into_values().collect(),
            voxel_ml: mm3 / 1000.0,
        })
    }

    /// `42 ids from 0 to 117`: what voxels have.
    pub fn range(&self) -> String {
        let mut ids = self.rows.iter().filter(|row| row.voxels > 0);
        let count = ids.clone().count();
        let first = ids.next().map_or(0, |row| row.label.id);
        match ids.next_back() {
            Some(last) => format!("{count} ids from {first} to {}", last.label.id),
            None => format!("1 id, {first}"),
        }
    }

    /// A line for each label.
    pub fn as_text(&self) -> String {
        let mut text = format!(
            "  {:>7} {:>13} {:>11}  {:<7}  name\n",
            "label", "voxels", "ml", "color"
        );
        for Row { label, voxels } in &self.rows {
            let group = match &label.group {
                Some(group) => format!(" ({group})"),
                None => String::new(),
            };
            let line = format!(
                "  {:>7} {:>13} {:>11}  {:<7}  {}{group}",
                label.id,
                number(*voxels as f64),
                number(*voxels as f64 * self.voxel_ml),
                color(label).unwrap_or_default(),
                label.name
            );
            let _ = writeln!(text, "{}", line.trim_end());
        }
        text
    }

    /// The same for programs.
    pub fn as_json(&self) -> Value {
        let row = |Row { label, voxels }: &Row| {
            json!({
                "id": label.id,
                "name": label.name,
                "color": color(label),
                "group": label.group,
                "voxels": voxels,
                "ml": *voxels as f64 * self.voxel_ml,
            })
        };
        self.rows.iter().map(row).collect()
    }
}

/// `#rrggbb`.
fn color(label: &Label) -> Option<String> {
    let [r, g, b] = label.color?.map(|c| (c * 255.0).round() as u8);
    Some(format!("#{r:02x}{g:02x}{b:02x}"))
}
