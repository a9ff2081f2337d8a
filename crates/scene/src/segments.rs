//! Which segments of a label volume are drawn how: from what a scene says to the Plan's [`Labeled`].

use crate::Color;
use crate::headers::LabelHeader;
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use strahl_volume::Label;

/// How the runs of segments become a pixel. A run is what the technique of a segment makes of its samples in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum SegmentComposite {
    /// Each run hides what is behind it by its opacity.
    EmissionAbsorption,
    /// The brightest run.
    Mip,
    /// The mean of all runs.
    Average,
    /// The first run that is not transparent.
    First,
    /// Runs of important segments show through what lies before them.
    ImportanceAware,
}

/// How some segments are drawn. Keys that are left out stay as earlier entries of the list have them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SegmentUse {
    /// Which segments.
    pub of: SegmentChoice,
    /// The name of the technique: one of `techniques`, `solid` or `scene`; default `solid`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub technique: Option<String>,
    /// Whether they are drawn; default true.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub show: Option<bool>,
    /// What the colors of the technique are multiplied by. Default: where the technique has no transfer function, the
    /// color that the file gives, or one chosen by the id; white elsewhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub color: Option<Color>,
    /// What the opacity of each run is multiplied by, 0 to 1; default 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opacity: Option<f64>,
    /// For `composite` `importance-aware`: of two segments that differ by 1, the more important one gets 63 % of the
    /// light at least, by 3 95 %. 0 to 50; default 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub importance: Option<f64>,
}

/// Segments by id or name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(untagged)]
pub enum SegmentChoice {
    /// The segment with this id.
    Id(u32),
    /// Those whose names match, in which `*` stands for any characters and `?` for one; `*` alone is every segment but
    /// the background, which is id 0. Upper and lower case are equal.
    Name(String),
    /// All of these.
    List(Vec<SegmentChoice>),
    /// All but the background and others.
    But(AllBut),
    /// Those of a group.
    Group(OfGroup),
}

/// The segments of a group.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct OfGroup {
    /// One of `groups` in `labels`, or a group in the label file, such as a tissue class. Upper and lower case are equal.
    pub group: String,
}

/// All segments but the background and some others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct AllBut {
    /// These.
    pub not: Vec<SegmentChoice>,
}

impl SegmentChoice {
    /// Whether the segment with this id is among them, of which `label` is known.
    pub fn has(&self, id: u32, label: Option<&Label>) -> bool {
        match self {
            SegmentChoice::Id(own) => *own == id,
            SegmentChoice::Name(pattern) if pattern == "*" => id != 0,
            SegmentChoice::Name(pattern) => label
                .is_some_and(|label| matches(&pattern.to_lowercase(), &label.name.to_lowercase())),
            SegmentChoice::List(list) => list.iter().any(|choice| choice.has(id, label)),
            SegmentChoice::But(AllBut { not }) => {
                id != 0 && !not.iter().any(|choice| choice.has(id, label))
            }
            SegmentChoice::Group(OfGroup { group }) => {
                let of = label.and_then(|label| label.group.as_ref());
                of.is_some_and(|of| of.to_lowercase() == group.to_lowercase())
            }
        }
    }

    /// Puts the members of `groups` in the place of their names. Names that are not there are of groups in the label file.
    pub(crate) fn replace_groups(&mut self, groups: &BTreeMap<String, Vec<SegmentChoice>>) {
        match self {
            SegmentChoice::List(list) | SegmentChoice::But(AllBut { not: list }) => {
                list.iter_mut()
                    .for_each(|choice| choice.replace_groups(groups));
            }
            SegmentChoice::Group(OfGroup { group }) => {
                let asked = group.to_lowercase();
                let mut named = groups.iter();
                if let Some((_, members)) = named.find(|(name, _)| name.to_lowercase() == asked) {
                    *self = SegmentChoice::List(members.clone());
                }
            }
            SegmentChoice::Id(_) | SegmentChoice::Name(_) => {}
        }
    }

    /// The segments of its parts that choose only such as no voxel has.
    pub(crate) fn without_voxels(&self, labels: &LabelHeader, found: &mut Vec<u32>) {
        match self {
            SegmentChoice::List(list) => {
                list.iter()
                    .for_each(|choice| choice.without_voxels(labels, found));
            }
            SegmentChoice::But(_) | SegmentChoice::Id(0) => {}
            choice => {
                let chosen = labels
                    .segments()
                    .filter(|(id, label)| choice.has(*id, *label));
                let chosen: Vec<u32> = chosen.map(|(id, _)| id).collect();
                let is_unused = |id: &u32| labels.unused_ids.binary_search(id).is_ok();
                if chosen.iter().all(is_unused) {
                    found.extend(chosen);
                }
            }
        }
    }

    /// Its parts that choose no segment of `labels`.
    pub(crate) fn without_segments<'c>(
        &'c self,
        labels: &LabelHeader,
        found: &mut Vec<&'c SegmentChoice>,
    ) {
        match self {
            SegmentChoice::List(list) | SegmentChoice::But(AllBut { not: list }) => {
                list.iter()
                    .for_each(|choice| choice.without_segments(labels, found));
            }
            // Whatever there is.
            SegmentChoice::Id(0) => {}
            choice => {
                if !labels.segments().any(|(id, label)| choice.has(id, label)) {
                    found.push(choice);
                }
            }
        }
    }
}

/// Whether `text` is `pattern` with `*` for any characters and `?` for one.
fn matches(pattern: &str, text: &str) -> bool {
    let (pattern, text): (Vec<char>, Vec<char>) =
        (pattern.chars().collect(), text.chars().collect());
    let (mut p, mut t) = (0, 0);
    // Where the last `*` stands, and up to where it reaches.
    let mut star = None;
    while t < text.len() {
        match pattern.get(p) {
            Some('*') => {
                star = Some((p, t));
                p += 1;
            }
            Some(c) if *c == '?' || *c == text[t] => (p, t) = (p + 1, t + 1),
            _ => match &mut star {
                Some((at, reach)) => {
                    *reach += 1;
                    (p, t) = (*at + 1, *reach);
                }
                None => return false,
            },
        }
    }
    pattern[p..].iter().all(|c| *c == '*')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_match_as_in_file_names() {
        for (pattern, text, expected) in [
            ("liver", "liver", true),
            ("liver", "livers", false),
            ("l*r", "liver", true),
            ("*kidney*", "left kidney cyst", true),
            ("rib_?_left", "rib_7_left", true),
            ("rib_?_left", "rib_12_left", false),
            ("a*b*c", "aXbYbZc", true),
            ("a*b*c", "aXbYbZ", false),
            ("", "", true),
            ("**", "", true),
            ("?", "", false),
        ] {
            assert_eq!(matches(pattern, text), expected, "{pattern} {text}");
        }
    }
}
