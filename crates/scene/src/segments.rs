//! Which segments of a label volume are drawn how: from what a scene says to the Plan's [`Labelled`].

use crate::headers::LabelHeader;
use crate::nearest::nearest;
use crate::plan::{Compositing, Labelled, SegmentLook};
use crate::problem::{Checker, Within};
use crate::technique::{SCENE, SOLID, SegmentTechnique};
use crate::{Color, light};
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
            SegmentChoice::Name(pattern) => {
                let pattern = pattern.to_lowercase();
                label.is_some_and(|label| matches(&pattern, &label.name.to_lowercase()))
            }
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

    /// Its parts that choose no segment of `labels`.
    fn without_segments<'c>(&'c self, labels: &LabelHeader, found: &mut Vec<&'c SegmentChoice>) {
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

/// What a list of uses comes to for one segment.
#[derive(Clone, Debug, PartialEq)]
struct SettledScene<'u> {
    technique: &'u str,
    show: bool,
    color: Option<Color>,
    opacity: f64,
    importance: f64,
}

impl<'u> SettledScene<'u> {
    fn of(uses: &'u [SegmentUse], id: u32, label: Option<&Label>) -> SettledScene<'u> {
        let mut settled = SettledScene {
            technique: SOLID,
            show: id != 0,
            color: None,
            opacity: 1.0,
            importance: 0.0,
        };
        for used in uses.iter().filter(|used| used.of.has(id, label)) {
            if let Some(technique) = &used.technique {
                settled.technique = technique;
            }
            // Whoever says how the background is drawn wants to see it.
            settled.show = used.show.unwrap_or(settled.show || id == 0);
            settled.color = used.color.or(settled.color);
            settled.opacity = used.opacity.unwrap_or(settled.opacity);
            settled.importance = used.importance.unwrap_or(settled.importance);
        }
        settled
    }
}

/// The names of the techniques that `uses` ask for among `segments`, each once, in the order in which they are met.
pub(crate) fn techniques_of(uses: &[SegmentUse], labels: &LabelHeader) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for (id, label) in labels.segments() {
        let settled = SettledScene::of(uses, id, label);
        if settled.show && !names.iter().any(|name| name == settled.technique) {
            names.push(settled.technique.to_owned());
        }
    }
    names
}

/// Says what is wrong with `uses` whatever segments there are.
pub(crate) fn check(
    uses: &[SegmentUse],
    techniques: &BTreeMap<String, SegmentTechnique>,
    checker: &mut Checker,
) {
    for (i, used) in uses.iter().enumerate() {
        let path = format!("segments[{i}]");
        if let Some(opacity) = used.opacity {
            checker.number(
                &format!("{path}.opacity"),
                opacity,
                Within::Closed(0.0, 1.0),
            );
        }
        if let Some(importance) = used.importance {
            let within = Within::Closed(0.0, 50.0);
            checker.number(&format!("{path}.importance"), importance, within);
        }
        if let Some(color) = used.color {
            light::check_color(&format!("{path}.color"), color, checker);
        }
        let Some(name) = &used.technique else {
            continue;
        };
        let known = || techniques.keys().map(String::as_str).chain([SOLID, SCENE]);
        if !known().any(|other| other == name) {
            let mut allowed = known().collect::<Vec<_>>().join(", ");
            if let Some(near) = nearest(name, known()) {
                allowed.push_str(&format!("; did you mean {near:?}?"));
            }
            checker.add(format!("{path}.technique"), format!("{name:?}"), &allowed);
        }
    }
}

/// The segments of a Plan. `number` tells the number of a technique by its name, and whether its colors are those of
/// the segments.
pub(crate) fn plan(
    uses: &[SegmentUse],
    labels: &LabelHeader,
    grid: strahl_volume::Grid,
    compositing: Compositing,
    number: impl Fn(&str) -> Option<(usize, bool)>,
) -> Labelled {
    let look = |id: u32, label: Option<&Label>| {
        let settled = SettledScene::of(uses, id, label);
        let Some((technique, is_colored)) = number(settled.technique).filter(|_| settled.show)
        else {
            return SegmentLook::HIDDEN;
        };
        let color = match settled.color {
            Some(color) => color,
            None if is_colored => color_of(id, label),
            None => Color::WHITE,
        };
        SegmentLook {
            technique: Some(technique),
            tint: color.in_space(compositing),
            opacity: settled.opacity as f32,
            importance: settled.importance as f32,
        }
    };
    Labelled {
        labels: 0,
        grid,
        is_moved: grid != labels.grid,
        looks: labels
            .segments()
            .map(|(id, label)| (id, look(id, label)))
            .collect(),
        others: SegmentLook::HIDDEN,
    }
}

/// The color that the file gives, or one that few other ids have.
fn color_of(id: u32, label: Option<&Label>) -> Color {
    if let Some(color) = label.and_then(|label| label.color) {
        return Color(color.map(f64::from));
    }
    // Hues by the golden ratio lie apart, however many there are; three lightnesses tell neighbors of a hue apart.
    let hue = 6.0 * (f64::from(id) * 0.618_033_988_749_895).fract();
    let [least, most] = [[0.25, 0.95], [0.45, 1.0], [0.1, 0.7]][(id / 7 % 3) as usize];
    let channel = |middle: f64| {
        let distance = (hue - middle).abs().min(6.0 - (hue - middle).abs());
        least + (most - least) * (2.0 - distance).clamp(0.0, 1.0)
    };
    Color([channel(0.0), channel(2.0), channel(4.0)])
}

/// What a person should know who has `uses` drawn of `labels`.
pub(crate) fn notes(uses: &[SegmentUse], labels: &LabelHeader) -> Vec<String> {
    let mut notes = Vec::new();
    for (i, used) in uses.iter().enumerate() {
        let mut missing = Vec::new();
        used.of.without_segments(labels, &mut missing);
        for choice in missing {
            let (what, near) = match choice {
                SegmentChoice::Id(id) => (format!("the id {id}"), None),
                SegmentChoice::Name(name) => {
                    let names = labels.labels.iter().map(|label| &*label.name);
                    (format!("the name {name:?}"), nearest(name, names))
                }
                SegmentChoice::Group(OfGroup { group }) => {
                    let groups = labels
                        .labels
                        .iter()
                        .flat_map(|label| label.group.as_deref());
                    (format!("the group {group:?}"), nearest(group, groups))
                }
                SegmentChoice::List(_) | SegmentChoice::But(_) => continue,
            };
            let near = near.map_or(String::new(), |near| format!("; did you mean {near:?}?"));
            notes.push(format!("segments[{i}].of: no segment has {what}{near}"));
        }
    }
    if shown(uses, labels) == 0 {
        let hidden = "every segment is hidden: the picture is empty";
        // A choice without segments is the reason.
        match notes.last_mut() {
            Some(note) => *note = format!("{note}; {hidden}"),
            None => notes.push(hidden.to_owned()),
        }
    }
    notes
}

fn shown(uses: &[SegmentUse], labels: &LabelHeader) -> usize {
    let is_shown = |(id, label): &(u32, Option<&Label>)| SettledScene::of(uses, *id, *label).show;
    labels.segments().filter(is_shown).count()
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

    #[test]
    fn later_uses_count_more_and_the_background_is_shown_only_when_named() {
        let uses: Vec<SegmentUse> = serde_json::from_str(
            r#"[{ "of": "*", "opacity": 0.2 }, { "of": ["L*", 9], "technique": "scene" }, { "of": 9, "show": false }]"#,
        )
        .unwrap();
        let of = |id, label: Option<&Label>| SettledScene::of(&uses, id, label);
        let liver = of(5, Some(&Label::new(5, "liver")));
        assert_eq!(
            (liver.technique, liver.show, liver.opacity),
            (SCENE, true, 0.2)
        );
        assert!(!of(9, None).show && !of(0, Some(&Label::new(0, "air"))).show);
        let named = [SegmentUse {
            of: SegmentChoice::Id(0),
            technique: None,
            show: None,
            color: None,
            opacity: None,
            importance: None,
        }];
        assert!(SettledScene::of(&named, 0, None).show);
        // Without any use all but the background are shown.
        assert!(SettledScene::of(&[], 1, None).show && !SettledScene::of(&[], 0, None).show);
    }
}
