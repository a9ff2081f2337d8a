//! Scene + volume headers → Plan, or every problem at once.

use crate::plan::{MOST_MASKS, Plan};
use crate::planning::{check_volumes, plan_of};
use crate::problem::Checker;
use crate::segmented::with_segments;
use crate::{Clip, Headers, LabelHeader, Problem, Problems, Scene};
use strahl_volume::VolumeHeader;

/// [`resolve_with`] for a scene of one volume. `labels` is what is known of the label volume, if one is
/// loaded.
///
/// # Errors
/// Everything that is wrong with the scene, in the order of its keys.
pub fn resolve(
    scene: &Scene,
    header: &VolumeHeader,
    labels: Option<&LabelHeader>,
) -> Result<Plan, Problems> {
    resolve_with(
        scene,
        &Headers {
            labels: labels.cloned(),
            ..Headers::from(header.clone())
        },
    )
}

/// The plan that draws `scene` with data of these headers.
///
/// # Errors
/// Everything that is wrong with the scene, in the order of its keys.
///
/// # Panics
/// If there is no header of a volume.
pub fn resolve_with(scene: &Scene, headers: &Headers) -> Result<Plan, Problems> {
    let mut checker = Checker::default();
    let plan = plan_of(scene, headers, &mut checker);
    let plan = plan.and_then(|plan| with_segments(plan, scene, headers, &mut checker));
    Problems::none_of(in_order_of_keys(checker.problems))?;
    // Without one there is a problem.
    plan.ok_or_else(|| {
        Problems::one(Problem::new(
            "scene",
            "not complete",
            "a camera and a transfer function",
        ))
    })
}

impl Scene {
    /// What is wrong with how much the scene names: more volumes or masks than one picture can have. To be asked
    /// before they are read.
    ///
    /// # Errors
    /// Everything of which there is too much, in the order of the keys.
    pub fn check_counts(&self) -> Result<(), Problems> {
        let mut checker = Checker::default();
        let objects = self.objects.iter().flatten();
        check_volumes(1 + objects.filter(|o| o.is_volume()).count(), &mut checker);
        let clips = self.clips.iter().flatten();
        let masks = clips.filter(|clip| matches!(clip, Clip::Mask(_))).count();
        let (masks, counted) = match self.importance {
            Some(_) => (masks + 1, ", counting `importance`"),
            None => (masks, ""),
        };
        if masks > MOST_MASKS {
            checker.add(
                "clips",
                format!("{masks} masks{counted}"),
                &format!(
                    "at most {MOST_MASKS} masks in one picture; one mask can have several labels"
                ),
            );
        }
        Problems::none_of(in_order_of_keys(checker.problems))
    }
}

/// The problems in the order in which a scene lists its keys, and a list its items.
fn in_order_of_keys(mut problems: Vec<Problem>) -> Vec<Problem> {
    let keys = crate::parse::keys();
    problems.sort_by_key(|problem| {
        let (key, rest) = match problem.path.find(['.', '[']) {
            Some(end) => problem.path.split_at(end),
            None => (problem.path.as_str(), ""),
        };
        let place = keys.iter().position(|known| *known == key);
        let item = rest.strip_prefix('[').and_then(|rest| rest.split_once(']'));
        let item: usize = item.map_or(0, |(item, _)| item.parse().unwrap_or(0));
        (place.unwrap_or(keys.len()), item)
    });
    problems
}
