//! Scene + volume header → Plan, or every problem at once.

use crate::plan::{
    Composite, Display as PlanDisplay, Gradient, Jitter as PlanJitter, Lattice, Plan, PlanVolume,
    Reconstruct as PlanReconstruct, Shade, ToneMap as PlanToneMap,
};
use crate::problem::{Checker, Number, Within};
use crate::window::otsu_threshold;
use crate::{
    Background, Color, Display, Jitter, Light, Method, PresetInfo, Problem, Problems, Reconstruct,
    Scene, Shading, ShadingModel, ToneMap, presets,
};
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

/// `scene` with every default filled in: first from its preset (chosen from the volume if it names
/// none), then from `docs/scene.md`. What is wrong stays as it is: [`resolve`] reports it.
pub fn settled(scene: &Scene, header: &VolumeHeader) -> Scene {
    let preset = match &scene.preset {
        Some(name) => PresetInfo::find(name),
        None => Some(PresetInfo::automatic(scene.method, header)),
    };
    let from_preset = preset.map(PresetInfo::scene).unwrap_or_default();
    let method = scene
        .method
        .or(from_preset.method)
        .unwrap_or(Method::EmissionAbsorption);
    let size = scene.size.unwrap_or(DEFAULT_SIZE);
    let transfer_function = scene.transfer_function.clone().unwrap_or_default();
    let transfer_function = match &from_preset.transfer_function {
        Some(preset) => transfer_function.over(preset),
        None => transfer_function,
    };
    let shading = settled_shading(
        method,
        scene.shading.unwrap_or_default(),
        from_preset.shading.unwrap_or_default(),
    );
    let lights = scene.lights.clone().or_else(|| {
        (shading.model == Some(ShadingModel::BlinnPhong))
            .then(|| from_preset.lights.unwrap_or_else(default_lights))
    });
    let display = scene.display.unwrap_or_default();
    let preset_display = from_preset.display.unwrap_or_default();
    Scene {
        format: scene.format.or(Some(FORMAT)),
        volume: scene.volume.clone(),
        labels: scene.labels.clone(),
        preset: scene
            .preset
            .clone()
            .or(preset.map(|preset| preset.name.to_owned())),
        method: Some(method),
        threshold: scene.threshold.or_else(|| {
            (method == Method::FirstHit)
                .then(|| from_preset.threshold.unwrap_or(automatic_threshold(header)))
        }),
        transfer_function: Some(transfer_function.settled(method, header)),
        shading: Some(shading),
        lights: lights.map(|lights| lights.into_iter().map(Light::settled).collect()),
        camera: Some(scene.camera.unwrap_or_default().settled(header, size)),
        clips: Some(
            scene
                .clips
                .iter()
                .flatten()
                .map(|clip| clip.settled(&header.grid))
                .collect(),
        ),
        reconstruct: scene.reconstruct.or(Some(Reconstruct::Trilinear)),
        step_mm: scene.step_mm,
        step_voxels: scene
            .step_voxels
            .or(scene.step_mm.is_none().then_some(DEFAULT_STEP_VOXELS)),
        jitter: scene.jitter.or(Some(Jitter::Off)),
        early_termination: scene
            .early_termination
            .or((method == Method::EmissionAbsorption).then_some(DEFAULT_EARLY_TERMINATION)),
        background: scene
            .background
            .or(from_preset.background)
            .or(Some(Background::Color(Color::BLACK))),
        size: Some(size),
        display: Some(Display {
            exposure: display.exposure.or(preset_display.exposure).or(Some(1.0)),
            tone_map: display
                .tone_map
                .or(preset_display.tone_map)
                .or(Some(ToneMap::Clamp)),
        }),
    }
}

fn settled_shading(method: Method, own: Shading, preset: Shading) -> Shading {
    let default = if method.is_projection() {
        ShadingModel::Unlit
    } else {
        preset.model.unwrap_or(ShadingModel::BlinnPhong)
    };
    let model = own.model.unwrap_or(default);
    let number = |own: Option<f64>, preset: Option<f64>, default: f64| {
        own.or((model == ShadingModel::BlinnPhong).then(|| preset.unwrap_or(default)))
    };
    Shading {
        model: Some(model),
        ambient: number(own.ambient, preset.ambient, 0.25),
        diffuse: number(own.diffuse, preset.diffuse, 0.75),
        specular: number(own.specular, preset.specular, 0.2),
        shininess: number(own.shininess, preset.shininess, 24.0),
    }
}

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

/// The plan that draws `scene` with a volume of this header. `labels` is the grid of the label
/// volume, if one is loaded.
///
/// # Errors
/// Everything that is wrong with the scene, in the order of its keys.
pub fn resolve(
    scene: &Scene,
    header: &VolumeHeader,
    labels: Option<&Grid>,
) -> Result<Plan, Problems> {
    let mut checker = Checker::default();
    check_given(scene, &mut checker);
    let settled = settled(scene, header);
    let grid = &header.grid;
    if let Some(labels) = labels {
        check_labels(grid, labels, &mut checker);
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
    let classify = settled
        .transfer_function
        .as_ref()
        .and_then(|function| function.plan(header, &mut checker));
    let shading = settled.shading.unwrap_or_default();
    let shade = plan_shade(method, shading, &mut checker);
    let camera = settled
        .camera
        .unwrap_or_default()
        .plan(grid, size, &mut checker);
    let mut lights = Vec::new();
    if shading.model == Some(ShadingModel::BlinnPhong) {
        // Lights of a scene whose camera is wrong are checked all the same.
        let frame = camera.or_else(|| {
            crate::Camera::default().settled(header, [1, 1]).plan(
                grid,
                [1, 1],
                &mut Checker::default(),
            )
        });
        for (i, light) in settled.lights.iter().flatten().enumerate() {
            if let Some(frame) = &frame {
                lights.extend(light.plan(&format!("lights[{i}]"), frame, &mut checker));
            }
        }
    }
    let (mut ray_clips, mut sample_clips) = (Vec::new(), Vec::new());
    for (i, clip) in settled.clips.iter().flatten().enumerate() {
        clip.plan(
            &format!("clips[{i}]"),
            grid,
            &mut checker,
            &mut ray_clips,
            &mut sample_clips,
        );
    }
    let step_mm = plan_step(&settled, grid, &mut checker);
    let early = settled
        .early_termination
        .unwrap_or(DEFAULT_EARLY_TERMINATION);
    checker.number("early_termination", early, Within::Closed(0.0, 1.0));
    let background = settled
        .background
        .unwrap_or(Background::Color(Color::BLACK));
    if let Background::Color(color) = background {
        crate::light::check_color("background", color, &mut checker);
    }
    let display = settled.display.unwrap_or_default();
    let exposure = display.exposure.unwrap_or(1.0);
    checker.number("display.exposure", exposure, Within::Closed(1e-6, 1e6));

    Problems::none_of(checker.problems)?;
    let (Some(classify), Some(camera)) = (classify, camera) else {
        // Both report a problem when they fail.
        return Err(Problems::one(Problem::new(
            "scene",
            "not complete",
            "a camera and a transfer function",
        )));
    };
    Ok(Plan {
        width: size[0],
        height: size[1],
        camera,
        volume: PlanVolume {
            grid: *grid,
            rescale: header.rescale,
        },
        lattice: Lattice {
            step_mm,
            jitter: match settled.jitter.unwrap_or(Jitter::Off) {
                Jitter::Off => PlanJitter::Centre,
                Jitter::Seed(seed) => PlanJitter::Hash(seed),
            },
        },
        reconstruct: match settled.reconstruct.unwrap_or(Reconstruct::Trilinear) {
            Reconstruct::Nearest => PlanReconstruct::Nearest,
            Reconstruct::Trilinear => PlanReconstruct::Trilinear,
        },
        classify,
        gradient: Gradient::Central,
        shade,
        lights,
        composite: match method {
            Method::EmissionAbsorption => Composite::EmissionAbsorption {
                stop_at_transmittance: early as f32,
            },
            Method::Mip => Composite::Mip,
            Method::Minip => Composite::MinIp,
            Method::Average => Composite::Average,
            Method::FirstHit => Composite::FirstHit {
                threshold: settled.threshold.unwrap_or(automatic_threshold(header)),
            },
        },
        ray_clips,
        sample_clips,
        background: background.linear(),
        display: PlanDisplay {
            exposure: exposure as f32,
            tone_map: match display.tone_map.unwrap_or(ToneMap::Clamp) {
                ToneMap::Clamp => PlanToneMap::Clamp,
                ToneMap::Reinhard => PlanToneMap::Reinhard,
            },
        },
    })
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
    if let Some(name) = &scene.preset
        && PresetInfo::find(name).is_none()
    {
        let names: Vec<_> = presets().iter().map(|preset| preset.name).collect();
        let known = names.join(", ");
        let allowed = match crate::parse::nearest(name, names.iter().copied()) {
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
    let lit = Shade::BlinnPhong {
        ambient: number("ambient", shading.ambient, share),
        diffuse: number("diffuse", shading.diffuse, share),
        specular: number("specular", shading.specular, share),
        shininess: number("shininess", shading.shininess, Within::Above(0.0, 1000.0)),
    };
    match shading.model {
        Some(ShadingModel::BlinnPhong) if method.is_projection() => {
            checker.add(
                "shading.model",
                format!("\"blinn-phong\" with method {:?}", method.name()),
                "\"unlit\" (or nothing): a projection has no surface",
            );
            Shade::Unlit
        }
        Some(ShadingModel::BlinnPhong) => lit,
        Some(ShadingModel::Unlit) | None => Shade::Unlit,
    }
}

fn plan_step(scene: &Scene, grid: &Grid, checker: &mut Checker) -> f64 {
    let (key, given, step_mm) = match (scene.step_mm, scene.step_voxels) {
        (Some(_), Some(voxels)) => {
            checker.add("step_voxels", voxels, "either step_mm or step_voxels");
            return 1.0;
        }
        (Some(mm), None) => ("step_mm", mm, mm),
        (None, voxels) => {
            let voxels = voxels.unwrap_or(DEFAULT_STEP_VOXELS);
            ("step_voxels", voxels, voxels * grid.min_spacing_mm())
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
            1.0 / grid.min_spacing_mm()
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
