//! Segments of 3D Slicer's `.seg.nrrd`. Keys, N from 0:
//!
//! | key                    | meaning                                                            |
//! |------------------------|--------------------------------------------------------------------|
//! | `SegmentN_Name`        | name; without it `SegmentN_ID` is the name                         |
//! | `SegmentN_Layer`       | entry of the list axis that holds the segment, from 0              |
//! | `SegmentN_LabelValue`  | its number in this layer                                           |
//! | `SegmentN_Color`       | three numbers from 0 to 1                                          |
//! | `SegmentN_Tags`        | `key:value\|…`, of which `TerminologyEntry` is used                |
//!
//! A terminology entry is `list~category~type~…`; a category is `scheme^value^meaning`.
//!
//! Files without layers and label values have one segment per entry of the list axis, each of ones.
//! Segments overlap only if they are in different layers, so layers may use the same numbers.

use crate::read::header_lines::numbers;
use crate::{Error, Label, Sample, Samples, memory, with_samples};
use std::collections::{BTreeMap, BTreeSet};

/// A segment: which number in which layer, and what it means.
pub(super) struct Segment {
    layer: usize,
    label: Label,
}

/// All segments that the keys describe, in their order. The array has `layers` layers.
///
/// # Errors
/// A number that is none.
pub(super) fn all(keys: &[(String, String)], layers: usize) -> Result<Vec<Segment>, Error> {
    let mut parts: BTreeMap<u32, BTreeMap<&str, &str>> = BTreeMap::new();
    for (key, value) in keys {
        let Some((number, what)) = key.strip_prefix("Segment").and_then(|k| k.split_once('_'))
        else {
            continue;
        };
        let is_known = ["Name", "ID", "LabelValue", "Color", "Layer", "Tags"].contains(&what);
        if let (Ok(number), true) = (number.parse(), is_known) {
            parts.entry(number).or_default().insert(what, value);
        }
    }
    let segment = |(number, parts): (u32, BTreeMap<&str, &str>)| {
        let field = |what: &str| format!("Segment{number}_{what}");
        let layer = match parts.get("Layer") {
            Some(text) => numbers::<usize>(&field("Layer"), text, 1)?[0],
            None if !parts.contains_key("LabelValue") && layers > 1 => number as usize,
            None => 0,
        };
        let value = parts.get("LabelValue").copied().unwrap_or("1");
        let id = numbers::<u32>(&field("LabelValue"), value, 1)?[0];
        let color = match parts.get("Color") {
            Some(text) => Some(numbers::<f32>(&field("Color"), text, 3)?),
            None => None,
        };
        let name = parts.get("Name").or(parts.get("ID"));
        let label = Label {
            color: color.map(|c| [c[0], c[1], c[2]].map(|c| c.clamp(0.0, 1.0))),
            group: parts.get("Tags").and_then(|tags| category(tags)),
            ..Label::new(id, name.copied().unwrap_or_default())
        };
        Ok(Segment { layer, label })
    };
    parts.into_iter().map(segment).collect()
}

/// The meaning of the category: `Tissue` in `…|TerminologyEntry:list~SCT^85756007^Tissue~…`.
fn category(tags: &str) -> Option<String> {
    let mut tags = tags.split('|');
    let entry = tags.find_map(|tag| tag.trim().strip_prefix("TerminologyEntry:"))?;
    let meaning = entry.split('~').nth(1)?.split('^').nth(2)?.trim();
    (!meaning.is_empty()).then(|| meaning.to_owned())
}

/// The labels of one layer, whose numbers stay as they are.
pub(super) fn of_layer(
    segments: &[Segment],
    layer: usize,
    notes: &mut Vec<String>,
) -> Option<Vec<Label>> {
    let mut labels: Vec<Label> = Vec::new();
    let mut ids = BTreeSet::new();
    let in_layer = |segment: &&Segment| segment.layer == layer;
    for Segment { label, .. } in segments.iter().filter(in_layer) {
        if ids.insert(label.id) {
            labels.push(label.clone());
        } else {
            notes.push(note_of_twice(label));
        }
    }
    let others = segments.iter().filter(|segment| !in_layer(segment)).count();
    if others > 0 {
        notes.push(format!(
            "{others} segments are in other layers and were not read"
        ));
    }
    (!segments.is_empty()).then_some(labels)
}

fn note_of_twice(label: &Label) -> String {
    let Label { id, name, .. } = label;
    format!("the label value {id} of `{name}` has a name already; the first name is used")
}

/// Layers of a segmentation.
pub(super) struct Layers<'a> {
    /// All samples, as they are stored.
    pub samples: &'a Samples,
    /// Number of layers.
    pub count: usize,
    /// Distance of the samples of two layers.
    pub before: usize,
}

/// What a number in a layer becomes.
#[derive(Clone, Copy)]
struct Meant {
    id: u32,
    /// Of two segments in a voxel, the one with the larger rank is kept.
    rank: usize,
}

impl Layers<'_> {
    /// One id per voxel, and what the ids mean.
    ///
    /// # Errors
    /// A number that is no id.
    pub(super) fn combined(
        &self,
        segments: &[Segment],
        notes: &mut Vec<String>,
    ) -> Result<(Samples, Vec<Label>), Error> {
        with_samples!(self.samples, samples => {
            let used = self.used(samples)?;
            let (meant, labels) = self.meanings(segments, &used, notes);
            let (ids, overlaps) = self.ids(samples, &meant)?;
            if overlaps > 0 {
                notes.push(format!(
                    "{overlaps} voxels belong to several segments; the last segment is kept"
                ));
            }
            let largest = meant.iter().flat_map(BTreeMap::values).map(|meant| meant.id).max();
            Ok((narrowed(ids, largest.unwrap_or(0)), labels))
        })
    }

    /// The layer of the sample at a place.
    fn layer(&self, at: usize) -> usize {
        at / self.before % self.count
    }

    /// The numbers of each layer except 0.
    fn used<T: Sample>(&self, samples: &[T]) -> Result<Vec<BTreeSet<u32>>, Error> {
        let mut used = vec![BTreeSet::new(); self.count];
        let mut last = vec![T::from_f64(0.0); self.count];
        for (at, &sample) in samples.iter().enumerate() {
            let layer = self.layer(at);
            if sample != last[layer] {
                last[layer] = sample;
                used[layer].insert(id_of(sample)?);
            }
        }
        used.iter_mut().for_each(|numbers| {
            numbers.remove(&0);
        });
        Ok(used)
    }

    /// The id of each number of each layer, and the labels. Numbers stay ids if no two segments
    /// share one.
    fn meanings(
        &self,
        segments: &[Segment],
        used: &[BTreeSet<u32>],
        notes: &mut Vec<String>,
    ) -> (Vec<BTreeMap<u32, Meant>>, Vec<Label>) {
        let mut meant: Vec<BTreeMap<u32, Meant>> = vec![BTreeMap::new(); self.count];
        let mut labels: Vec<Label> = Vec::new();
        for Segment { layer, label } in segments {
            let Some(numbers) = meant.get_mut(*layer).filter(|_| label.id > 0) else {
                let Label { id, name, .. } = label;
                notes.push(format!(
                    "`{name}` (value {id} in layer {layer}) has no voxels"
                ));
                continue;
            };
            if numbers.contains_key(&label.id) {
                notes.push(note_of_twice(label));
                continue;
            }
            // Ranks count from 1; what has no name has rank 0.
            let (id, rank) = (label.id, labels.len() + 1);
            numbers.insert(id, Meant { id, rank });
            labels.push(label.clone());
        }
        let named: Vec<u32> = labels.iter().map(|label| label.id).collect();
        for (numbers, used) in meant.iter_mut().zip(used) {
            for &id in used {
                numbers.entry(id).or_insert(Meant { id, rank: 0 });
            }
        }
        let ids = || meant.iter().flat_map(BTreeMap::keys);
        if ids().collect::<BTreeSet<_>>().len() == ids().count() {
            return (meant, labels);
        }
        let mut next = named.len() as u32;
        for meant in meant.iter_mut().flat_map(BTreeMap::values_mut) {
            if meant.rank > 0 {
                meant.id = meant.rank as u32;
            } else {
                next += 1;
                meant.id = next;
            }
        }
        for (i, label) in labels.iter_mut().enumerate() {
            label.id = i as u32 + 1;
        }
        let what = format!("segments in {} layers share numbers", self.count);
        notes.push(format!(
            "{what}; their ids are 1, 2, … in the order of the file"
        ));
        (meant, labels)
    }

    /// The id of each voxel, and how many voxels have several.
    fn ids<T: Sample>(
        &self,
        samples: &[T],
        meant: &[BTreeMap<u32, Meant>],
    ) -> Result<(Vec<u32>, u64), Error> {
        let nothing = Meant { id: 0, rank: 0 };
        let voxels = samples.len() / self.count;
        let mut ids = memory::reserved(voxels)?;
        let mut overlaps = 0;
        let mut last = vec![(T::from_f64(0.0), nothing); self.count];
        for voxel in 0..voxels {
            let first = voxel / self.before * self.before * self.count + voxel % self.before;
            let mut kept = nothing;
            let mut is_several = false;
            for (layer, last) in last.iter_mut().enumerate() {
                let sample = samples[first + layer * self.before];
                if sample != last.0 {
                    let found = meant[layer].get(&id_of(sample)?);
                    *last = (sample, found.copied().unwrap_or(nothing));
                }
                let found = last.1;
                if found.id == 0 {
                    continue;
                }
                is_several |= kept.id != 0;
                if kept.id == 0 || found.rank >= kept.rank {
                    kept = found;
                }
            }
            overlaps += u64::from(is_several);
            ids.push(kept.id);
        }
        Ok((ids, overlaps))
    }
}

fn id_of<T: Sample>(sample: T) -> Result<u32, Error> {
    let number = sample.to_f64();
    if number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number) {
        return Ok(number as u32);
    }
    let allowed = "whole numbers from 0 to 4294967295";
    Err(Error::field("a number of a segmentation", number, allowed))
}

/// Ids in the narrowest type.
fn narrowed(ids: Vec<u32>, largest: u32) -> Samples {
    match largest {
        0..=0xFF => Samples::U8(ids.into_iter().map(|id| id as u8).collect()),
        0x100..=0xFFFF => Samples::U16(ids.into_iter().map(|id| id as u16).collect()),
        _ => Samples::U32(ids),
    }
}
