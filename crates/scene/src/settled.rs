//! A scene with everything said: between the Scene, in which every key may be left out, and the Plan.
//!
//! Every default is stated here, or where the part that it belongs to is settled, and nowhere else.
//! Numbers are as they were said: [`resolve`](crate::resolve) checks them.

use crate::camera::SettledCamera;
use crate::clip::SettledClip;
use crate::composite::{DepthView, SettledComposite};
use crate::frame::PlacedFrame;
use crate::light::SettledLight;
use crate::places::{PlacedMesh, PlacedVolume, Places};
use crate::problem::Checker;
use crate::sampling::SettledSampling;
use crate::scene::SettledDisplay;
use crate::shading::SettledShading;
use crate::step::Step;
use crate::transfer_function::SettledFunction;
use crate::window::steep_per_mm;
use crate::{
    Background, Color, Compositing, FunctionUse, Gradient, GradientInput, GradientMethod, Headers,
    ImportanceSource, Jitter, Light, Method, PresetInfo, Quality, Reconstruct, Scene, SceneObject,
    ShadingModel, TransferFunction,
};
use std::collections::BTreeMap;
use strahl_volume::{Grid, VolumeHeader};

/// The version of the scene format that this program reads and writes.
pub const FORMAT: u32 = 1;
/// Width and height of a picture that nobody gave a size.
const DEFAULT_SIZE: [u32; 2] = [1024, 1024];
/// Plaster: light enough for its light to be seen.
const MESH_COLOR: Color = Color([0.8, 0.8, 0.8]);

/// [`settled_with`] for a scene of one volume.
pub fn settled(scene: &Scene, header: &VolumeHeader) -> Scene {
    settled_with(scene, &Headers::from(header.clone()))
}

/// `scene` with every default filled in: first from its preset (chosen from the volume if it names
/// none), then from `docs/scene.md`. It draws the same picture. What is wrong with the scene,
/// [`resolve`](crate::resolve) reports.
///
/// # Panics
/// If there is no header of a volume.
pub fn settled_with(scene: &Scene, headers: &Headers) -> Scene {
    SettledScene::new(scene, headers, &mut Checker::default()).scene(scene)
}

/// A scene with every default filled in.
pub(crate) struct SettledScene {
    /// `None` if the scene names one that there is not.
    pub preset: Option<&'static PresetInfo>,
    pub size: [u32; 2],
    /// Its own volume, then those of its objects.
    pub volumes: Vec<SettledVolume>,
    pub meshes: Vec<SettledMesh>,
    /// A grid around everything: what the camera frames.
    pub framed: Grid,
    /// Whether the value itself is shown as gray, without a transfer function.
    pub shows_values: bool,
    pub composite: SettledComposite,
    pub shading: SettledShading,
    pub lights: Vec<SettledLight>,
    pub camera: SettledCamera,
    pub clips: Vec<SettledClip>,
    pub importance: Option<ImportanceSource>,
    /// Frames that clips may have, that of the scene's own volume first.
    pub clip_frames: Vec<PlacedFrame>,
    pub reconstruct: Reconstruct,
    pub gradient: SettledGradient,
    pub step: Step,
    pub sampling: SettledSampling,
    pub jitter: Jitter,
    pub frames: u32,
    pub functions: BTreeMap<String, FunctionUse>,
    pub compositing: Compositing,
    pub background: Background,
    pub display: SettledDisplay,
}

/// A volume that is drawn.
pub(crate) struct SettledVolume {
    pub place: PlacedVolume,
    pub preset: Option<&'static PresetInfo>,
    pub function: SettledFunction,
    /// `None` shades as the scene says.
    pub shading: Option<SettledShading>,
    /// In place of those of the scene.
    pub functions: BTreeMap<String, FunctionUse>,
}

/// A mesh that is drawn.
pub(crate) struct SettledMesh {
    pub place: PlacedMesh,
    pub color: Color,
}

/// [`Gradient`] with everything said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SettledGradient {
    pub method: GradientMethod,
    pub of: GradientInput,
}

impl SettledScene {
    /// What `scene` means with data of these headers. Keys that do not go together are problems.
    ///
    /// # Panics
    /// If there is no header of a volume.
    pub fn new(scene: &Scene, headers: &Headers, checker: &mut Checker) -> SettledScene {
        let header = &headers.volumes[0];
        let named = scene.preset.as_deref();
        let preset = preset(named, scene.method, header);
        let from_preset = preset.map(PresetInfo::scene).unwrap_or_default();
        let method = scene
            .method
            .or(from_preset.method)
            .unwrap_or(Method::EmissionAbsorption);
        let quality = scene.quality.unwrap_or(Quality::Medium);
        let of_quality = quality.scene(method);
        let size = scene.size.unwrap_or(DEFAULT_SIZE);
        let mut own_shading = scene.shading.unwrap_or_default();
        own_shading.model = own_shading
            .model
            .or(of_quality.shading.and_then(|shading| shading.model));
        let Places {
            volumes,
            meshes,
            framed,
            frames,
        } = Places::new(scene, headers, checker);
        let gradient = SettledGradient::new(
            scene.gradient.unwrap_or_default(),
            of_quality.gradient.unwrap_or_default(),
            // Borders of label voxels are stairs: the smoothest of the estimates over few voxels.
            match headers.labels {
                Some(_) => GradientMethod::Sobel,
                None => GradientMethod::Central,
            },
        );
        let volumes = settled_volumes(scene, volumes, headers, method, gradient.of, checker);
        let steep_per_mm = steepness(gradient.of, header, &volumes[0].function);
        let from_preset_shading = from_preset.shading.unwrap_or_default();
        let shading = own_shading.settled(from_preset_shading, method, steep_per_mm);
        let of_objects = scene.objects.iter().flatten();
        let mut models = of_objects.filter_map(|object| object.shading?.model);
        let is_lit =
            shading.model.is_lit() || models.any(ShadingModel::is_lit) || !meshes.is_empty();
        let lights = settled_lights(scene, &from_preset, is_lit, checker);
        let camera = scene.camera.unwrap_or_default();
        let clips = scene.clips.iter().flatten().enumerate();
        let camera = camera.settled(header, &framed, size, checker);
        let view = DepthView {
            camera: &camera,
            framed: &framed,
            size,
        };
        SettledScene {
            preset,
            size,
            shows_values: quality.shows_values(method),
            composite: SettledComposite::new(
                scene,
                [&of_quality, &from_preset],
                method,
                header,
                steep_per_mm,
                &view,
                checker,
            ),
            shading,
            lights,
            camera,
            clips: clips
                .map(|(i, clip)| clip.settled(&frames, &format!("clips[{i}]"), checker))
                .collect(),
            importance: scene.importance.clone(),
            clip_frames: frames,
            reconstruct: scene
                .reconstruct
                .or(of_quality.reconstruct)
                .unwrap_or(Reconstruct::Trilinear),
            gradient,
            step: Step::settled(scene, checker),
            sampling: scene.sampling.unwrap_or_default().settled(checker),
            jitter: scene.jitter.unwrap_or(Jitter::Off),
            frames: scene.frames.unwrap_or(1),
            functions: scene.functions.clone().unwrap_or_default(),
            compositing: scene.compositing.unwrap_or(Compositing::Linear),
            background: scene
                .background
                .or(from_preset.background)
                .unwrap_or(Background::Color(Color::BLACK)),
            display: scene
                .display
                .unwrap_or_default()
                .settled(from_preset.display.unwrap_or_default(), checker),
            volumes,
            meshes: settled_meshes(scene, meshes),
            framed,
        }
    }

    /// `given`, which this is made of, with everything filled in.
    pub fn scene(&self, given: &Scene) -> Scene {
        let (step_mm, step_voxels) = match self.step {
            Step::Mm(mm) => (Some(mm), None),
            Step::Voxels(voxels) => (None, Some(voxels)),
        };
        let says_lights = given.lights.is_some() || !self.lights.is_empty();
        let mut scene = Scene {
            format: given.format.or(Some(FORMAT)),
            objects: self.objects(given),
            preset: known_name(given.preset.clone()).or_else(|| name_of(self.preset)),
            transfer_function: Some(self.volumes[0].function.scene()),
            shading: Some(given.shading.unwrap_or_default().filled(&self.shading)),
            lights: says_lights.then(|| self.lights.iter().map(|light| light.scene()).collect()),
            camera: Some(self.camera.scene()),
            clips: Some(self.clips.iter().map(SettledClip::scene).collect()),
            reconstruct: Some(self.reconstruct),
            gradient: Some(Gradient {
                method: Some(self.gradient.method),
                of: Some(self.gradient.of),
            }),
            step_mm,
            step_voxels,
            sampling: Some(self.sampling.scene()),
            jitter: Some(self.jitter),
            frames: Some(self.frames),
            compositing: Some(self.compositing),
            background: Some(self.background),
            size: Some(self.size),
            display: Some(self.display.scene()),
            ..given.clone()
        };
        self.composite.fill(&mut scene);
        scene
    }

    fn objects(&self, given: &Scene) -> Option<Vec<SceneObject>> {
        let mut objects = given.objects.clone()?;
        for mesh in &self.meshes {
            objects[mesh.place.object].color = Some(mesh.color);
        }
        for volume in &self.volumes {
            if let Some(object) = volume.place.object.map(|i| &mut objects[i]) {
                let named = known_name(object.preset.take());
                object.preset = named.or_else(|| name_of(volume.preset));
                object.transfer_function = Some(volume.function.scene());
                if let (Some(own), Some(settled)) = (&mut object.shading, &volume.shading) {
                    *own = own.filled(settled);
                }
            }
        }
        Some(objects)
    }
}

impl SettledGradient {
    fn new(own: Gradient, quality: Gradient, default: GradientMethod) -> SettledGradient {
        SettledGradient {
            method: own.method.or(quality.method).unwrap_or(default),
            of: own.of.unwrap_or(GradientInput::Value),
        }
    }
}

/// A gradient that is steep in a volume: of its values, or of the opacities that `function` makes of them.
fn steepness(of: GradientInput, header: &VolumeHeader, function: &SettledFunction) -> f64 {
    let most_opaque = (of == GradientInput::Opacity).then(|| function.most_opaque());
    steep_per_mm(header, most_opaque)
}

/// The preset of a volume: the named one, or the one that suits it.
fn preset(
    name: Option<&str>,
    method: Option<Method>,
    header: &VolumeHeader,
) -> Option<&'static PresetInfo> {
    match name {
        Some(name) => PresetInfo::find(name),
        None => Some(PresetInfo::automatic(method, header)),
    }
}

/// The name of a preset as presets are listed.
fn known_name(named: Option<String>) -> Option<String> {
    let known = |name: String| PresetInfo::find(&name).map_or(name, |info| info.name.to_owned());
    named.map(known)
}

fn name_of(preset: Option<&PresetInfo>) -> Option<String> {
    preset.map(|preset| preset.name.to_owned())
}

/// The lights of the scene; none where nothing is lit and none is said.
fn settled_lights(
    scene: &Scene,
    preset: &Scene,
    is_lit: bool,
    checker: &mut Checker,
) -> Vec<SettledLight> {
    // A key light from the upper left and a weaker one at the eye, so that nothing is quite dark.
    let default = || vec![Light::from_camera(-35.0, 40.0, 0.8), Light::head(0.4)];
    let lights = match &scene.lights {
        Some(lights) => lights.clone(),
        None if is_lit => preset.lights.clone().unwrap_or_else(default),
        None => Vec::new(),
    };
    // Lights that light nothing are not looked at.
    let mut unheard = Checker::default();
    let checker = if is_lit { checker } else { &mut unheard };
    let lights = lights.into_iter().enumerate();
    lights
        .map(|(i, light)| light.settled(&format!("lights[{i}]"), checker))
        .collect()
}

fn settled_volumes(
    scene: &Scene,
    places: Vec<PlacedVolume>,
    headers: &Headers,
    method: Method,
    gradient_of: GradientInput,
    checker: &mut Checker,
) -> Vec<SettledVolume> {
    let settle = |place: PlacedVolume| {
        let header = &headers.volumes[place.volume];
        let (named, function, chosen_for, path) = match place.object {
            None => {
                let named = scene.preset.as_deref();
                (named, &scene.transfer_function, scene.method, String::new())
            }
            Some(i) => {
                let object = &scene.objects.as_deref().unwrap_or(&[])[i];
                let named = object.preset.as_deref();
                let path = format!("objects[{i}].");
                (named, &object.transfer_function, Some(method), path)
            }
        };
        let preset = preset(named, chosen_for, header);
        let from_preset = preset.map(PresetInfo::scene).unwrap_or_default();
        let object = place
            .object
            .map(|i| &scene.objects.as_deref().unwrap_or(&[])[i]);
        let shading = object.and_then(|object| object.shading);
        let from_preset_shading = from_preset.shading.unwrap_or_default();
        let functions = object.and_then(|object| object.functions.clone());
        let from_preset = from_preset.transfer_function;
        let own = function.clone().unwrap_or_default();
        let function: TransferFunction = match from_preset {
            Some(preset) => own.over(&preset),
            None => own,
        };
        let function = function.settled(method, header, &path, checker);
        let steep_per_mm = steepness(gradient_of, header, &function);
        SettledVolume {
            function,
            preset,
            shading: shading.map(|own| own.settled(from_preset_shading, method, steep_per_mm)),
            functions: functions.unwrap_or_default(),
            place,
        }
    };
    places.into_iter().map(settle).collect()
}

fn settled_meshes(scene: &Scene, places: Vec<PlacedMesh>) -> Vec<SettledMesh> {
    let settle = |place: PlacedMesh| {
        let objects = scene.objects.as_deref().unwrap_or(&[]);
        SettledMesh {
            color: objects[place.object].color.unwrap_or(MESH_COLOR),
            place,
        }
    };
    places.into_iter().map(settle).collect()
}
