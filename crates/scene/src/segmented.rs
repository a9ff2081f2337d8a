//! Scenes with labels: the Plan of a volume → that of its segments.

use crate::illustration;
use crate::places::check_labels;
use crate::plan::{
    Composite, GlobalRule, GradientInput, Illustrate, MOST_GROUPS, Plan, PlanLight, Sampling,
    Segments, Shade, Technique,
};
use crate::planning::{place_depths, plan_lights, plan_of};
use crate::problem::Checker;
use crate::settled::SettledScene;
use crate::{
    Color, Gradient, GradientInput as SceneInput, Headers, LabelHeader, Method, PresetInfo, Scene,
    SegmentComposite, SegmentTechnique, SegmentUse, Shading, ShadingModel, TransferFunction,
    TransferPoint, segment_looks, technique,
};
use std::collections::BTreeMap;
use strahl_volume::Grid;

/// `plan` with the segments of the scene's labels, if it has some.
pub(crate) fn with_segments(
    mut plan: Plan,
    scene: &Scene,
    headers: &Headers,
    checker: &mut Checker,
) -> Option<Plan> {
    let (techniques, uses, composite) = merged(scene);
    let (techniques, uses) = (&techniques, &uses[..]);
    segment_looks::check(
        scene.segments.as_deref().unwrap_or(&[]),
        techniques,
        checker,
    );
    let Some(labels) = &headers.labels else {
        return Some(plan);
    };
    if uses.len().saturating_mul(labels.ids.len()) > MOST_PAIRS {
        checker.add(
            "segments",
            format!("{} entries for {} segments", uses.len(), labels.ids.len()),
            &format!("fewer entries: entries times segments are at most {MOST_PAIRS}"),
        );
        return None;
    }
    let grid = label_grid(labels, &plan, headers, checker)?;
    check_beside_segments(&plan, scene, checker);
    let own = plan.techniques.swap_remove(0);
    plan.techniques.clear();
    let mut numbers = BTreeMap::new();
    for name in segment_looks::techniques_of(uses, techniques, labels) {
        let drawn = match name.as_str() {
            technique::SCENE => Some((own.clone(), false)),
            name => {
                let solid = SegmentTechnique::default();
                // One that there is not is a problem already.
                let said = techniques
                    .get(name)
                    .or((name == technique::SOLID).then_some(&solid));
                said.and_then(|said| {
                    let technique = planned(said, name, scene, headers, checker)?;
                    Some((technique, !said.has_colors()))
                })
            }
        };
        let Some((technique, is_colored)) = drawn else {
            continue;
        };
        numbers.insert(name, (plan.techniques.len(), is_colored));
        plan.techniques.push(technique);
    }
    if plan.techniques.is_empty() {
        plan.techniques.push(own);
    }
    let is_lit = plan
        .techniques
        .iter()
        .any(|t| matches!(t.shade, Shade::Lit { .. }));
    if is_lit && plan.lights.is_empty() && scene.lights.is_none() {
        plan.lights = default_lights(scene, headers, &plan);
    }
    let of_scene = plan.global_rule;
    let rule = |composite| rule_of(composite, of_scene);
    let composite = composite.unwrap_or(SegmentComposite::EmissionAbsorption);
    plan.global_rule = rule_of(composite, of_scene);
    let compositing = plan.compositing;
    let number = |name: &str| numbers.get(name).copied();
    let all = (uses, techniques);
    let labeled = segment_looks::plan(all, labels, grid, compositing, number, rule);
    if labeled.groups.len() > MOST_GROUPS {
        let number = labeled.groups.len();
        checker.add(
            "segments",
            format!("drawn in {number} groups of two-level techniques"),
            &format!(
                "at most {MOST_GROUPS} groups; segments with the same technique, opacity and importance are one group"
            ),
        );
    }
    plan.layers[0].segments = Segments::Labeled(Box::new(labeled));
    // Techniques do not know the camera.
    place_depths(&mut plan);
    let depths = illustration::depths_mm(&plan);
    for (name, (number, _)) in &numbers {
        let functions = match name.as_str() {
            technique::SCENE => scene.functions.as_ref(),
            name => techniques
                .get(name)
                .and_then(|said| said.functions.as_ref()),
        };
        let none = BTreeMap::new();
        let technique = &mut plan.techniques[*number];
        illustration::fit_to_depths(technique, functions.unwrap_or(&none), depths);
    }
    Some(plan)
}

/// What a composite is in the Plan; `plain` is emission and absorption.
fn rule_of(composite: SegmentComposite, plain: GlobalRule) -> GlobalRule {
    match composite {
        SegmentComposite::EmissionAbsorption => plain,
        SegmentComposite::Mip => GlobalRule::Mip,
        SegmentComposite::Average => GlobalRule::Average,
        SegmentComposite::First => GlobalRule::First,
        SegmentComposite::ImportanceAware => GlobalRule::ImportanceAware,
    }
}

/// The techniques of the preset and those of the scene; the uses of the preset, then those of the scene, which count more; how
/// runs become a pixel.
fn merged(
    scene: &Scene,
) -> (
    BTreeMap<String, SegmentTechnique>,
    Vec<SegmentUse>,
    Option<SegmentComposite>,
) {
    let preset = scene.preset.as_deref().and_then(PresetInfo::find);
    let preset = preset.map(PresetInfo::scene).unwrap_or_default();
    let mut techniques = preset.techniques.unwrap_or_default();
    techniques.extend(scene.techniques.clone().unwrap_or_default());
    for technique in techniques.values_mut() {
        technique.segments = technique
            .segments
            .as_deref()
            .map(|uses| with_members(uses, scene));
    }
    let mut uses = preset.segments.unwrap_or_default();
    uses.extend(scene.segments.clone().unwrap_or_default());
    let composite = scene.composite.or(preset.composite);
    (techniques, with_members(&uses, scene), composite)
}

fn with_members(uses: &[SegmentUse], scene: &Scene) -> Vec<SegmentUse> {
    let source = scene.labels.clone().unwrap_or_default();
    source.with_members(uses)
}

/// The most entries of `segments` times ids: each is asked about each.
const MOST_PAIRS: usize = 100_000_000;

/// What a person should know who has the segments of `labels` drawn by `scene`.
pub fn segment_notes(scene: &Scene, labels: &LabelHeader) -> Vec<String> {
    let (techniques, ..) = merged(scene);
    let uses = scene.segments.as_deref().unwrap_or(&[]);
    if uses.len().saturating_mul(labels.ids.len()) > MOST_PAIRS {
        // Refused as soon as a Plan is made.
        return Vec::new();
    }
    segment_looks::notes(&with_members(uses, scene), &techniques, labels)
}

/// The names of the techniques that draw a segment of `labels`, in the order in which the Plan of the scene has them.
pub(crate) fn technique_names(scene: &Scene, labels: &LabelHeader) -> Vec<String> {
    let (techniques, uses, _) = merged(scene);
    segment_looks::techniques_of(&uses, &techniques, labels)
}

/// The names of the two-level techniques that draw a segment of `labels`.
pub(crate) fn two_level_names(scene: &Scene, labels: &LabelHeader) -> Vec<String> {
    let (techniques, uses, _) = merged(scene);
    segment_looks::two_level_of(&uses, &techniques, labels)
}

/// The lights of a scene that is lit by nothing but its segments.
fn default_lights(scene: &Scene, headers: &Headers, plan: &Plan) -> Vec<PlanLight> {
    let lit = Scene {
        shading: Some(Shading {
            model: Some(ShadingModel::Lambert),
            ..Shading::default()
        }),
        ..scene.clone()
    };
    let mut unheard = Checker::default();
    let settled = SettledScene::new(&lit, headers, &mut unheard);
    plan_lights(
        &settled,
        &headers.volumes[0],
        true,
        Some(&plan.camera),
        plan.compositing,
        &mut unheard,
    )
}

/// Where the labels lie: they move with the volume.
fn label_grid(
    labels: &LabelHeader,
    plan: &Plan,
    headers: &Headers,
    checker: &mut Checker,
) -> Option<Grid> {
    let (volume, field) = (&headers.drawn(0).grid, plan.field());
    if !field.is_moved {
        return check_labels(volume, &labels.grid, checker).then_some(labels.grid);
    }
    check_labels(volume, &labels.grid, checker);
    let moved = field.grid.world_from_voxel() * volume.voxel_from_world();
    Grid::new(labels.grid.dims(), moved * labels.grid.world_from_voxel()).ok()
}

/// What segments do not go together with.
fn check_beside_segments(plan: &Plan, scene: &Scene, checker: &mut Checker) {
    if plan.layers.len() > 1 {
        checker.add(
            "objects",
            "volumes beside segments of labels",
            "meshes and groups only, or no `labels`",
        );
    }
    if plan.sampling != Sampling::Regular {
        checker.add(
            "sampling",
            format!("{:?} with segments of labels", plan.sampling.name()),
            "\"regular\", or no `labels`",
        );
    }
    if scene.debug.is_some() {
        checker.add(
            "debug",
            "set with segments of labels",
            "nothing, or no `labels`",
        );
    }
    for (slot, function) in scene.functions.iter().flatten() {
        if function.is_file() && OF_SAMPLES.contains(&slot.as_str()) {
            checker.add(
                format!("functions.{slot}.module"),
                format!("{:?} with segments of labels", function.module),
                "a function of the library, or no `labels`",
            );
        }
    }
}

/// Slots whose functions a technique chooses; that of a file would take the place of all.
const OF_SAMPLES: [&str; 4] = ["classify", "shade", "illustrate", "composite"];

/// Tells a technique whose gradient is that of membership how steep that is at a flat border, where it would else be told
/// how steep values are; unless `said` says so.
fn measure_by_membership(technique: &mut Technique, said: &SegmentTechnique, steep_per_mm: f64) {
    let steep_per_mm = steep_per_mm as f32;
    let of_composite = said.functions.as_ref().and_then(|all| all.get("composite"));
    let is_said = of_composite.is_some_and(|used| used.params.contains_key("full_per_mm"));
    match &mut technique.composite {
        Composite::ContextPreserving { full_per_mm, .. }
        | Composite::ImportanceAware { full_per_mm, .. }
            if !is_said =>
        {
            *full_per_mm = steep_per_mm;
        }
        _ => {}
    }
    let of_illustration = said
        .functions
        .as_ref()
        .and_then(|all| all.get("illustrate"));
    let is_said = of_illustration.is_some_and(|used| used.params.contains_key("full_per_mm"));
    if let (Illustrate::Silhouette { full_per_mm, .. }, false) =
        (&mut technique.illustrate, is_said)
    {
        *full_per_mm = steep_per_mm;
    }
    let is_said = said
        .shading
        .is_some_and(|shading| shading.full_per_mm.is_some());
    if let (Shade::GradientOpacity { full_per_mm }, false) = (&mut technique.shade, is_said) {
        *full_per_mm = steep_per_mm;
    }
}

/// The slots whose functions belong to a technique.
const SLOTS_OF_TECHNIQUES: [&str; 6] = [
    "classify",
    "gradient_input",
    "illuminate",
    "shade",
    "illustrate",
    "composite",
];

/// The technique called `name` of `scene`; what is wrong stands under its keys.
fn planned(
    said: &SegmentTechnique,
    name: &str,
    scene: &Scene,
    headers: &Headers,
    checker: &mut Checker,
) -> Option<Technique> {
    for slot in said.functions.iter().flat_map(BTreeMap::keys) {
        if !SLOTS_OF_TECHNIQUES.contains(&slot.as_str()) {
            let allowed = format!(
                "{}; other functions are those of the scene",
                SLOTS_OF_TECHNIQUES.join(", ")
            );
            let path = format!("techniques.{name}.functions.{slot}");
            checker.add(path, "given for a technique", &allowed);
        }
    }
    let mut own = Checker::default();
    let plan = plan_of(&scene_of(said, scene), headers, &mut own);
    let keys = [
        "preset",
        "method",
        "threshold",
        "blend",
        "transfer_function",
        "shading",
        "gradient",
        "functions",
    ];
    let before = checker.problems.len();
    for mut problem in own.problems {
        let key = problem.path.split(['.', '[']).next().unwrap_or_default();
        // The others are those of the scene.
        if keys.contains(&key) {
            let path = problem.path.replacen("gradient.of", "gradient_of", 1);
            problem.path = format!("techniques.{name}.{path}");
            checker.problems.push(problem);
        }
    }
    let plan = plan?;
    let spacing_mm = plan.field().grid.mean_spacing_mm();
    let mut technique = plan.techniques.into_iter().next()?;
    if technique.gradient_input == GradientInput::Segment {
        measure_by_membership(&mut technique, said, 1.5 / spacing_mm);
    }
    if !technique.composite.is_local() {
        let local: Vec<_> = Method::ALL
            .into_iter()
            .filter(|m| m.is_local())
            .map(Method::name)
            .collect();
        let word = technique.composite.function().word;
        checker.add(
            format!("techniques.{name}.method"),
            format!("{word:?}, which makes no sample of a run"),
            &local.join(", "),
        );
    }
    (checker.problems.len() == before).then_some(technique)
}

/// A scene of one volume that is drawn by `technique`, with what it has of `scene`.
fn scene_of(technique: &SegmentTechnique, scene: &Scene) -> Scene {
    let is_projection = technique.method.is_some_and(Method::is_projection);
    let solid = || TransferFunction {
        points: Some(vec![TransferPoint::new(0.0, 0.95, Color::WHITE)]),
        ..TransferFunction::default()
    };
    let (transfer_function, of) = match technique.has_colors() || is_projection {
        true => (technique.transfer_function.clone(), SceneInput::Value),
        false => (Some(solid()), SceneInput::Segment),
    };
    let method = match &technique.preset {
        Some(_) => technique.method,
        None => Some(technique.method.unwrap_or(Method::EmissionAbsorption)),
    };
    Scene {
        preset: technique.preset.clone(),
        method,
        threshold: technique.threshold,
        blend: technique.blend,
        transfer_function,
        shading: technique.shading,
        gradient: Some(Gradient {
            of: Some(technique.gradient_of.unwrap_or(of)),
            method: None,
        }),
        functions: technique.functions.clone(),
        importance: scene.importance.clone(),
        transform: scene.transform,
        early_termination: scene.early_termination,
        compositing: scene.compositing,
        step_mm: scene.step_mm,
        step_voxels: scene.step_voxels,
        ..Scene::default()
    }
}
