//! Where the segments of a scene come from: a label file, masks, intervals of values; and groups of them.

use crate::problem::{Checker, Problems};
use crate::segments::{SegmentChoice, SegmentUse};
use crate::{Color, light};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use strahl_volume::{Label, MOST_THRESHOLDS};

/// Where segments come from: at most one of `path`, `masks` and `layers`. With none of them, those that the data brings along.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct LabelSource {
    /// File of object ids, relative to the folder of the scene file; or a folder of masks. On the grid of the volume or on another.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path: Option<String>,
    /// File with names and colors of the ids; default: those in `path` or in a table beside it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table: Option<String>,
    /// Binary masks on one grid: the segments 1, 2, …; where they overlap, the last one counts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub masks: Option<Vec<NamedMask>>,
    /// Intervals of the values of the volume.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layers: Option<ValueLayers>,
    /// Groups of segments by name, for `{ "group": … }` in `segments`. They replace groups of the same name in the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub groups: Option<BTreeMap<String, Vec<SegmentChoice>>>,
}

/// A mask that is a segment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct NamedMask {
    /// File, relative to the folder of the scene file. Its voxels are 0 outside, and one other number inside.
    pub path: String,
    /// Name of the segment; default: that of the file, without its extension.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Color of the segment; default: one chosen by the id.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub color: Option<Color>,
}

/// Intervals of values as segments.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(untagged)]
pub enum ValueLayers {
    /// This many of equal width, from the smallest value of the volume to the largest, 2 to 256. The lowest is the background.
    Count(u32),
    /// Layers that begin at ascending values and reach up to the next; what is lower than all is the background.
    From(Vec<ValueLayer>),
}

/// One interval of values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(untagged)]
pub enum ValueLayer {
    /// It begins at this value, and is called `layer 1` if it is the first.
    Value(f64),
    /// The same with a name.
    Named(NamedLayer),
}

/// One interval of values with a name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct NamedLayer {
    /// The value that it begins at.
    pub from: f64,
    /// Name of the segment.
    pub name: String,
    /// Color of the segment; default: one chosen by the id.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub color: Option<Color>,
}

impl LabelSource {
    /// The object ids in a file or folder, and nothing else.
    pub fn file(path: impl Into<String>) -> LabelSource {
        LabelSource {
            path: Some(path.into()),
            ..LabelSource::default()
        }
    }

    /// `uses` with the members of its groups in place of their names.
    pub(crate) fn with_members(&self, uses: &[SegmentUse]) -> Vec<SegmentUse> {
        let none = BTreeMap::new();
        let groups = self.groups.as_ref().unwrap_or(&none);
        let mut uses = uses.to_vec();
        uses.iter_mut()
            .for_each(|used| used.of.replace_groups(groups));
        uses
    }

    /// Whether it says where segments come from.
    pub fn has_data(&self) -> bool {
        self.path.is_some() || self.masks.is_some() || self.layers.is_some()
    }

    /// Whether it can be read. To be asked before that.
    ///
    /// # Errors
    /// Everything that is wrong whatever the data is, such as two sources, or layers that do not ascend.
    pub fn check_itself(&self) -> Result<(), Problems> {
        let mut checker = Checker::default();
        self.check(&mut checker);
        Problems::none_of(checker.problems)
    }

    pub(crate) fn check(&self, checker: &mut Checker) {
        let said = [
            ("path", self.path.is_some()),
            ("masks", self.masks.is_some()),
            ("layers", self.layers.is_some()),
        ];
        let said: Vec<_> = said.iter().filter(|(_, is_set)| *is_set).collect();
        if said.len() > 1 {
            let keys: Vec<_> = said.iter().map(|(key, _)| *key).collect();
            let allowed = "one of \"path\", \"masks\" and \"layers\"";
            checker.add("labels", keys.join(" and "), allowed);
        }
        if self.table.is_some() && self.path.is_none() {
            let allowed = "a \"table\" only beside the \"path\" of a label file";
            checker.add("labels.table", "without path", allowed);
        }
        if self.masks.as_ref().is_some_and(Vec::is_empty) {
            checker.add("labels.masks", "empty", "one mask or more");
        }
        for (i, mask) in self.masks.iter().flatten().enumerate() {
            if let Some(color) = mask.color {
                light::check_color(&format!("labels.masks[{i}].color"), color, checker);
            }
        }
        for (name, members) in self.groups.iter().flatten() {
            if members.is_empty() {
                let path = format!("labels.groups.{name}");
                checker.add(path, "empty", "ids and names of segments");
            }
        }
        if let Some(layers) = &self.layers {
            layers.check(checker);
        }
    }
}

impl NamedMask {
    /// The segment that it is, with the id `id`; `stem` is the name of its file without the extension.
    pub fn label(&self, id: u32, stem: &str) -> Label {
        let name = self.name.clone().unwrap_or_else(|| stem.to_owned());
        Label {
            color: self.color.map(stored),
            ..Label::new(id, name)
        }
    }
}

impl ValueLayers {
    fn check(&self, checker: &mut Checker) {
        let most = MOST_THRESHOLDS;
        match self {
            ValueLayers::Count(count) => {
                if !(2..=most as u32 + 1).contains(count) {
                    let allowed = format!("2 to {}", most + 1);
                    checker.add("labels.layers", count, &allowed);
                }
            }
            ValueLayers::From(list) => {
                if !(1..=most).contains(&list.len()) {
                    let there = format!("a list of {}", list.len());
                    let allowed = format!("1 to {most} layers, or the number of equal ones");
                    checker.add("labels.layers", there, &allowed);
                }
                let mut last = f64::NEG_INFINITY;
                for (i, layer) in list.iter().enumerate() {
                    let (path, from) = (format!("labels.layers[{i}]"), layer.from());
                    if !from.is_finite() || from <= last {
                        checker.add(&path, from, "a value above that of the layer before");
                    }
                    last = from;
                    if let ValueLayer::Named(NamedLayer { color: Some(c), .. }) = layer {
                        light::check_color(&format!("{path}.color"), *c, checker);
                    }
                }
            }
        }
    }

    /// The values at which layers begin, in a volume of values from `low` to `high`. In one of a single value there is only the
    /// lowest of equal layers.
    pub fn thresholds(&self, [low, high]: [f64; 2]) -> Vec<f64> {
        match self {
            ValueLayers::Count(_) if high <= low => Vec::new(),
            ValueLayers::Count(count) => {
                let at = |i: u32| low + (high - low) * f64::from(i) / f64::from(*count);
                (1..*count).map(at).collect()
            }
            ValueLayers::From(list) => list.iter().map(ValueLayer::from).collect(),
        }
    }

    /// The segments that they are.
    pub fn labels(&self) -> Vec<Label> {
        let numbered = |id: u32| Label::new(id, format!("layer {id}"));
        match self {
            ValueLayers::Count(count) => (1..*count).map(numbered).collect(),
            ValueLayers::From(list) => {
                let label = |(id, layer): (u32, &ValueLayer)| match layer {
                    ValueLayer::Value(_) => numbered(id),
                    ValueLayer::Named(named) => Label {
                        color: named.color.map(stored),
                        ..Label::new(id, named.name.clone())
                    },
                };
                (1..).zip(list).map(label).collect()
            }
        }
    }
}

fn stored(color: Color) -> [f32; 3] {
    color.0.map(|part| part as f32)
}

impl ValueLayer {
    fn from(&self) -> f64 {
        match self {
            ValueLayer::Value(from) => *from,
            ValueLayer::Named(named) => named.from,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problems(text: &str) -> String {
        let source: LabelSource = serde_json::from_str(text).unwrap();
        let problems = source.check_itself();
        problems.map_or_else(|problems| problems.to_string(), |()| String::new())
    }

    #[test]
    fn equal_layers_divide_the_range() {
        let layers = ValueLayers::Count(4);
        assert_eq!(layers.thresholds([-1.0, 7.0]), [1.0, 3.0, 5.0]);
        let names: Vec<_> = layers.labels().iter().map(|l| l.name.clone()).collect();
        assert_eq!(names, ["layer 1", "layer 2", "layer 3"]);
        assert!(layers.thresholds([3.0, 3.0]).is_empty());
    }

    #[test]
    fn layers_have_values_names_and_colors() {
        let text = r##"[-300, { "from": 150, "name": "bone", "color": "#f00" }]"##;
        let layers: ValueLayers = serde_json::from_str(text).unwrap();
        assert_eq!(layers.thresholds([0.0, 1.0]), [-300.0, 150.0]);
        let labels = layers.labels();
        assert_eq!((labels[0].id, &*labels[0].name), (1, "layer 1"));
        assert_eq!((labels[1].id, &*labels[1].name), (2, "bone"));
        assert_eq!(labels[1].color, Some([1.0, 0.0, 0.0]));
    }

    #[test]
    fn every_mistake_is_named() {
        for (text, expected) in [
            (
                r#"{ "path": "a", "layers": 3 }"#,
                "labels is path and layers; allowed: one of",
            ),
            (
                r#"{ "layers": 1 }"#,
                "labels.layers is 1; allowed: 2 to 256",
            ),
            (
                r#"{ "layers": [] }"#,
                "labels.layers is a list of 0; allowed: 1 to 255 layers",
            ),
            (
                r#"{ "layers": [2, 2] }"#,
                "labels.layers[1] is 2; allowed: a value above",
            ),
            (r#"{ "masks": [] }"#, "labels.masks is empty"),
            (
                r#"{ "layers": 3, "table": "t" }"#,
                "labels.table is without path",
            ),
            (r#"{ "groups": { "a": [] } }"#, "labels.groups.a is empty"),
        ] {
            let found = problems(text);
            assert!(found.starts_with(expected), "{text}: {found}");
        }
        assert_eq!(
            problems(r#"{ "layers": [1, 2], "groups": { "a": ["b*", 3] } }"#),
            ""
        );
    }
}
