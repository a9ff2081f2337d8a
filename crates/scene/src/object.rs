//! What a scene draws beside its own volume: further volumes, meshes, and groups that move them.

use crate::problem::{Checker, Within};
use crate::{Color, FunctionUse, Shading, TransferFunction, VolumeSource};
use glam::{DAffine3, DMat3, DQuat, DVec3, EulerRot};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap, HashSet};

/// A volume, a mesh, or a group (an object without data) in the scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct SceneObject {
    /// Name for clips and other objects. The scene's own volume is called `volume`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Name of an object whose transforms also move this one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parent: Option<String>,
    /// Moves, turns or scales the object; default: the place in its file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transform: Option<Placement>,
    /// A volume.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub volume: Option<VolumeSource>,
    /// Instead of `volume`: the name of an object whose data this one shows again.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub like: Option<String>,
    /// Instead of `volume`: a file of triangles (STL, OBJ, PLY), relative to the folder of the
    /// scene file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<String>,
    /// Color of a mesh; default a light gray.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color: Option<Color>,
    /// Name of the preset that provides a volume's transfer function; default chosen from the
    /// volume.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preset: Option<String>,
    /// Maps the values of a volume to color and opacity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transfer_function: Option<TransferFunction>,
    /// How samples of a volume are lit; default as in the scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shading: Option<Shading>,
    /// Library functions for the slots `classify` and `gradient_input` of a volume; default as
    /// in the scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub functions: Option<BTreeMap<String, FunctionUse>>,
}

/// A transform: first scales, then turns, both about `about`, then moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Placement {
    /// Translation along x, y, z (RAS mm); default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub translate_mm: Option<[f64; 3]>,
    /// Rotation about x, then y, then z; default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotate_deg: Option<[f64; 3]>,
    /// Scale factors along x, y, z, above 0; default 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<[f64; 3]>,
    /// The fixed point of scaling and rotation; default the origin.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub about: Option<[f64; 3]>,
}

/// The name of the scene's own volume.
pub(crate) const OWN_VOLUME: &str = "volume";

/// The frame of clips that move with no object.
pub(crate) const WORLD: &str = "world";

impl SceneObject {
    /// Whether it only moves others.
    pub fn is_group(&self) -> bool {
        self.volume.is_none() && self.like.is_none() && self.mesh.is_none()
    }

    /// Whether it shows a volume.
    pub(crate) fn is_volume(&self) -> bool {
        self.volume.is_some() || self.like.is_some()
    }
}

impl Placement {
    /// The map that it stands for; `None`, with a problem, if it says what cannot be.
    pub(crate) fn affine(&self, path: &str, checker: &mut Checker) -> Option<DAffine3> {
        let before = checker.problems.len();
        let translate = self.translate_mm.unwrap_or([0.0; 3]);
        checker.point(&format!("{path}.translate_mm"), translate);
        let about = self.about.unwrap_or([0.0; 3]);
        checker.point(&format!("{path}.about"), about);
        let turn = self.rotate_deg.unwrap_or([0.0; 3]);
        let scale = self.scale.unwrap_or([1.0; 3]);
        for axis in 0..3 {
            checker.number(
                &format!("{path}.rotate_deg[{axis}]"),
                turn[axis],
                Within::Closed(-3600.0, 3600.0),
            );
            checker.number(
                &format!("{path}.scale[{axis}]"),
                scale[axis],
                Within::Closed(1e-6, 1e6),
            );
        }
        if checker.problems.len() > before {
            return None;
        }
        let [x, y, z] = turn.map(f64::to_radians);
        let turned = DMat3::from_quat(DQuat::from_euler(EulerRot::ZYX, z, y, x))
            * DMat3::from_diagonal(DVec3::from_array(scale));
        let about = DVec3::from_array(about);
        Some(
            DAffine3::from_translation(DVec3::from_array(translate) + about)
                * DAffine3::from_mat3(turned)
                * DAffine3::from_translation(-about),
        )
    }
}

/// The map of each object from where its file puts it to the world, own transform first, then its
/// parents'; the scene's own volume comes first.
pub(crate) fn placements(
    own: Option<&Placement>,
    objects: &[SceneObject],
    checker: &mut Checker,
) -> Vec<DAffine3> {
    let local = |path: &str, placement: Option<&Placement>, checker: &mut Checker| match placement {
        Some(placement) => placement
            .affine(path, checker)
            .unwrap_or(DAffine3::IDENTITY),
        None => DAffine3::IDENTITY,
    };
    let mut locals = vec![local("transform", own, checker)];
    for (i, object) in objects.iter().enumerate() {
        let path = format!("objects[{i}].transform");
        locals.push(local(&path, object.transform.as_ref(), checker));
    }
    let parents = parents(objects, checker);
    let mut worlds = locals.clone();
    let mut is_placed = vec![false; locals.len()];
    // Upwards to what is placed, then down again: no recursion, as a file can make the chain as long as it likes.
    let mut chain = Vec::new();
    for i in 1..locals.len() {
        let (mut at, mut world) = (i, locals[i]);
        for _ in 0..WALKED {
            let Some(parent) = parents[at] else { break };
            (at, world) = (parent, locals[parent] * world);
        }
        if parents[at].is_none() {
            worlds[i] = world;
            continue;
        }
        chain.clear();
        at = i;
        while let Some(parent) = parents[at].filter(|_| !is_placed[at]) {
            chain.push((at, parent));
            at = parent;
        }
        for (child, parent) in chain.drain(..).rev() {
            worlds[child] = worlds[parent] * locals[child];
            is_placed[child] = true;
        }
    }
    worlds
}

/// Up to so many parents are multiplied one after another, from an object upwards; of a longer chain every place is
/// made of that of the parent, so that it is linear.
const WALKED: usize = 64;

/// Of the scene's own volume and every object whose parent it has, if it has one that is there and not below it.
fn parents(objects: &[SceneObject], checker: &mut Checker) -> Vec<Option<usize>> {
    let mut by_name = HashMap::from([(OWN_VOLUME, 0)]);
    for (i, object) in objects.iter().enumerate() {
        if let Some(name) = &object.name {
            by_name.entry(name).or_insert(1 + i);
        }
    }
    let mut parents = vec![None; 1 + objects.len()];
    for (i, object) in objects.iter().enumerate() {
        let Some(parent) = &object.parent else {
            continue;
        };
        parents[1 + i] = by_name.get(parent.as_str()).copied();
        if parents[1 + i].is_none() {
            checker.add(
                format!("objects[{i}].parent"),
                format!("{parent:?}"),
                &format!("the name of an object: {}", known(objects)),
            );
        }
    }
    // Which walk has come by first; a walk that meets itself goes round.
    let mut walk_of = vec![0; parents.len()];
    let mut is_in_circle = vec![false; parents.len()];
    for start in 1..parents.len() {
        let mut at = start;
        while walk_of[at] == 0 {
            walk_of[at] = start;
            let Some(parent) = parents[at] else { break };
            at = parent;
        }
        let meets = parents[at].is_some() && (walk_of[at] == start || is_in_circle[at]);
        let mut passed = start;
        while meets && walk_of[passed] == start && !is_in_circle[passed] {
            is_in_circle[passed] = true;
            let Some(parent) = parents[passed] else { break };
            passed = parent;
        }
    }
    for (i, object) in objects.iter().enumerate() {
        if is_in_circle[1 + i] {
            checker.add(
                format!("objects[{i}].parent"),
                format!(
                    "{:?}, whose parents lead back to it",
                    object.parent.as_deref().unwrap_or_default()
                ),
                "an object that is not below this one",
            );
            parents[1 + i] = None;
        }
    }
    parents
}

/// How many names a message lists.
const NAMES_LISTED: usize = 30;

/// Every name, for messages.
pub(crate) fn known(objects: &[SceneObject]) -> String {
    let names = objects.iter().filter_map(|object| object.name.as_deref());
    let more = names.clone().nth(NAMES_LISTED).map(|_| "…");
    std::iter::once(OWN_VOLUME)
        .chain(names.take(NAMES_LISTED))
        .chain(more)
        .collect::<Vec<_>>()
        .join(", ")
}

/// What is wrong with the objects themselves: names, and what they are.
pub(crate) fn check(objects: &[SceneObject], checker: &mut Checker) {
    let mut names = HashSet::new();
    let with_volume = objects.iter().filter(|object| object.volume.is_some());
    let shown: HashSet<_> = with_volume
        .filter_map(|object| object.name.as_ref())
        .collect();
    for (i, object) in objects.iter().enumerate() {
        let path = format!("objects[{i}]");
        if let Some(name) = &object.name
            && (name.is_empty() || name == OWN_VOLUME || name == WORLD || !names.insert(name))
        {
            checker.add(
                format!("{path}.name"),
                format!("{name:?}"),
                "a name of its own; \"volume\" and \"world\" are reserved",
            );
        }
        let kinds = [
            object.volume.is_some(),
            object.like.is_some(),
            object.mesh.is_some(),
        ];
        if kinds.iter().filter(|given| **given).count() > 1 {
            checker.add(
                &path,
                "several of volume, like and mesh",
                "one of them, or none for a group",
            );
        }
        for (given, key, fits) in [
            (object.color.is_some(), "color", object.mesh.is_some()),
            (object.preset.is_some(), "preset", object.is_volume()),
            (
                object.transfer_function.is_some(),
                "transfer_function",
                object.is_volume(),
            ),
            (object.shading.is_some(), "shading", object.is_volume()),
            (object.functions.is_some(), "functions", object.is_volume()),
        ] {
            if given && !fits {
                checker.add(
                    format!("{path}.{key}"),
                    if object.is_group() {
                        "given for a group"
                    } else if object.mesh.is_some() {
                        "given for a mesh"
                    } else {
                        "given for a volume"
                    },
                    if key == "color" {
                        "nothing: meshes have a color"
                    } else {
                        "nothing: volumes have one"
                    },
                );
            }
        }
        if let Some(volume) = &object.volume {
            let mut problems = Vec::new();
            volume.check(&mut problems);
            checker
                .problems
                .extend(problems.into_iter().map(|mut problem| {
                    problem.path = format!("{path}.{}", problem.path);
                    problem
                }));
        }
        if let Some(like) = &object.like
            && like != OWN_VOLUME
            && !shown.contains(like)
        {
            checker.add(
                format!("{path}.like"),
                format!("{like:?}"),
                &format!(
                    "the name of an object with a volume of its own: {}",
                    known(objects)
                ),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_chains_of_parents_are_placed_and_circles_refused() {
        // Cubic in time, this would not end.
        const NUMBER: usize = 100_000;
        let object = |name: usize, parent: Option<usize>| SceneObject {
            name: Some(format!("o{name}")),
            parent: parent.map(|parent| format!("o{parent}")),
            transform: Some(Placement {
                translate_mm: Some([1.0, 0.0, 0.0]),
                ..Placement::default()
            }),
            ..SceneObject::default()
        };
        let mut objects: Vec<_> = (0..NUMBER).map(|i| object(i, i.checked_sub(1))).collect();
        let mut checker = Checker::default();
        check(&objects, &mut checker);
        let worlds = placements(None, &objects, &mut checker);
        assert!(checker.problems.is_empty());
        for i in [0, 5, WALKED, NUMBER - 1] {
            assert_eq!(worlds[1 + i].translation.x, (1 + i) as f64, "{i}");
        }
        // Two that lead to one another, and all that lead to them.
        objects[0].parent = Some("o1".into());
        placements(None, &objects, &mut checker);
        assert_eq!(checker.problems[0].path, "objects[0].parent");
        assert!(checker.problems.len() > 1);
        assert!(checker.problems.len() <= crate::problem::MOST_PROBLEMS);
    }

    #[test]
    fn parents_move_their_children() {
        let object = |name: &str, parent: Option<&str>, x: f64| SceneObject {
            name: Some(name.into()),
            parent: parent.map(str::to_owned),
            transform: Some(Placement {
                translate_mm: Some([x, 0.0, 0.0]),
                ..Placement::default()
            }),
            ..SceneObject::default()
        };
        let turned = Placement {
            rotate_deg: Some([0.0, 0.0, 90.0]),
            ..Placement::default()
        };
        let objects = [
            object("a", Some("b"), 1.0),
            object("b", Some("volume"), 10.0),
        ];
        let mut checker = Checker::default();
        let worlds = placements(Some(&turned), &objects, &mut checker);
        assert_eq!(checker.problems, []);
        let at = worlds[1].transform_point3(DVec3::ZERO);
        assert!((at - DVec3::new(0.0, 11.0, 0.0)).length() < 1e-12, "{at}");

        let circle = [object("a", Some("b"), 1.0), object("b", Some("a"), 1.0)];
        placements(None, &circle, &mut checker);
        assert_eq!(checker.problems.len(), 2);
    }
}
