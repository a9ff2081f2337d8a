//! Keys of a scene that change nothing of its picture.
//!
//! What a picture reads follows from the texts of the functions that draw it: which functions they call, and what those
//! call. A key has an effect if something reads it.

mod reads;

use crate::plan::{Classify, Composite, GlobalRule, Jitter, Plan, Shade};
use crate::resolve::resolve_with;
use crate::segmented::{technique_names, two_level_names};
use crate::technique::{SCENE, SegmentTechnique};
use crate::{
    Clip, FunctionUse, Headers, Method, Scene, SegmentComposite, Shading, TransferFunction,
};
use reads::Reads;
use std::collections::BTreeMap;
use strahl_shader::SLOTS;

/// A key that changes nothing of the picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WithoutEffect {
    /// Its path, such as `shading.shininess`.
    pub key: String,
    /// Why that is so.
    pub why: String,
}

impl std::fmt::Display for WithoutEffect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} changes nothing: {}", self.key, self.why)
    }
}

/// The keys that `scene` sets and that change nothing of the picture that `plan` draws, which was resolved from it with
/// these headers. Of a scene with a graph none is known, nor of what functions of files call.
pub fn keys_without_effect(scene: &Scene, plan: &Plan, headers: &Headers) -> Vec<WithoutEffect> {
    let mut found = Vec::new();
    if scene.graph.is_some() {
        return found;
    }
    let all: Vec<Reads> = plan
        .drawn_techniques()
        .map(|technique| Reads::new(plan, technique))
        .collect();
    if all.is_empty() {
        return found;
    }
    let mut keys = Keys {
        found: &mut found,
        path: String::new(),
    };
    of_samples(scene, plan, &all, &mut keys);
    of_clips(scene, &mut keys);
    keys.unless(
        scene.importance.is_none() || plan.reads_importance(),
        "importance",
        "neither a drawn technique nor `composite` uses importance by place",
    );
    let is_lit = all.iter().any(|reads| reads.calls("lighting"));
    let has_light = !plan.meshes.is_empty() || is_lit;
    keys.unless(
        scene.lights.is_none() || has_light,
        "lights",
        "nothing is lit",
    );
    // A method chooses a preset where none is set.
    let chooses_preset = || {
        let without = Scene {
            method: None,
            ..scene.clone()
        };
        !resolve_with(&without, headers).is_ok_and(|other| other == *plan)
    };
    let of_scene = || {
        let mut of = OfTechnique::of_scene(scene);
        let is_beside_another = scene
            .functions
            .as_ref()
            .is_some_and(|functions| functions.contains_key("composite"));
        if is_beside_another && of.method.is_some() && chooses_preset() {
            of.method = None;
        }
        of
    };
    match (&headers.labels, plan.labeled()) {
        (Some(labels), Some(_)) => {
            let names = technique_names(scene, labels);
            of_segments(scene, plan, &of_scene(), &names, &all, &mut keys);
            if !names.iter().any(|name| name == SCENE) {
                of_unused_looks(scene, plan, headers, &mut keys);
            }
            of_two_level(scene, &two_level_names(scene, labels), &mut keys);
        }
        _ => {
            of_composite(&of_scene(), &all[0], &mut keys);
            of_gradient_input(scene, &all, &mut keys);
            of_functions(scene.functions.as_ref(), plan, &all, &mut keys);
            of_layers(scene, plan, &all, &mut keys);
        }
    }
    found
}

/// The notes in the making.
struct Keys<'k> {
    found: &'k mut Vec<WithoutEffect>,
    /// In front of the keys, with a dot.
    path: String,
}

impl Keys<'_> {
    fn unless(&mut self, has_effect: bool, key: &str, why: impl Into<String>) {
        if !has_effect {
            self.found.push(WithoutEffect {
                key: format!("{}{key}", self.path),
                why: why.into(),
            });
        }
    }
}

/// Keys of a technique, whether it is that of a scene or one of a segment.
struct OfTechnique<'k> {
    method: Option<Method>,
    threshold: Option<f64>,
    blend: Option<f64>,
    grey_range: Option<[f64; 2]>,
    functions: Option<&'k BTreeMap<String, FunctionUse>>,
}

impl<'k> OfTechnique<'k> {
    fn of_scene(scene: &'k Scene) -> OfTechnique<'k> {
        OfTechnique {
            method: scene.method,
            threshold: scene.threshold,
            blend: scene.blend,
            grey_range: scene.grey_range,
            functions: scene.functions.as_ref(),
        }
    }

    fn of_segment(technique: &'k SegmentTechnique) -> OfTechnique<'k> {
        OfTechnique {
            method: technique.method,
            threshold: technique.threshold,
            blend: technique.blend,
            grey_range: None,
            functions: technique.functions.as_ref(),
        }
    }
}

/// Keys that are parameters of the composite.
fn of_composite(of: &OfTechnique, reads: &Reads, keys: &mut Keys) {
    let function = reads.technique.composite.function();
    let chosen = of
        .functions
        .and_then(|functions| functions.get("composite"));
    if let Some(chosen) = chosen {
        let why = format!("functions.composite is {:?}", chosen.module);
        keys.unless(of.method.is_none(), "method", why);
    }
    let has = |parameters: &[&str]| {
        let has = |name: &&str| function.parameter(name).is_some();
        reads.is_open || (chosen.is_none() && parameters.iter().any(has))
    };
    let grey = ["white", "white_per_mm", "near_mm", "far_mm"];
    for (is_set, key, parameters) in [
        (of.threshold.is_some(), "threshold", &["threshold"][..]),
        (of.grey_range.is_some(), "grey_range", &grey),
        (of.blend.is_some(), "blend", &["blend"]),
    ] {
        let why = match key {
            "threshold" => format!(
                "the method is {}; only first-hit draws a surface at a threshold",
                function.word
            ),
            _ => format!("{} does not use it", function.word),
        };
        keys.unless(!is_set || has(parameters), key, why);
    }
}

/// Keys of the ray and of what is read at its samples, which all techniques share.
fn of_samples(scene: &Scene, plan: &Plan, all: &[Reads], keys: &mut Keys) {
    let word = all[0].composite();
    let any = |reads: &dyn Fn(&Reads) -> bool| all.iter().any(reads);
    if scene.reconstruct.is_some() {
        let why = match all[0].technique.classify {
            Classify::PreClassified => "voxels are classified before they are interpolated".into(),
            _ => format!("{word} reads no values"),
        };
        keys.unless(any(&|reads| reads.reads_values()), "reconstruct", why);
    }
    if scene
        .gradient
        .is_some_and(|gradient| gradient.method.is_some())
    {
        let has_gradient = any(&|reads| reads.reads_gradient());
        keys.unless(has_gradient, "gradient.method", NO_GRADIENT);
    }
    if scene.early_termination.is_some() {
        let ends = |reads: &Reads| {
            let function = reads.technique.composite.function();
            let is_chosen = scene
                .functions
                .as_ref()
                .is_some_and(|f| f.contains_key("composite"));
            let has = function.parameter("stop_at_transmittance").is_some();
            reads.is_open || (has && (!is_chosen || plan.labeled().is_some()))
        };
        let of_runs = plan.labeled().is_some()
            && matches!(plan.global_rule, GlobalRule::EmissionAbsorption { .. });
        let why = format!("{word} does not use it");
        keys.unless(of_runs || any(&ends), "early_termination", why);
    }
    let averages = scene.frames.is_some_and(|frames| frames > 1);
    let is_jittered = plan.lattice.jitter != Jitter::Center;
    keys.unless(
        !averages || is_jittered,
        "frames",
        "without jitter they are all the same",
    );
}

const NO_GRADIENT: &str = "no gradient is needed: no light, and no opacity that depends on it";

fn of_gradient_input(scene: &Scene, all: &[Reads], keys: &mut Keys) {
    if scene.gradient.is_some_and(|gradient| gradient.of.is_some()) {
        let has_gradient = all.iter().any(|reads| reads.reads_gradient());
        keys.unless(has_gradient, "gradient.of", NO_GRADIENT);
    }
}

/// Functions of slots that nobody calls.
fn of_functions(
    functions: Option<&BTreeMap<String, FunctionUse>>,
    plan: &Plan,
    all: &[Reads],
    keys: &mut Keys,
) {
    for (slot, function) in functions.into_iter().flatten() {
        let is_always_called = matches!(
            slot.as_str(),
            "composite" | "clip_ray" | "clip_sample" | "jitter" | "fetch" | "light"
        );
        let is_known = SLOTS.iter().any(|known| known.name == slot);
        let is_called = all.iter().any(|reads| {
            // A function of a file is open itself; whether its slot is called is not.
            let only = plan.modules.len() == 1 && function.is_file();
            match slot.as_str() {
                "reconstruct" => reads.reads_values(),
                slot if only => reads.called.contains(slot),
                slot => reads.calls(slot),
            }
        });
        keys.unless(
            is_always_called || !is_known || is_called,
            &format!("functions.{slot}"),
            format!("{} calls no such function", all[0].composite()),
        );
    }
}

/// Why keys of the scene's own technique have no effect, and what has one.
const NOT_BY_SCENE: &str = "no segment is drawn by the technique \"scene\"; `segments` and \
    `techniques` say how segments are drawn, and so does a preset for segments, such as atlas";

/// Preset and method where the scene's own technique draws nothing. A preset may set the background or the lights all the
/// same, and a method chooses a preset: each has no effect if the Plan without it is the same.
fn of_unused_looks(scene: &Scene, plan: &Plan, headers: &Headers, keys: &mut Keys) {
    let preset = || Scene {
        preset: None,
        ..scene.clone()
    };
    let method = || Scene {
        method: None,
        ..scene.clone()
    };
    let is_same = |other: &Plan| other == plan;
    let changes = |without: Scene| !resolve_with(&without, headers).is_ok_and(|o| is_same(&o));
    // The background of the preset that a method chooses is not what it is set for.
    let changes_more = |without: Scene| {
        !resolve_with(&without, headers).is_ok_and(|mut other| {
            other.background = plan.background;
            other.display.background = plan.display.background;
            is_same(&other)
        })
    };
    let preset_counts = scene.preset.is_none() || changes(preset());
    keys.unless(preset_counts, "preset", NOT_BY_SCENE);
    let method_counts = scene.method.is_none() || changes_more(method());
    keys.unless(method_counts, "method", NOT_BY_SCENE);
}

/// Keys of segments, and those of the scene itself, which are the technique `scene`. `names` are those of the techniques
/// that draw a segment, in the order of `all`.
fn of_segments(
    scene: &Scene,
    plan: &Plan,
    of_scene: &OfTechnique,
    names: &[String],
    all: &[Reads],
    keys: &mut Keys,
) {
    let reads_of = |name: &str| {
        let number = names.iter().position(|drawn| drawn == name)?;
        all.get(number)
    };
    match reads_of(SCENE) {
        Some(reads) => {
            let own = std::slice::from_ref(reads);
            of_composite(of_scene, reads, keys);
            of_gradient_input(scene, own, keys);
            of_functions_of_segments(scene, plan, own, all, keys);
            if let Some(function) = &scene.transfer_function {
                of_transfer_function(function, reads, keys);
            }
            if let Some(shading) = &scene.shading {
                of_shading(shading, reads, keys);
            }
        }
        None => {
            for (is_set, key) in [
                (scene.threshold.is_some(), "threshold"),
                (scene.blend.is_some(), "blend"),
                (scene.grey_range.is_some(), "grey_range"),
                (scene.transfer_function.is_some(), "transfer_function"),
                (scene.shading.is_some(), "shading"),
                (
                    scene.gradient.is_some_and(|gradient| gradient.of.is_some()),
                    "gradient.of",
                ),
            ] {
                keys.unless(!is_set, key, NOT_BY_SCENE);
            }
            of_functions_of_segments(scene, plan, &[], all, keys);
        }
    }
    let techniques = scene.techniques.iter().flatten();
    for (name, technique) in techniques.filter(|(_, technique)| !technique.is_two_level()) {
        let Some(reads) = reads_of(name) else {
            keys.unless(
                false,
                &format!("techniques.{name}"),
                "no segment is drawn by it",
            );
            continue;
        };
        let own = std::slice::from_ref(reads);
        let mut keys = Keys {
            found: &mut *keys.found,
            path: format!("techniques.{name}."),
        };
        of_composite(&OfTechnique::of_segment(technique), reads, &mut keys);
        let has_gradient = technique.gradient_of.is_none() || reads.reads_gradient();
        keys.unless(has_gradient, "gradient_of", NO_GRADIENT);
        of_functions(technique.functions.as_ref(), plan, own, &mut keys);
        if let Some(function) = &technique.transfer_function {
            of_transfer_function(function, reads, &mut keys);
        }
        if let Some(shading) = &technique.shading {
            of_shading(shading, reads, &mut keys);
        }
    }
    let is_by_importance = plan.global_rule == GlobalRule::ImportanceAware;
    for (i, used) in scene.segments.iter().flatten().enumerate() {
        keys.unless(
            used.importance.is_none() || is_by_importance,
            &format!("segments[{i}].importance"),
            "composite is not importance-aware",
        );
    }
}

/// Keys of two-level techniques, of which those in `names` draw a segment.
fn of_two_level(scene: &Scene, names: &[String], keys: &mut Keys) {
    let techniques = scene.techniques.iter().flatten();
    for (name, technique) in techniques.filter(|(_, technique)| technique.is_two_level()) {
        let path = format!("techniques.{name}");
        let is_drawn = names.contains(name);
        keys.unless(is_drawn, &path, "no segment is drawn by it");
        if !is_drawn {
            continue;
        }
        for (is_set, key) in [
            (technique.preset.is_some(), "preset"),
            (technique.method.is_some(), "method"),
            (technique.threshold.is_some(), "threshold"),
            (technique.blend.is_some(), "blend"),
            (technique.transfer_function.is_some(), "transfer_function"),
            (technique.shading.is_some(), "shading"),
            (technique.gradient_of.is_some(), "gradient_of"),
            (technique.functions.is_some(), "functions"),
        ] {
            let why = "the technique is two-level: its segments have techniques of their own";
            keys.unless(!is_set, &format!("{path}.{key}"), why);
        }
        let by_importance = technique.composite == Some(SegmentComposite::ImportanceAware);
        for (i, used) in technique.uses().iter().enumerate() {
            keys.unless(
                used.importance.is_none() || by_importance,
                &format!("{path}.segments[{i}].importance"),
                "composite of the technique is not importance-aware",
            );
        }
    }
}

/// Functions of a scene with segments: those of the field belong to all techniques, the others to `own`.
fn of_functions_of_segments(
    scene: &Scene,
    plan: &Plan,
    own: &[Reads],
    all: &[Reads],
    keys: &mut Keys,
) {
    let of_field = ["fetch", "reconstruct", "gradient"];
    let of_technique = [
        "classify",
        "gradient_input",
        "illuminate",
        "shade",
        "illustrate",
        "composite",
    ];
    for (slot, function) in scene.functions.iter().flatten() {
        let is_own = of_technique.contains(&slot.as_str());
        if is_own && own.is_empty() && !function.is_file() {
            keys.unless(false, &format!("functions.{slot}"), NOT_BY_SCENE);
        } else if is_own || of_field.contains(&slot.as_str()) {
            let one = BTreeMap::from([(slot.clone(), function.clone())]);
            let reads = if is_own && !own.is_empty() { own } else { all };
            of_functions(Some(&one), plan, reads, keys);
        }
    }
}

fn of_clips(scene: &Scene, keys: &mut Keys) {
    for (i, clip) in scene.clips.iter().flatten().enumerate() {
        let (kind, objects) = match clip {
            Clip::Plane(clip) => ("plane", &clip.objects),
            Clip::Box(clip) => ("box", &clip.objects),
            Clip::Ellipsoid(clip) => ("ellipsoid", &clip.objects),
            Clip::Cylinder(clip) => ("cylinder", &clip.objects),
            Clip::Mask(clip) => ("mask", &clip.objects),
        };
        let cuts = objects.as_ref().is_none_or(|objects| !objects.is_empty());
        keys.unless(
            cuts,
            &format!("clips[{i}].{kind}"),
            "objects is empty: it cuts none",
        );
    }
}

/// Transfer functions and shading of the scene and of its objects.
fn of_layers(scene: &Scene, plan: &Plan, all: &[Reads], keys: &mut Keys) {
    let volumes = scene.objects.iter().flatten().enumerate();
    let objects: Vec<_> = volumes.filter(|(_, object)| object.is_volume()).collect();
    let own_shading = |reads: &Reads, shading: Option<Shading>, keys: &mut Keys| {
        if let Some(shading) = shading {
            of_shading(&shading, reads, keys);
        }
    };
    if let Some(function) = &scene.transfer_function {
        of_transfer_function(function, &all[0], keys);
    }
    // The scene's shading is that of every object without one.
    let inherits = std::iter::once(0).chain(
        objects
            .iter()
            .enumerate()
            .filter(|(_, (_, object))| object.shading.is_none())
            .map(|(layer, _)| layer + 1),
    );
    let mut of_scene = Vec::new();
    for (n, layer) in inherits.enumerate() {
        let Some(reads) = all.get(layer) else {
            continue;
        };
        let mut own = Vec::new();
        let mut keys = Keys {
            found: &mut own,
            path: String::new(),
        };
        own_shading(reads, scene.shading, &mut keys);
        match n {
            0 => of_scene = own,
            _ => of_scene.retain(|note| own.contains(note)),
        }
    }
    keys.found.extend(of_scene);
    for (layer, (i, object)) in objects.into_iter().enumerate() {
        let Some(reads) = all.get(layer + 1) else {
            continue;
        };
        let mut keys = Keys {
            found: &mut *keys.found,
            path: format!("objects[{i}]."),
        };
        if let Some(function) = &object.transfer_function {
            of_transfer_function(function, reads, &mut keys);
        }
        own_shading(reads, object.shading, &mut keys);
        let own = std::slice::from_ref(reads);
        of_functions(object.functions.as_ref(), plan, own, &mut keys);
    }
}

fn of_transfer_function(function: &TransferFunction, reads: &Reads, keys: &mut Keys) {
    let word = reads.composite();
    let (colors, opacities) = (reads.reads_colors(), reads.reads_opacities());
    let table = match reads.technique.classify {
        _ if colors || opacities => String::new(),
        Classify::Identity { .. } => "the value itself is shown as grey".to_owned(),
        _ => format!("{word} shows nothing of the transfer function"),
    };
    let of_key = |has_effect: bool, what: &str| match table.is_empty() {
        _ if has_effect => String::new(),
        true => format!("{word} shows no {what} of the transfer function"),
        false => table.clone(),
    };
    let points = function.points.as_deref().unwrap_or(&[]);
    let has_colors = points.iter().any(|point| point.color.is_some());
    let has_opacities = points.iter().any(|point| point.opacity.is_some());
    let by_points = (has_colors && colors) || (has_opacities && opacities);
    // The ends of the window are those of a map of colors or of a ramp of opacities.
    let by_window = colors || opacities || reads.reads_window();
    for (is_set, key, has_effect, what) in [
        (function.points.is_some(), "points", by_points, "points"),
        (
            function.regions.is_some(),
            "regions",
            colors || opacities,
            "regions",
        ),
        (function.window.is_some(), "window", by_window, "window"),
        (function.level.is_some(), "level", by_window, "window"),
        (function.color_map.is_some(), "color_map", colors, "colors"),
        (
            function.opacity.is_some(),
            "opacity",
            opacities,
            "opacities",
        ),
        (
            function.reference_mm.is_some(),
            "reference_mm",
            reads.reads_lengths(),
            "opacities of lengths",
        ),
        (
            function.reference_voxels.is_some(),
            "reference_voxels",
            reads.reads_lengths(),
            "opacities of lengths",
        ),
    ] {
        keys.unless(
            !is_set || has_effect,
            &format!("transfer_function.{key}"),
            of_key(has_effect, what),
        );
    }
}

fn of_shading(shading: &Shading, reads: &Reads, keys: &mut Keys) {
    let shades = reads.calls("shade");
    let technique = reads.technique;
    let is_surface = matches!(technique.composite, Composite::FirstHit { .. });
    let parameters: Vec<&str> = match technique.shade {
        _ if reads.is_open => return,
        _ if !shades => Vec::new(),
        Shade::Unlit => Vec::new(),
        // A surface is opaque, whatever the gradient makes of its opacity.
        Shade::GradientOpacity { .. } if is_surface => Vec::new(),
        Shade::GradientOpacity { .. } => vec!["full_per_mm"],
        Shade::Lit { illuminate, .. } => {
            let of_model = illuminate.function().parameters.iter().map(|p| &*p.name);
            of_model.chain(["ambient", "keep_last_normal"]).collect()
        }
    };
    let why = match technique.shade {
        _ if !shades => format!("{} shades nothing", reads.composite()),
        Shade::Unlit => "nothing is lit: the model is unlit".to_owned(),
        Shade::GradientOpacity { .. } if is_surface => "a first hit is opaque".to_owned(),
        Shade::GradientOpacity { .. } => "the model is gradient-opacity".to_owned(),
        Shade::Lit { illuminate, .. } => format!("the model is {}", illuminate.function().word),
    };
    for (is_set, key) in [
        (shading.ambient.is_some(), "ambient"),
        (shading.diffuse.is_some(), "diffuse"),
        (shading.specular.is_some(), "specular"),
        (shading.shininess.is_some(), "shininess"),
        (shading.roughness.is_some(), "roughness"),
        (shading.reflectance.is_some(), "reflectance"),
        (shading.keep_last_normal.is_some(), "keep_last_normal"),
        (shading.full_per_mm.is_some(), "full_per_mm"),
    ] {
        let has_effect = parameters.contains(&key);
        keys.unless(
            !is_set || has_effect,
            &format!("shading.{key}"),
            why.clone(),
        );
    }
    let model = shading.model.is_some();
    keys.unless(!model || shades, "shading.model", why);
}
