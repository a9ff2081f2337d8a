//! A scene of whole volumes, without what it says of segments → Plan.

use crate::clip::{ClipPlaces, PlanClips};
use crate::illustration;
use crate::plan::{
    Classify, Composite, Compositing as PlanCompositing, Fetch, Field, GlobalRule,
    GradientInput as PlanGradientInput, Illustrate, Jitter as PlanJitter, Lattice,
    MOST_EDGE_PIXELS, MOST_FRAMES, MOST_LAYERS, Plan, PlanCamera, PlanLight, PlanMesh, Shade,
    Technique,
};
use crate::problem::Checker;
use crate::settled::{FORMAT, SettledScene, SettledVolume};
use crate::transfer::TransferTable;
use crate::window::value_range;
use crate::{
    Background, Camera, Compositing, Headers, Jitter, PresetInfo, Scene, function, object, presets,
    sampling, transfer_function,
};
use strahl_shader::registry::mixing_rules;
use strahl_volume::VolumeHeader;

/// The plan that draws `scene` without its segments, unless something is too wrong.
pub(crate) fn plan_of(scene: &Scene, headers: &Headers, checker: &mut Checker) -> Option<Plan> {
    check_given(scene, checker);
    let settled = SettledScene::new(scene, headers, checker);
    plan(&settled, headers, checker)
}

fn plan(settled: &SettledScene, headers: &Headers, checker: &mut Checker) -> Option<Plan> {
    let size = settled.size;
    for (axis, pixels) in size.into_iter().enumerate() {
        if !(1..=MOST_EDGE_PIXELS).contains(&pixels) {
            let allowed = format!("1 to {MOST_EDGE_PIXELS}");
            checker.add(format!("size[{axis}]"), pixels, &allowed);
        }
    }
    if !(1..=MOST_FRAMES).contains(&settled.frames) {
        let allowed = format!("1 to {MOST_FRAMES}");
        checker.add("frames", settled.frames, &allowed);
    }
    if let Background::Color(color) = settled.background {
        crate::light::check_color("background", color, checker);
    }
    let compositing = match settled.compositing {
        Compositing::Linear => PlanCompositing::Linear,
        Compositing::Display => PlanCompositing::Display,
    };
    let header = &headers.volumes[0];
    let tables = plan_tables(settled, headers, compositing, checker);
    let method = settled.composite.method;
    let shade = settled.shading.plan("shading", method, checker);
    let own_shades = plan_shades(settled, checker);
    let camera = settled.camera.plan(&settled.framed, size, checker);
    let is_lit = |shade: &Shade| matches!(shade, Shade::Lit { .. });
    let any_lit = is_lit(&shade) || own_shades.iter().flatten().any(is_lit);
    let lights = plan_lights(
        settled,
        header,
        any_lit,
        camera.as_ref(),
        compositing,
        checker,
    );
    let clips = plan_clips(settled, headers, checker);
    let window = settled.volumes[0].function.window;
    let composite = settled.composite.plan(window, header, checker);
    let meshes = plan_meshes(settled, headers, compositing, checker);
    let lattice = plan_lattice(settled, checker);
    let sampling = settled.sampling.plan(checker);
    let mut display = settled.display.plan(checker);
    let mut background = settled.background.in_space(compositing);
    let [r, g, b, _] = settled.background.in_space(PlanCompositing::Linear);
    display.take_background(&mut background, [r, g, b]);
    let mut plan = Plan {
        width: size[0],
        height: size[1],
        camera: camera?,
        fields: Vec::new(),
        techniques: Vec::new(),
        layers: Vec::new(),
        global_rule: GlobalRule::EmissionAbsorption {
            stop_at_transmittance: settled.composite.early_termination as f32,
        },
        importance: None,
        meshes,
        lattice,
        sampling,
        lights: lights.clone(),
        ray_clips: clips.planes,
        sample_clips: clips.shapes,
        modules: Vec::new(),
        background,
        compositing,
        with_depth: false,
        display,
    };
    let classify = if settled.shows_values {
        let [black, white] = value_range(header);
        Classify::Identity { black, white }
    } else {
        Classify::Table
    };
    let gradient_input = settled.gradient.of.into();
    for (volume, table) in settled.volumes.iter().zip(tables?) {
        let of_regions = transfer_function::classify_of(&volume.function.regions);
        let technique = Technique {
            classify: of_regions.unwrap_or(classify),
            table,
            gradient_input,
            shade,
            illustrate: Illustrate::Plain,
            composite,
        };
        plan.add_layer(plan_field(settled, volume, headers), technique);
    }
    function::apply(&settled.functions, &headers.modules, &mut plan, checker);
    for (layer, (volume, shade)) in settled.volumes.iter().zip(own_shades).enumerate() {
        let number = plan.technique_number(layer);
        let technique = &mut plan.techniques[number];
        technique.shade = shade.unwrap_or(technique.shade);
        if let Some(object) = volume.place.object {
            function::apply_to_layer(object, &volume.functions, layer, &mut plan, checker);
        }
    }
    if plan.lights.is_empty() && plan.drawn_techniques().any(|t| is_lit(&t.shade)) {
        plan.lights = lights;
    }
    if let Some(importance) = &settled.importance {
        plan.importance = importance.plan(clips.masks, &plan, headers, checker);
    }
    illustration::fit(&mut plan, &settled.functions, settled.shading.full_per_mm);
    place_depths(&mut plan);
    check_together(&plan, checker);
    Some(plan)
}

/// Tells the techniques that ask for it how near to the start of the rays the fields begin, and how far they reach.
pub(crate) fn place_depths(plan: &mut Plan) {
    let (mut near, mut far) = (f64::INFINITY, 0.0f64);
    for field in plan.drawn_fields() {
        let [from, to] = plan.camera.depths_mm(&field.grid);
        (near, far) = (near.min(from), far.max(to));
    }
    for technique in &mut plan.techniques {
        if let Composite::ContextPreserving {
            nearest_mm,
            farthest_mm,
            ..
        } = &mut technique.composite
        {
            (*nearest_mm, *farthest_mm) = (near as f32, far.max(near + 1e-3) as f32);
        }
    }
}

/// What is wrong only in its combination.
fn check_together(plan: &Plan, checker: &mut Checker) {
    if plan.layers.len() > 1 && !plan.technique().composite.mixes_layers() {
        let key = match plan.technique().composite {
            Composite::Debug(_) => "debug",
            _ => "method",
        };
        checker.add(
            key,
            format!(
                "{:?}, which does not mix several volumes",
                plan.technique().composite.function().word
            ),
            &format!("{}; or one volume", mixing_rules()),
        );
    }
    let takes_opacity = |t: &Technique| t.gradient_input == PlanGradientInput::Opacity;
    let needs_gradient = |t: &Technique| {
        matches!(
            t.classify,
            Classify::GradientTable { .. } | Classify::ValueGradient { .. }
        )
    };
    // Of two techniques, too: in programs one's classification would call the other's.
    if plan.drawn_techniques().any(takes_opacity) && plan.drawn_techniques().any(needs_gradient) {
        checker.add(
            "gradient.of",
            "\"opacity\" with a transfer function that needs the gradient itself",
            "\"value\"",
        );
    }
    let of_segment = |t: &Technique| t.gradient_input == PlanGradientInput::Segment;
    if plan
        .drawn_techniques()
        .any(|t| of_segment(t) && needs_gradient(t))
    {
        checker.add(
            "gradient.of",
            "\"segment\" with a transfer function that needs the gradient of the value",
            "\"value\"",
        );
    }
    plan.check_importance(checker);
    sampling::check_together(plan, checker);
}

fn plan_lattice(settled: &SettledScene, checker: &mut Checker) -> Lattice {
    let spacings = settled.volumes.iter();
    let spacing_mm = spacings
        .map(|volume| volume.place.drawn.min_spacing_mm())
        .fold(f64::INFINITY, f64::min);
    Lattice {
        step_mm: settled.step.plan(&settled.framed, spacing_mm, checker),
        jitter: match settled.jitter {
            Jitter::Off => PlanJitter::Center,
            Jitter::Seed(seed) => PlanJitter::Hash(seed),
            Jitter::SineHash => PlanJitter::SineHash,
            Jitter::WhiteTile(seed) => PlanJitter::WhiteTile(seed),
            Jitter::BlueTile(seed) => PlanJitter::BlueTile(seed),
        },
        frames: settled.frames,
    }
}

/// What a volume that is drawn is as a field.
fn plan_field(settled: &SettledScene, volume: &SettledVolume, headers: &Headers) -> Field {
    let place = &volume.place;
    let stored = headers.drawn(place.volume);
    Field {
        volume: place.volume,
        grid: place.drawn,
        is_moved: place.drawn != stored.grid,
        rescale: stored.rescale,
        fetch: Fetch::Stored,
        reconstruct: settled.reconstruct.into(),
        gradient: settled.gradient.method.into(),
    }
}

/// How the volumes are shaded whose objects say so.
fn plan_shades(settled: &SettledScene, checker: &mut Checker) -> Vec<Option<Shade>> {
    let mut shade = |volume: &SettledVolume| {
        let path = format!("objects[{}].shading", volume.place.object?);
        let shading = volume.shading.as_ref()?;
        Some(shading.plan(&path, settled.composite.method, checker))
    };
    settled.volumes.iter().map(&mut shade).collect()
}

pub(crate) fn plan_lights(
    settled: &SettledScene,
    header: &VolumeHeader,
    is_lit: bool,
    camera: Option<&PlanCamera>,
    compositing: PlanCompositing,
    checker: &mut Checker,
) -> Vec<PlanLight> {
    if !is_lit && settled.meshes.is_empty() {
        return Vec::new();
    }
    // Lights of a scene whose camera is wrong are checked all the same.
    let frame = camera.copied().or_else(|| {
        let mut unheard = Checker::default();
        Camera::default()
            .settled(header, &settled.framed, [1, 1], &mut unheard)
            .plan(&settled.framed, [1, 1], &mut unheard)
    });
    let Some(frame) = frame else {
        return Vec::new();
    };
    let lights = settled.lights.iter().enumerate();
    lights
        .filter_map(|(i, light)| light.plan(&format!("lights[{i}]"), &frame, compositing, checker))
        .collect()
}

fn plan_clips(settled: &SettledScene, headers: &Headers, checker: &mut Checker) -> PlanClips {
    let mut clips = PlanClips::default();
    let volumes = settled.volumes.iter();
    let places = ClipPlaces {
        frames: &settled.clip_frames,
        masks: &headers.masks,
        names: volumes.map(|volume| volume.place.name.as_deref()).collect(),
    };
    for (i, clip) in settled.clips.iter().enumerate() {
        clip.plan(&format!("clips[{i}]"), &places, checker, &mut clips);
    }
    clips
}

/// Whether as many volumes can be in one picture.
pub(crate) fn check_volumes(number: usize, checker: &mut Checker) -> bool {
    if number > MOST_LAYERS {
        checker.add(
            "objects",
            format!("{number} volumes"),
            &format!("at most {MOST_LAYERS} volumes in one picture"),
        );
    }
    number <= MOST_LAYERS
}

/// The tables of the volumes that are drawn, in their order.
fn plan_tables(
    settled: &SettledScene,
    headers: &Headers,
    compositing: PlanCompositing,
    checker: &mut Checker,
) -> Option<Vec<TransferTable>> {
    if !check_volumes(settled.volumes.len(), checker) {
        return None;
    }
    let mut tables = Vec::new();
    for volume in &settled.volumes {
        let place = &volume.place;
        let header = VolumeHeader {
            grid: place.grid,
            ..headers.volumes[place.volume].clone()
        };
        let mut own = Checker::default();
        tables.push(volume.function.plan(&header, compositing, &mut own));
        checker
            .problems
            .extend(own.problems.into_iter().map(|mut problem| {
                if let Some(object) = place.object {
                    problem.path = format!("objects[{object}].{}", problem.path);
                }
                problem
            }));
    }
    tables.into_iter().collect()
}

fn plan_meshes(
    settled: &SettledScene,
    headers: &Headers,
    compositing: PlanCompositing,
    checker: &mut Checker,
) -> Vec<PlanMesh> {
    let mut meshes = Vec::new();
    for mesh in &settled.meshes {
        let place = &mesh.place;
        let object = place.object;
        crate::light::check_color(&format!("objects[{object}].color"), mesh.color, checker);
        if place.mesh >= headers.meshes.len() {
            checker.add(
                format!("objects[{object}].mesh"),
                format!("{:?}, which is not loaded", place.file),
                "a mesh that is handed over with the scene",
            );
        }
        meshes.push(PlanMesh {
            mesh: place.mesh,
            world_from_mesh: place.world_from_mesh,
            color: mesh.color.in_space(compositing),
        });
    }
    meshes
}

/// What can only be wrong in the scene as it was written.
fn check_given(scene: &Scene, checker: &mut Checker) {
    if let Some(format) = scene.format
        && format != FORMAT
    {
        checker.add(
            "format",
            format,
            &format!("{FORMAT}; a higher one needs a newer version of this program"),
        );
    }
    if let Some(volume) = &scene.volume {
        volume.check(&mut checker.problems);
    }
    if let Some(labels) = &scene.labels {
        labels.check(checker);
    }
    object::check(scene.objects.as_deref().unwrap_or(&[]), checker);
    if let Some(name) = &scene.preset
        && PresetInfo::find(name).is_none()
    {
        let names: Vec<_> = presets().iter().map(|preset| preset.name).collect();
        let known = names.join(", ");
        let allowed = match PresetInfo::nearest(name) {
            Some(near) => format!("{known}; did you mean {near:?}?"),
            None => known,
        };
        checker.add("preset", format!("{name:?}"), &allowed);
    }
}
