//! Which segments are drawn by which techniques, and how: from what a scene says to the segments of the Plan.

use crate::headers::LabelHeader;
use crate::nearest::nearest;
use crate::plan::{Compositing, GlobalRule, Labeled, SegmentGroup, SegmentLook};
use crate::problem::{Checker, Within};
use crate::segments::{OfGroup, SegmentChoice, SegmentComposite, SegmentUse};
use crate::technique::{SCENE, SOLID, SegmentTechnique};
use crate::{Color, light};
use std::collections::{BTreeMap, BTreeSet};
use strahl_volume::Label;

/// What a list of uses comes to for one segment.
#[derive(Clone, Debug, PartialEq)]
struct SettledUse<'u> {
    technique: &'u str,
    show: bool,
    color: Option<Color>,
    opacity: f64,
    importance: f64,
}

/// What one segment comes to, with the group that it is drawn in, if it is in one.
struct Drawn<'u> {
    own: SettledUse<'u>,
    group: Option<Group<'u>>,
}

/// Segments that a two-level technique draws with one opacity and importance.
#[derive(Clone, Copy, PartialEq)]
struct Group<'u> {
    technique: &'u str,
    opacity: f64,
    importance: f64,
}

impl<'u> Drawn<'u> {
    fn of(uses: &'u [SegmentUse], all: &'u Techniques, id: u32, label: Option<&Label>) -> Self {
        let own = SettledUse::of(uses, id, label);
        let technique = all.get(own.technique).filter(|t| t.is_two_level());
        let Some(technique) = technique else {
            return Drawn { own, group: None };
        };
        let within = SettledUse::starting(id != 0 || own.show, technique.uses(), id, label);
        Drawn {
            own: SettledUse {
                show: own.show && within.show,
                color: within.color.or(own.color),
                ..within
            },
            group: Some(Group {
                technique: own.technique,
                opacity: own.opacity,
                importance: own.importance,
            }),
        }
    }
}

/// The techniques of a scene by their names.
pub(crate) type Techniques = BTreeMap<String, SegmentTechnique>;

impl<'u> SettledUse<'u> {
    fn of(uses: &'u [SegmentUse], id: u32, label: Option<&Label>) -> SettledUse<'u> {
        SettledUse::starting(id != 0, uses, id, label)
    }

    fn starting(
        show: bool,
        uses: &'u [SegmentUse],
        id: u32,
        label: Option<&Label>,
    ) -> SettledUse<'u> {
        let mut settled = SettledUse {
            technique: SOLID,
            show,
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
pub(crate) fn techniques_of(
    uses: &[SegmentUse],
    all: &Techniques,
    labels: &LabelHeader,
) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for (id, label) in labels.segments() {
        let settled = Drawn::of(uses, all, id, label).own;
        if settled.show && !names.iter().any(|name| name == settled.technique) {
            names.push(settled.technique.to_owned());
        }
    }
    names
}

/// The names of the two-level techniques that draw a segment.
pub(crate) fn two_level_of(
    uses: &[SegmentUse],
    all: &Techniques,
    labels: &LabelHeader,
) -> Vec<String> {
    let of = |(id, label)| Drawn::of(uses, all, id, label);
    let shown = labels.segments().map(of).filter(|drawn| drawn.own.show);
    let mut names: Vec<_> = shown
        .filter_map(|drawn| Some(drawn.group?.technique.to_owned()))
        .collect();
    names.sort();
    names.dedup();
    names
}

/// Says what is wrong with `uses` whatever segments there are.
pub(crate) fn check(uses: &[SegmentUse], techniques: &Techniques, checker: &mut Checker) {
    check_uses("segments", uses, techniques, checker);
    for (name, technique) in techniques.iter().filter(|(_, t)| t.is_two_level()) {
        let path = format!("techniques.{name}.segments");
        check_uses(&path, technique.uses(), techniques, checker);
        for (i, used) in technique.uses().iter().enumerate() {
            let is_deeper = |name: &String| techniques.get(name).is_some_and(|t| t.is_two_level());
            if let Some(name) = used.technique.as_ref().filter(|name| is_deeper(name)) {
                let path = format!("{path}[{i}].technique");
                let allowed = "a technique without `segments` and `composite`";
                checker.add(path, format!("{name:?}"), allowed);
            }
        }
    }
}

fn check_uses(path: &str, uses: &[SegmentUse], techniques: &Techniques, checker: &mut Checker) {
    for (i, used) in uses.iter().enumerate() {
        let path = format!("{path}[{i}]");
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
/// the segments; `rule` what a composite is in the Plan.
pub(crate) fn plan(
    (uses, all): (&[SegmentUse], &Techniques),
    labels: &LabelHeader,
    grid: strahl_volume::Grid,
    compositing: Compositing,
    number: impl Fn(&str) -> Option<(usize, bool)>,
    rule: impl Fn(SegmentComposite) -> GlobalRule,
) -> Labeled {
    let mut groups: Vec<Group> = Vec::new();
    let mut look = |id: u32, label: Option<&Label>| {
        let Drawn {
            own: settled,
            group,
        } = Drawn::of(uses, all, id, label);
        let Some((technique, is_colored)) = number(settled.technique).filter(|_| settled.show)
        else {
            return SegmentLook::HIDDEN;
        };
        let group = group.map(|group| {
            let known = groups.iter().position(|known| *known == group);
            known.unwrap_or_else(|| {
                groups.push(group);
                groups.len() - 1
            })
        });
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
            group,
        }
    };
    let looks = labels
        .segments()
        .map(|(id, label)| (id, look(id, label)))
        .collect();
    let group = |group: &Group| {
        let composite = all.get(group.technique).and_then(|t| t.composite);
        SegmentGroup {
            rule: rule(composite.unwrap_or(SegmentComposite::EmissionAbsorption)),
            opacity: group.opacity as f32,
            importance: group.importance as f32,
        }
    };
    Labeled {
        labels: 0,
        grid,
        is_moved: grid != labels.grid,
        looks,
        others: SegmentLook::HIDDEN,
        groups: groups.iter().map(group).collect(),
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
pub(crate) fn notes(uses: &[SegmentUse], all: &Techniques, labels: &LabelHeader) -> Vec<String> {
    let mut notes = Vec::new();
    notes_of("segments", uses, labels, &mut notes);
    for (name, technique) in all {
        let path = format!("techniques.{name}.segments");
        notes_of(&path, technique.uses(), labels, &mut notes);
    }
    if shown(uses, all, labels) == 0 {
        notes.push("every segment is hidden: the picture is empty".to_owned());
    }
    notes
}

fn notes_of(path: &str, uses: &[SegmentUse], labels: &LabelHeader, notes: &mut Vec<String>) {
    let mut said = BTreeSet::new();
    for (i, used) in uses.iter().enumerate() {
        let mut missing = Vec::new();
        used.of.without_segments(labels, &mut missing);
        for choice in missing {
            let (what, near) = match choice {
                SegmentChoice::Id(id) => (format!("the id {id}"), None),
                SegmentChoice::Name(name) => {
                    let names = labels.labels.iter().map(|label| &*label.name);
                    let what = format!("the name {name:?}");
                    match with_part(name, names.clone()) {
                        Some(others) => (format!("{what}; {others}"), None),
                        None => (what, nearest(name, names)),
                    }
                }
                SegmentChoice::Group(OfGroup { group }) => {
                    let groups = labels
                        .labels
                        .iter()
                        .flat_map(|label| label.group.as_deref());
                    let what = format!("the group {group:?}");
                    match nearest(group, groups.clone()) {
                        None => (format!("{what}; {}", all_groups(groups)), None),
                        near => (what, near),
                    }
                }
                SegmentChoice::List(_) | SegmentChoice::But(_) => continue,
            };
            let near = near.map_or(String::new(), |near| format!("; did you mean {near:?}?"));
            let note = format!("no segment has {what}{near}");
            // The same choice in two entries is one mistake.
            if said.insert(note.clone()) {
                notes.push(format!("{path}[{i}].of: {note}"));
            }
        }
        if used.show != Some(false) {
            notes.extend(note_of_unused(&format!("{path}[{i}].of"), &used.of, labels));
        }
    }
}

/// How to choose the segments whose names have `part` in them, if there are several; or those of a list with commas.
fn with_part<'a>(part: &str, names: impl Iterator<Item = &'a str> + Clone) -> Option<String> {
    let wanted = part.to_lowercase();
    let has = |name: &&str| name.to_lowercase().contains(&wanted);
    let number = names.clone().filter(has).count();
    if number > 1 && !part.contains(['*', '?']) {
        return Some(format!("{number} names contain it: write \"*{part}*\""));
    }
    let parts: Vec<&str> = part.split(',').map(str::trim).collect();
    let is_name = |part: &str| names.clone().any(|name| name.eq_ignore_ascii_case(part));
    (parts.len() > 1 && parts.iter().any(|part| is_name(part)))
        .then(|| "it is a list: give its names one by one".to_owned())
}

/// What to say of segments that were asked for, that have names, and that no voxel belongs to.
fn note_of_unused(path: &str, of: &SegmentChoice, labels: &LabelHeader) -> Option<String> {
    /// More would not be read.
    const MOST: usize = 6;
    let mut unused = Vec::new();
    of.without_voxels(labels, &mut unused);
    let name = |id: &u32| match labels.labels.iter().find(|label| label.id == *id) {
        Some(label) => format!("{:?} ({id})", label.name),
        None => id.to_string(),
    };
    let named: Vec<String> = unused.iter().take(MOST).map(name).collect();
    let named = named.join(", ");
    match unused.len() {
        0 => None,
        1 => Some(format!("{path}: the segment {named} has no voxels")),
        n if n > MOST => Some(format!(
            "{path}: {n} segments have no voxels, such as {named}"
        )),
        _ => Some(format!("{path}: the segments {named} have no voxels")),
    }
}

/// The names of the groups that there are, for who named another one.
fn all_groups<'a>(groups: impl Iterator<Item = &'a str>) -> String {
    /// More would not be read.
    const MOST: usize = 12;
    let all: BTreeSet<&str> = groups.collect();
    let named: Vec<String> = all
        .iter()
        .take(MOST)
        .map(|name| format!("{name:?}"))
        .collect();
    match all.len() {
        0 => "the labels have no groups".to_owned(),
        n if n > MOST => format!("there are {n} groups, such as {}", named.join(", ")),
        _ => format!("the groups are {}", named.join(", ")),
    }
}

fn shown(uses: &[SegmentUse], all: &Techniques, labels: &LabelHeader) -> usize {
    let is_shown = |(id, label): &(u32, Option<&Label>)| Drawn::of(uses, all, *id, *label).own.show;
    labels.segments().filter(is_shown).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_level_techniques_have_segments_of_their_own() {
        let read = |text: &str| -> Vec<SegmentUse> { serde_json::from_str(text).unwrap() };
        let uses = read(
            r#"[{ "of": "*", "technique": "group", "opacity": 0.5 }, { "of": 2, "importance": 1 }, { "of": 9, "technique": "scene" }]"#,
        );
        let group = SegmentTechnique {
            composite: Some(SegmentComposite::Mip),
            segments: Some(read(
                r#"[{ "of": "*", "technique": "scene", "opacity": 0.2 }, { "of": 3, "show": false }]"#,
            )),
            ..SegmentTechnique::default()
        };
        let all: Techniques = [("group".to_owned(), group)].into();
        let of = |id| Drawn::of(&uses, &all, id, None);
        let [first, second] = [1, 2].map(|id| of(id).group.unwrap());
        assert_eq!((first.opacity, first.importance), (0.5, 0.0));
        assert_eq!((second.opacity, second.importance), (0.5, 1.0));
        assert_eq!((of(1).own.technique, of(1).own.opacity), (SCENE, 0.2));
        assert!(!of(3).own.show && of(9).own.show && of(9).group.is_none());

        let mut checker = Checker::default();
        let deeper = SegmentTechnique {
            segments: Some(read(r#"[{ "of": 1, "technique": "group" }]"#)),
            ..SegmentTechnique::default()
        };
        let all: Techniques = all.into_iter().chain([("b".to_owned(), deeper)]).collect();
        check(&uses, &all, &mut checker);
        let found: Vec<_> = checker.problems.iter().map(|p| &*p.path).collect();
        assert_eq!(found, ["techniques.b.segments[0].technique"]);
    }

    #[test]
    fn later_uses_count_more_and_the_background_is_shown_only_when_named() {
        let uses: Vec<SegmentUse> = serde_json::from_str(
            r#"[{ "of": "*", "opacity": 0.2 }, { "of": ["L*", 9], "technique": "scene" }, { "of": 9, "show": false }]"#,
        )
        .unwrap();
        let of = |id, label: Option<&Label>| SettledUse::of(&uses, id, label);
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
        assert!(SettledUse::of(&named, 0, None).show);
        // Without any use all but the background are shown.
        assert!(SettledUse::of(&[], 1, None).show && !SettledUse::of(&[], 0, None).show);
    }
}
