//! Scene + volume header → Plan, or every problem at once.

use crate::clip::{ClipPlaces, PlanClips};
use crate::object::{self, OWN_VOLUME, placements};
use crate::plan::{
    Classify, Composite, Compositing as PlanCompositing, DebugView as PlanDebugView, Fetch, Field,
    GradientInput as PlanGradientInput, GradientMethod as PlanGradientMethod, Illuminate,
    Jitter as PlanJitter, Lattice, MOST_LAYERS, Plan, PlanMesh, Reconstruct as PlanReconstruct,
    Shade, Technique,
};
use crate::problem::{Checker, Number, Within};
use crate::transfer::TransferTable;
use crate::window::otsu_threshold;
use crate::{
    Background, Color, Compositing, DebugView, Gradient, GradientInput, GradientMethod, Headers,
    Jitter, Light, Method, PresetInfo, Problem, Problems, Quality, Reconstruct, Scene, SceneObject,
    Shading, ShadingModel, function, presets, sampling,
};
use glam::{DAffine3, DMat3, DVec3};
use strahl_volume::{Grid, VolumeHeader};

/// The version of the scene format that this program reads and writes.
pub const FORMAT: u32 = 1;
/// Width and height of a picture that nobody gave a size.
const DEFAULT_SIZE: [u32; 2] = [1024, 1024];
const DEFAULT_STEP_VOXELS: f64 = 0.5;
const DEFAULT_EARLY_TERMINATION: f64 = 1.0 / 256.0;
/// Twice the samples of the longest ray through the largest cube of isotropic voxels at the default
/// step; a ray with more of them is a slip of the pen.
pub const MAX_SAMPLES_PER_RAY: f64 = 8_388_608.0;

/// [`settled_with`] for a scene of one volume.
pub fn settled(scene: &Scene, header: &VolumeHeader) -> Scene {
    settled_with(scene, &Headers::from(header.clone()))
}

/// `scene` with every default filled in: first from its preset (chosen from the volume if it names
/// none), then from `docs/scene.md`. What is wrong stays as it is: [`resolve`] reports it.
///
/// # Panics
/// If there is no header of a volume.
pub fn settled_with(scene: &Scene, headers: &Headers) -> Scene {
    let header = &headers.volumes[0];
    let preset = match &scene.preset {
        Some(name) => PresetInfo::find(name),
        None => Some(PresetInfo::automatic(scene.method, header)),
    };
    let from_preset = preset.map(PresetInfo::scene).unwrap_or_default();
    let method = scene
        .method
        .or(from_preset.method)
        .unwrap_or(Method::EmissionAbsorption);
    let quality = of_quality(scene.quality, method);
    let size = scene.size.unwrap_or(DEFAULT_SIZE);
    let transfer_function = scene.transfer_function.clone().unwrap_or_default();
    let transfer_function = match &from_preset.transfer_function {
        Some(preset) => transfer_function.over(preset),
        None => transfer_function,
    };
    let mut own_shading = scene.shading.unwrap_or_default();
    own_shading.model = own_shading
        .model
        .or(quality.shading.and_then(|shading| shading.model));
    let shading = settled_shading(
        method,
        own_shading,
        from_preset.shading.unwrap_or_default(),
        header,
    );
    let is_lit = shading.model.is_some_and(ShadingModel::is_lit);
    let has_mesh = scene.objects.iter().flatten().any(|o| o.mesh.is_some());
    let lights = scene.lights.clone().or_else(|| {
        (is_lit || has_mesh).then(|| from_preset.lights.unwrap_or_else(default_lights))
    });
    let debug = scene.debug.or(quality.debug);
    let mut unheard = Checker::default();
    let places = Places::new(scene, headers, &mut unheard);
    let gradient = scene.gradient.unwrap_or_default();
    let quality_gradient = quality.gradient.unwrap_or_default();
    Scene {
        format: scene.format.or(Some(FORMAT)),
        volume: scene.volume.clone(),
        transform: scene.transform,
        objects: scene
            .objects
            .as_ref()
            .map(|objects| settled_objects(objects, headers, method)),
        labels: scene.labels.clone(),
        preset: scene
            .preset
            .clone()
            .or(preset.map(|preset| preset.name.to_owned())),
        quality: scene.quality,
        method: Some(method),
        threshold: scene.threshold.or_else(|| {
            (method == Method::FirstHit)
                .then(|| from_preset.threshold.unwrap_or(automatic_threshold(header)))
        }),
        blend: scene.blend.or((method == Method::Mida).then_some(0.0)),
        debug,
        grey_range: scene
            .grey_range
            .or_else(|| automatic_grey_range(debug, method, header, &places.framed)),
        transfer_function: Some(transfer_function.settled(method, header)),
        shading: Some(shading),
        lights: lights.map(|lights| lights.into_iter().map(Light::settled).collect()),
        camera: Some(
            scene
                .camera
                .unwrap_or_default()
                .settled(&places.framed, size),
        ),
        clips: Some(
            scene
                .clips
                .iter()
                .flatten()
                .map(|clip| clip.clone().settled(&places.grids[0]))
                .collect(),
        ),
        reconstruct: scene
            .reconstruct
            .or(quality.reconstruct)
            .or(Some(Reconstruct::Trilinear)),
        gradient: Some(Gradient {
            method: gradient
                .method
                .or(quality_gradient.method)
                .or(Some(GradientMethod::Central)),
            of: gradient.of.or(Some(GradientInput::Value)),
        }),
        step_mm: scene.step_mm,
        step_voxels: scene
            .step_voxels
            .or(scene.step_mm.is_none().then_some(DEFAULT_STEP_VOXELS)),
        sampling: Some(scene.sampling.unwrap_or_default().settled()),
        jitter: scene.jitter.or(Some(Jitter::Off)),
        frames: scene.frames.or(Some(1)),
        functions: match (&scene.functions, quality.functions) {
            (Some(own), Some(of_quality)) => {
                let mut functions = of_quality;
                functions.extend(own.clone());
                Some(functions)
            }
            (own, of_quality) => own.clone().or(of_quality),
        },
        graph: scene.graph.clone(),
        early_termination: scene.early_termination.or(matches!(
            method,
            Method::EmissionAbsorption | Method::Mida
        )
        .then_some(DEFAULT_EARLY_TERMINATION)),
        compositing: scene.compositing.or(Some(Compositing::Linear)),
        background: scene
            .background
            .or(from_preset.background)
            .or(Some(Background::Color(Color::BLACK))),
        size: Some(size),
        display: Some(
            scene
                .display
                .unwrap_or_default()
                .settled(from_preset.display.unwrap_or_default()),
        ),
    }
}

/// What a level of quality decides.
fn of_quality(quality: Option<Quality>, method: Method) -> Scene {
    let shading = |model| {
        (!method.is_projection()).then_some(Shading {
            model: Some(model),
            ..Shading::default()
        })
    };
    match quality {
        None | Some(Quality::Medium) => Scene::default(),
        Some(Quality::Null) => Scene {
            debug: Some(DebugView::Entry),
            ..Scene::default()
        },
        Some(Quality::Minimum) => Scene {
            reconstruct: Some(Reconstruct::Nearest),
            shading: shading(ShadingModel::Unlit),
            ..Scene::default()
        },
        Some(Quality::Maximum) => Scene {
            reconstruct: Some(Reconstruct::BSplineInterpolating),
            gradient: Some(Gradient {
                method: Some(GradientMethod::Central9),
                of: None,
            }),
            shading: shading(ShadingModel::CookTorrance),
            ..Scene::default()
        },
    }
}

fn settled_objects(objects: &[SceneObject], headers: &Headers, method: Method) -> Vec<SceneObject> {
    let indices = volume_indices(objects);
    let settle = |(object, index): (&SceneObject, &Option<usize>)| {
        let mut object = object.clone();
        if object.mesh.is_some() {
            object.color.get_or_insert(MESH_COLOR);
        }
        if let Some(header) = index.and_then(|index| headers.volumes.get(index)) {
            let preset = match &object.preset {
                Some(name) => PresetInfo::find(name),
                None => Some(PresetInfo::automatic(Some(method), header)),
            };
            if object.preset.is_none() {
                object.preset = preset.map(|preset| preset.name.to_owned());
            }
            let own = object.transfer_function.unwrap_or_default();
            let from_preset = preset.map(PresetInfo::scene).unwrap_or_default();
            let function = match &from_preset.transfer_function {
                Some(preset) => own.over(preset),
                None => own,
            };
            object.transfer_function = Some(function.settled(method, header));
        }
        object
    };
    objects.iter().zip(&indices).map(settle).collect()
}

/// Which of the headers each object shows; `None` for meshes, groups and what cannot be found.
fn volume_indices(objects: &[SceneObject]) -> Vec<Option<usize>> {
    let mut next = 0;
    let own: Vec<_> = objects
        .iter()
        .map(|object| {
            object.volume.is_some().then(|| {
                next += 1;
                next
            })
        })
        .collect();
    let index = |(object, own): (&SceneObject, &Option<usize>)| match (own, &object.like) {
        (Some(own), _) => Some(*own),
        (None, Some(like)) if like == OWN_VOLUME => Some(0),
        (None, Some(like)) => own_named(objects, like).and_then(|i| {
            objects[..i]
                .iter()
                .filter(|o| o.volume.is_some())
                .count()
                .checked_add(1)
        }),
        (None, None) => None,
    };
    objects.iter().zip(&own).map(index).collect()
}

/// The object with a volume of its own that has this name.
fn own_named(objects: &[SceneObject], name: &str) -> Option<usize> {
    objects
        .iter()
        .position(|o| o.name.as_deref() == Some(name) && o.volume.is_some())
}

/// Where everything lies in the world.
struct Places {
    /// Of each volume that is drawn: the header, and the grid as it is placed.
    volumes: Vec<usize>,
    grids: Vec<Grid>,
    /// Their names.
    names: Vec<Option<String>>,
    /// Which object of the scene each is; `None` for its own volume.
    objects: Vec<Option<usize>>,
    meshes: Vec<(usize, DAffine3)>,
    /// The header of the scene's own volume, with a grid around everything: what the camera frames.
    framed: VolumeHeader,
}

impl Places {
    fn new(scene: &Scene, headers: &Headers, checker: &mut Checker) -> Places {
        let objects = scene.objects.as_deref().unwrap_or(&[]);
        let worlds = placements(scene.transform.as_ref(), objects, checker);
        let mut place = |grid: &Grid, world: DAffine3, path: &str| {
            if world == DAffine3::IDENTITY {
                return *grid;
            }
            Grid::new(grid.dims(), world * grid.world_from_voxel()).unwrap_or_else(|error| {
                checker.add(
                    path,
                    format!("a transform after which {error}"),
                    "a volume of a size that can be drawn",
                );
                *grid
            })
        };
        let own = &headers.volumes[0];
        let mut places = Places {
            volumes: vec![0],
            grids: vec![place(&own.grid, worlds[0], "transform")],
            names: vec![Some(OWN_VOLUME.to_owned())],
            objects: vec![None],
            meshes: Vec::new(),
            framed: own.clone(),
        };
        let mut mesh = 0;
        for (i, index) in volume_indices(objects).into_iter().enumerate() {
            if objects[i].mesh.is_some() {
                places.meshes.push((mesh, worlds[1 + i]));
                mesh += 1;
            }
            let Some(header) = index.and_then(|index| headers.volumes.get(index)) else {
                continue;
            };
            places.volumes.push(index.unwrap_or_default());
            let path = format!("objects[{i}].transform");
            places.grids.push(place(&header.grid, worlds[1 + i], &path));
            places.names.push(objects[i].name.clone());
            places.objects.push(Some(i));
        }
        places.framed.grid = places.around(headers);
        places
    }

    /// The grid of one volume, or a box around all.
    fn around(&self, headers: &Headers) -> Grid {
        if self.grids.len() == 1 && self.meshes.is_empty() {
            return self.grids[0];
        }
        let (mut lo, mut hi) = self.grids[0].bounds_mm();
        for grid in &self.grids {
            let (a, b) = grid.bounds_mm();
            (lo, hi) = (lo.min(a), hi.max(b));
        }
        for (mesh, world) in &self.meshes {
            let Some([a, b]) = headers.meshes.get(*mesh) else {
                continue;
            };
            for corner in 0..8 {
                let at = |axis: usize| {
                    if corner >> axis & 1 == 0 {
                        a[axis]
                    } else {
                        b[axis]
                    }
                };
                let corner = world.transform_point3(DVec3::new(at(0), at(1), at(2)));
                (lo, hi) = (lo.min(corner), hi.max(corner));
            }
        }
        let cube = DAffine3::from_mat3_translation(DMat3::from_diagonal(hi - lo), 0.5 * (lo + hi));
        Grid::new([1; 3], cube).unwrap_or(self.grids[0])
    }
}

/// What is black and what is white where a number is shown as grey.
fn automatic_grey_range(
    debug: Option<DebugView>,
    method: Method,
    header: &VolumeHeader,
    framed: &VolumeHeader,
) -> Option<[f64; 2]> {
    match debug {
        Some(DebugView::GradientMagnitude) => Some([0.0, steep_per_mm(header)]),
        Some(DebugView::SampleCount) => Some([0.0, 1000.0]),
        // From the near to the far side of what the camera frames, about its usual distance.
        Some(DebugView::Depth) => {
            let (lo, hi) = framed.grid.bounds_mm();
            Some([0.0, 4.0 * lo.distance(hi)])
        }
        Some(_) => None,
        None => (method == Method::Gmip).then(|| [0.0, steep_per_mm(header)]),
    }
}

/// A steep gradient: the whole window of values within two voxels.
fn steep_per_mm(header: &VolumeHeader) -> f64 {
    let [lo, hi] = header.statistics.range;
    let steep = 0.5 * (hi - lo) / header.grid.mean_spacing_mm();
    crate::window::round_to_width(steep, steep).clamp(1e-30, 1e30)
}

fn settled_shading(
    method: Method,
    own: Shading,
    preset: Shading,
    header: &VolumeHeader,
) -> Shading {
    let default = if method.is_projection() {
        ShadingModel::Unlit
    } else {
        preset.model.unwrap_or(ShadingModel::BlinnPhong)
    };
    let model = own.model.unwrap_or(default);
    let has_highlight = matches!(model, ShadingModel::Phong | ShadingModel::BlinnPhong);
    let is_rough = model == ShadingModel::CookTorrance;
    let number = |own: Option<f64>, there: bool, preset: Option<f64>, default: f64| {
        own.or(there.then(|| preset.unwrap_or(default)))
    };
    Shading {
        model: Some(model),
        ambient: number(own.ambient, model.is_lit(), preset.ambient, 0.25),
        diffuse: number(own.diffuse, model.is_lit(), preset.diffuse, 0.75),
        specular: number(own.specular, has_highlight, preset.specular, 0.2),
        shininess: number(own.shininess, has_highlight, preset.shininess, 24.0),
        roughness: number(own.roughness, is_rough, preset.roughness, 0.4),
        reflectance: number(own.reflectance, is_rough, preset.reflectance, 0.08),
        keep_last_normal: own.keep_last_normal.or(model
            .is_lit()
            .then(|| preset.keep_last_normal.unwrap_or(false))),
        full_per_mm: own.full_per_mm.or_else(|| {
            (model == ShadingModel::GradientOpacity)
                .then(|| preset.full_per_mm.unwrap_or(0.5 * steep_per_mm(header)))
        }),
    }
}

/// Plaster: light enough for its light to be seen.
const MESH_COLOR: Color = Color([0.8, 0.8, 0.8]);

/// A key light from the upper left and a weaker one at the eye, so that nothing is quite dark.
fn default_lights() -> Vec<Light> {
    vec![Light::from_camera(-35.0, 40.0, 0.8), Light::head(0.4)]
}

/// The surface that divides a volume best.
fn automatic_threshold(header: &VolumeHeader) -> f64 {
    crate::window::round_to_width(
        otsu_threshold(&header.statistics),
        header.statistics.range[1] - header.statistics.range[0],
    )
}

/// [`resolve_with`] for a scene of one volume. `labels` is the grid of the label volume, if one is
/// loaded.
///
/// # Errors
/// Everything that is wrong with the scene, in the order of its keys.
pub fn resolve(
    scene: &Scene,
    header: &VolumeHeader,
    labels: Option<&Grid>,
) -> Result<Plan, Problems> {
    resolve_with(
        scene,
        &Headers {
            labels: labels.copied(),
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
    check_given(scene, &mut checker);
    let header = &headers.volumes[0];
    let settled = settled_with(scene, headers);
    let places = Places::new(scene, headers, &mut checker);
    let grid = &places.grids[0];
    if let Some(labels) = &headers.labels {
        check_labels(&header.grid, labels, &mut checker);
    }

    let size = settled.size.unwrap_or(DEFAULT_SIZE);
    for (axis, pixels) in size.into_iter().enumerate() {
        if pixels == 0 || pixels > 65_535 {
            checker.add(format!("size[{axis}]"), pixels, "1 to 65535");
        }
    }
    let method = settled.method.unwrap_or(Method::EmissionAbsorption);
    if let Some(threshold) = settled.threshold {
        checker.number("threshold", threshold, Within::Closed(-1e30, 1e30));
    }
    let compositing = match settled.compositing.unwrap_or(Compositing::Linear) {
        Compositing::Linear => PlanCompositing::Linear,
        Compositing::Display => PlanCompositing::Display,
    };
    let tables = plan_tables(&settled, headers, &places, compositing, &mut checker);
    let shading = settled.shading.unwrap_or_default();
    let shade = plan_shade(method, shading, &mut checker);
    let camera = settled
        .camera
        .unwrap_or_default()
        .plan(&places.framed.grid, size, &mut checker);
    let mut lights = Vec::new();
    if matches!(shade, Shade::Lit { .. }) || !places.meshes.is_empty() {
        // Lights of a scene whose camera is wrong are checked all the same.
        let frame = camera.or_else(|| {
            crate::Camera::default()
                .settled(&places.framed, [1, 1])
                .plan(&places.framed.grid, [1, 1], &mut Checker::default())
        });
        for (i, light) in settled.lights.iter().flatten().enumerate() {
            if let Some(frame) = &frame {
                let path = format!("lights[{i}]");
                lights.extend(light.plan(&path, frame, compositing, &mut checker));
            }
        }
    }
    let mut clips = PlanClips::default();
    let clip_places = ClipPlaces {
        grid,
        masks: &headers.masks,
        names: &places.names,
    };
    for (i, clip) in settled.clips.iter().flatten().enumerate() {
        let path = format!("clips[{i}]");
        clip.plan(&path, &clip_places, &mut checker, &mut clips);
    }
    let spacing_mm = places
        .grids
        .iter()
        .map(Grid::min_spacing_mm)
        .fold(f64::INFINITY, f64::min);
    let step_mm = plan_step(&settled, &places.framed.grid, spacing_mm, &mut checker);
    let sampling = settled.sampling.unwrap_or_default().plan(&mut checker);
    let early = settled
        .early_termination
        .unwrap_or(DEFAULT_EARLY_TERMINATION);
    checker.number("early_termination", early, Within::Closed(0.0, 1.0));
    let frames = settled.frames.unwrap_or(1);
    if !(1..=65_536).contains(&frames) {
        checker.add("frames", frames, "1 to 65536");
    }
    let composite = plan_composite(&settled, headers, early, &mut checker);
    let background = settled
        .background
        .unwrap_or(Background::Color(Color::BLACK));
    if let Background::Color(color) = background {
        crate::light::check_color("background", color, &mut checker);
    }
    let meshes = plan_meshes(&settled, headers, &places, compositing, &mut checker);
    let display = settled.display.unwrap_or_default().plan(&mut checker);

    let (Some(tables), Some(camera)) = (tables, camera) else {
        // Both report a problem when they fail.
        Problems::none_of(checker.problems)?;
        return Err(Problems::one(Problem::new(
            "scene",
            "not complete",
            "a camera and a transfer function",
        )));
    };
    let mut plan = Plan {
        width: size[0],
        height: size[1],
        camera,
        fields: Vec::new(),
        techniques: Vec::new(),
        layers: Vec::new(),
        meshes,
        lattice: Lattice {
            step_mm,
            jitter: match settled.jitter.unwrap_or(Jitter::Off) {
                Jitter::Off => PlanJitter::Centre,
                Jitter::Seed(seed) => PlanJitter::Hash(seed),
                Jitter::SineHash => PlanJitter::SineHash,
                Jitter::WhiteTile(seed) => PlanJitter::WhiteTile(seed),
                Jitter::BlueTile(seed) => PlanJitter::BlueTile(seed),
            },
            frames,
        },
        sampling,
        lights,
        ray_clips: clips.planes,
        sample_clips: clips.shapes,
        modules: Vec::new(),
        background: background.in_space(compositing),
        compositing,
        with_depth: false,
        display,
    };
    let classify = if scene.quality == Some(Quality::Minimum) && !method.is_projection() {
        let [black, white] = identity_range(header);
        Classify::Identity { black, white }
    } else {
        Classify::Table
    };
    let gradient_input = plan_gradient_input(settled.gradient.unwrap_or_default());
    for (field, table) in plan_fields(&settled, headers, &places).zip(tables) {
        let technique = Technique {
            classify,
            table,
            gradient_input,
            shade,
            composite,
        };
        plan.add_layer(field, technique);
    }
    if let Some(functions) = &settled.functions {
        function::apply(functions, &headers.modules, &mut plan, &mut checker);
    }
    check_together(&plan, &mut checker);
    Problems::none_of(checker.problems)?;
    Ok(plan)
}

/// What is wrong only in its combination.
fn check_together(plan: &Plan, checker: &mut Checker) {
    if plan.layers.len() > 1 && !plan.technique().composite.mixes_layers() {
        checker.add(
            "method",
            "one that draws a single number per ray, with several volumes",
            "emission-absorption: values of different volumes cannot be compared; or one volume",
        );
    }
    if plan.technique().gradient_input == PlanGradientInput::Opacity
        && matches!(plan.technique().classify, Classify::GradientTable { .. })
    {
        checker.add(
            "gradient.of",
            "\"opacity\" with a transfer function that needs the gradient itself",
            "\"value\"",
        );
    }
    sampling::check_together(plan, checker);
}

/// Grey over all values: what is shown when nothing is classified.
fn identity_range(header: &VolumeHeader) -> [f32; 2] {
    let [lo, hi] = header.statistics.range.map(|v| v as f32);
    if lo < hi { [lo, hi] } else { [lo, lo + 1.0] }
}

fn plan_gradient_method(gradient: Gradient) -> PlanGradientMethod {
    match gradient.method.unwrap_or(GradientMethod::Central) {
        GradientMethod::Forward => PlanGradientMethod::Forward,
        GradientMethod::Backward => PlanGradientMethod::Backward,
        GradientMethod::Central => PlanGradientMethod::Central,
        GradientMethod::Central9 => PlanGradientMethod::Central9,
        GradientMethod::Sobel => PlanGradientMethod::Sobel,
        GradientMethod::BSpline => PlanGradientMethod::BSpline,
    }
}

fn plan_gradient_input(gradient: Gradient) -> PlanGradientInput {
    match gradient.of.unwrap_or(GradientInput::Value) {
        GradientInput::Value => PlanGradientInput::Value,
        GradientInput::Opacity => PlanGradientInput::Opacity,
    }
}

fn plan_reconstruct(reconstruct: Option<Reconstruct>) -> PlanReconstruct {
    match reconstruct.unwrap_or(Reconstruct::Trilinear) {
        Reconstruct::Nearest => PlanReconstruct::Nearest,
        Reconstruct::Trilinear => PlanReconstruct::Trilinear,
        Reconstruct::BSpline => PlanReconstruct::BSpline,
        Reconstruct::BSplineInterpolating => PlanReconstruct::BSplineInterpolating,
        Reconstruct::CatmullRom => PlanReconstruct::CatmullRom,
    }
}

/// What the volumes that are drawn are as fields, in their order.
fn plan_fields<'a>(
    settled: &Scene,
    headers: &'a Headers,
    places: &'a Places,
) -> impl Iterator<Item = Field> + use<'a> {
    let reconstruct = plan_reconstruct(settled.reconstruct);
    let gradient = plan_gradient_method(settled.gradient.unwrap_or_default());
    places
        .grids
        .iter()
        .zip(&places.volumes)
        .map(move |(grid, &volume)| {
            let header = &headers.volumes[volume];
            Field {
                volume,
                grid: *grid,
                is_moved: *grid != header.grid,
                rescale: header.rescale,
                fetch: Fetch::Stored,
                reconstruct,
                gradient,
            }
        })
}

/// The tables of the volumes that are drawn, in their order.
fn plan_tables(
    settled: &Scene,
    headers: &Headers,
    places: &Places,
    compositing: PlanCompositing,
    checker: &mut Checker,
) -> Option<Vec<TransferTable>> {
    if places.grids.len() > MOST_LAYERS {
        checker.add(
            "objects",
            format!("{} volumes", places.grids.len()),
            &format!("at most {MOST_LAYERS} volumes in one picture"),
        );
        return None;
    }
    let scene_objects = settled.objects.as_deref().unwrap_or(&[]);
    let mut tables = Vec::new();
    for (i, grid) in places.grids.iter().enumerate() {
        let header = VolumeHeader {
            grid: *grid,
            ..headers.volumes[places.volumes[i]].clone()
        };
        let mut own = Checker::default();
        let (function, path) = match places.objects[i] {
            None => (&settled.transfer_function, String::new()),
            Some(object) => (
                &scene_objects[object].transfer_function,
                format!("objects[{object}]."),
            ),
        };
        tables.push(
            function
                .as_ref()
                .and_then(|function| function.plan(&header, compositing, &mut own)),
        );
        checker
            .problems
            .extend(own.problems.into_iter().map(|mut problem| {
                problem.path = format!("{path}{}", problem.path);
                problem
            }));
    }
    tables.into_iter().collect()
}

fn plan_meshes(
    settled: &Scene,
    headers: &Headers,
    places: &Places,
    compositing: PlanCompositing,
    checker: &mut Checker,
) -> Vec<PlanMesh> {
    let objects = settled.objects.iter().flatten().enumerate();
    let of_meshes = objects.filter(|(_, object)| object.mesh.is_some());
    let mut meshes = Vec::new();
    for ((i, object), (mesh, world_from_mesh)) in of_meshes.zip(&places.meshes) {
        let color = object.color.unwrap_or(MESH_COLOR);
        crate::light::check_color(&format!("objects[{i}].color"), color, checker);
        if *mesh >= headers.meshes.len() {
            checker.add(
                format!("objects[{i}].mesh"),
                format!(
                    "{:?}, which is not loaded",
                    object.mesh.as_deref().unwrap_or_default()
                ),
                "a mesh that is handed over with the scene",
            );
        }
        meshes.push(PlanMesh {
            mesh: *mesh,
            world_from_mesh: *world_from_mesh,
            color: color.in_space(compositing),
        });
    }
    meshes
}

fn plan_composite(
    settled: &Scene,
    headers: &Headers,
    early: f64,
    checker: &mut Checker,
) -> Composite {
    let header = &headers.volumes[0];
    let method = settled.method.unwrap_or(Method::EmissionAbsorption);
    let [black, white] = settled.grey_range.unwrap_or([0.0, 1.0]);
    if settled.grey_range.is_some() {
        for (i, end) in [black, white].into_iter().enumerate() {
            checker.number(
                &format!("grey_range[{i}]"),
                end,
                Within::Closed(-1e30, 1e30),
            );
        }
        if black as f32 == white as f32 {
            checker.add(
                "grey_range",
                format!("{:?}", [black, white]),
                "two different numbers",
            );
        }
    }
    if let Some(blend) = settled.blend {
        checker.number("blend", blend, Within::Closed(-1.0, 0.0));
        if method != Method::Mida {
            checker.add(
                "blend",
                format!("given for method {:?}", method.name()),
                "nothing: it belongs to mida",
            );
        }
    }
    // Where only white is said, black is 0.
    let span = (white - black).abs().max(1e-30) as f32;
    if let Some(view) = settled.debug {
        return Composite::Debug(match view {
            DebugView::Entry => PlanDebugView::Entry,
            DebugView::Exit => PlanDebugView::Exit,
            DebugView::Normal => PlanDebugView::Normal,
            DebugView::GradientRaw => PlanDebugView::GradientRaw,
            DebugView::GradientMagnitude => PlanDebugView::GradientMagnitude { white_per_mm: span },
            DebugView::SampleCount => PlanDebugView::SampleCount { white: span },
            DebugView::Depth => PlanDebugView::Depth {
                near_mm: black as f32,
                far_mm: white as f32,
            },
        });
    }
    let stop_at_transmittance = early as f32;
    match method {
        Method::EmissionAbsorption => Composite::EmissionAbsorption {
            stop_at_transmittance,
        },
        Method::Mip => Composite::Mip,
        Method::Minip => Composite::MinIp,
        Method::Average => Composite::Average,
        Method::Gmip => Composite::Gmip { white_per_mm: span },
        Method::Mida => {
            let [low, high] = mida_range(settled, header);
            Composite::Mida {
                low,
                high,
                blend: settled.blend.unwrap_or(0.0) as f32,
                stop_at_transmittance,
            }
        }
        Method::FirstHit => Composite::FirstHit {
            threshold: settled.threshold.unwrap_or(automatic_threshold(header)),
        },
    }
}

/// What counts as 0 and as 1 when maxima are looked for: the window, or all values.
fn mida_range(settled: &Scene, header: &VolumeHeader) -> [f32; 2] {
    let function = settled.transfer_function.as_ref();
    let window = function.and_then(|f| Some((f.level?, f.window?)));
    match window {
        Some((level, window)) if window > 0.0 => {
            [(level - 0.5 * window) as f32, (level + 0.5 * window) as f32]
        }
        _ => identity_range(header),
    }
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
    object::check(scene.objects.as_deref().unwrap_or(&[]), checker);
    if let Some(name) = &scene.preset
        && PresetInfo::find(name).is_none()
    {
        let names: Vec<_> = presets().iter().map(|preset| preset.name).collect();
        let known = names.join(", ");
        let allowed = match crate::nearest::nearest(name, names.iter().copied()) {
            Some(near) => format!("{known}; did you mean {near:?}?"),
            None => known,
        };
        checker.add("preset", format!("{name:?}"), &allowed);
    }
}

fn check_labels(grid: &Grid, labels: &Grid, checker: &mut Checker) {
    // A tenth of a voxel: headers round, but no label volume is drawn one voxel off.
    if grid.matches(labels, 0.1 * grid.min_spacing_mm()) {
        return;
    }
    let describe = |grid: &Grid| {
        let [x, y, z] = grid.dims();
        let spacing = grid.spacing_mm();
        let centre = grid.centre_mm();
        format!(
            "{x}×{y}×{z} voxels of {:.4}×{:.4}×{:.4} mm, axes {}, centre ({:.2}, {:.2}, {:.2}) mm",
            spacing.x,
            spacing.y,
            spacing.z,
            grid.orientation(),
            centre.x,
            centre.y,
            centre.z
        )
    };
    checker.add(
        "labels",
        format!("on a grid of {}", describe(labels)),
        &format!("the volume's grid: {}", describe(grid)),
    );
}

fn plan_shade(method: Method, shading: Shading, checker: &mut Checker) -> Shade {
    let mut number = |key: &str, value: Option<f64>, within: Within| {
        let value = value.unwrap_or(1.0);
        checker.number(&format!("shading.{key}"), value, within);
        value as f32
    };
    let share = Within::Closed(0.0, 10.0);
    let ambient = number("ambient", shading.ambient, share);
    let diffuse = number("diffuse", shading.diffuse, share);
    let specular = number("specular", shading.specular, share);
    let shininess = number("shininess", shading.shininess, Within::Above(0.0, 1000.0));
    let roughness = number("roughness", shading.roughness, Within::Closed(0.05, 1.0));
    let reflectance = number("reflectance", shading.reflectance, Within::Closed(0.0, 1.0));
    let full_per_mm = number(
        "full_per_mm",
        shading.full_per_mm,
        Within::Closed(1e-30, 1e30),
    );
    let model = shading.model.unwrap_or(ShadingModel::Unlit);
    let illuminate = match model {
        ShadingModel::Unlit => return Shade::Unlit,
        ShadingModel::Lambert => Illuminate::Lambert { diffuse },
        ShadingModel::Phong => Illuminate::Phong {
            diffuse,
            specular,
            shininess,
        },
        ShadingModel::BlinnPhong => Illuminate::BlinnPhong {
            diffuse,
            specular,
            shininess,
        },
        ShadingModel::CookTorrance => Illuminate::CookTorrance {
            diffuse,
            roughness,
            reflectance,
        },
        ShadingModel::GradientOpacity if !method.is_projection() => {
            return Shade::GradientOpacity { full_per_mm };
        }
        ShadingModel::GradientOpacity => Illuminate::Lambert { diffuse },
    };
    let has_place = !matches!(method, Method::Average | Method::Gmip);
    if !has_place || model == ShadingModel::GradientOpacity {
        checker.add(
            "shading.model",
            format!("{:?} with method {:?}", model.name(), method.name()),
            "\"unlit\" (or nothing): such a projection has no surface",
        );
        return Shade::Unlit;
    }
    Shade::Lit {
        ambient,
        illuminate,
        keep_last_normal: shading.keep_last_normal.unwrap_or(false),
    }
}

fn plan_step(scene: &Scene, grid: &Grid, spacing_mm: f64, checker: &mut Checker) -> f64 {
    let (key, given, step_mm) = match (scene.step_mm, scene.step_voxels) {
        (Some(_), Some(voxels)) => {
            checker.add("step_voxels", voxels, "either step_mm or step_voxels");
            return 1.0;
        }
        (Some(mm), None) => ("step_mm", mm, mm),
        (None, voxels) => {
            let voxels = voxels.unwrap_or(DEFAULT_STEP_VOXELS);
            ("step_voxels", voxels, voxels * spacing_mm)
        }
    };
    let (lo, hi) = grid.bounds_mm();
    let longest_mm = lo.distance(hi);
    let smallest_mm = longest_mm / MAX_SAMPLES_PER_RAY;
    // NaN is in no interval.
    if !(smallest_mm..=longest_mm).contains(&step_mm) || step_mm <= 0.0 {
        let unit = given / step_mm;
        let unit = if unit.is_finite() && unit > 0.0 {
            unit
        } else if key == "step_mm" {
            1.0
        } else {
            1.0 / spacing_mm
        };
        checker.add(
            key,
            Number(given),
            &format!(
                "{:.3e} (a ray of {MAX_SAMPLES_PER_RAY} samples) to {:.2} (the diagonal of the volume)",
                smallest_mm * unit,
                longest_mm * unit
            ),
        );
        return 1.0;
    }
    step_mm
}
