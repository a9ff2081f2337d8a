//! Draws volumes and scenes: [`Render`] and [`render_file`].

use crate::backend::{Backend, DrawRequest, DrawnBy, draw};
use crate::budget::Budget;
use crate::clipped::of_clips;
use crate::confinement::Confinement;
use crate::note::Note;
use crate::picture::{CarriedFiles, MadeFrom, SOFTWARE};
use crate::scene_data::{OwnVolume, SceneData};
use crate::scene_file::{
    SceneFile, anonymous, anonymous_made_from, made_from_told_from, names_told_from, told_from,
};
use crate::scene_graph::SceneGraph;
use crate::session::Session;
use crate::show_stage::ShowStage;
use crate::{Encoding, Error, Output, Recipe, write_picture};
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::time::Instant;
use strahl_cpu::Options;
#[cfg(feature = "gpu")]
use strahl_gpu::TextureTarget;
use strahl_scene::{
    Background, Camera, Clip, Headers, Image, Method, Rendered, Scene, Stats, TransferFunction,
    View, VolumeSource, WithoutEffect, keys_without_effect, plan, preset_notes, resolve_with,
    settled_with, why_nothing_is_seen,
};
use strahl_volume::read::ReadOptions;
use strahl_volume::{Control, Phantom, Volume};

/// Draws the volume at `volume_path` (a file, or a folder with one DICOM series or numbered
/// slices) into the picture `picture_path` (`.png` or `.exr`), with all settings chosen by the
/// data.
///
/// # Errors
/// Any problem with either file; the message names the file.
pub fn render_file(
    volume_path: impl AsRef<Path>,
    picture_path: impl AsRef<Path>,
) -> Result<(), Error> {
    Render::file(volume_path).save(picture_path).map(drop)
}

/// A builder of a picture: a volume, and the settings that differ from the defaults.
///
/// ```
/// use strahl::{Phantom, Render, View};
/// let picture = Render::phantom(Phantom::Shells)
///     .preset("solid")
///     .view(View::Left)
///     .size(64, 48)
///     .picture()?;
/// assert_eq!(picture.image.width(), 64);
/// # Ok::<(), strahl::Error>(())
/// ```
///
/// [`Render::picture`] reports mistakes (an unknown preset, a size of 0), all at once.
#[derive(Clone)]
#[must_use = "nothing is drawn before `picture` or `save`"]
pub struct Render<'a> {
    source: Source,
    scene: Scene,
    scene_path: Option<PathBuf>,
    options: Options,
    with_depth: bool,
    /// Whether every key of the scene is set, as in pictures.
    is_complete: bool,
    /// Files of the scene that are used instead of those at their paths.
    carried: CarriedFiles,
    backend: Backend,
    control: Control,
    show: Option<ShowStage<'a>>,
    session: Option<&'a Session>,
    budget: Option<Budget>,
    confinement: Option<Confinement>,
}

#[derive(Clone)]
enum Source {
    /// The volume of `scene.volume`.
    Scene,
    /// One volume from these files, read with the options in `scene.volume`.
    Files(Vec<PathBuf>),
    /// A volume in memory.
    Volume(Volume),
}

/// The result of `Render::draw_into`: information about a picture in a texture.
#[derive(Clone, Debug)]
pub struct ShownPicture {
    /// Exposure and tone map, to be applied when the texture is shown.
    pub display: plan::Display,
    /// The scene with every default filled in.
    pub scene: Scene,
    /// What the user should know.
    pub notes: Vec<Note>,
    /// Times and counts of drawing.
    pub stats: Stats,
    /// The renderer that has drawn.
    pub drawn_by: DrawnBy,
}

/// A picture, and information about it.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Linear, premultiplied pixels, with the background unless `display.background` is set.
    pub image: Image,
    /// Distance of the first hit or of a mesh from the start of each ray in mm, row by row from
    /// the top, infinite without a hit. `None` without [`Render::with_depth`].
    pub depth_mm: Option<Vec<f32>>,
    /// Exposure and tone map for a file with display colors.
    pub display: plan::Display,
    /// The scene with every default filled in. Drawing it again gives the same picture.
    pub scene: Scene,
    /// The scene without defaults, and files that it names.
    pub made_from: MadeFrom,
    /// What the user should know, such as ignored slices and corrected fields of the file.
    pub notes: Vec<Note>,
    /// Times and counts of drawing.
    pub stats: Stats,
    /// The renderer that has drawn.
    pub drawn_by: DrawnBy,
    /// Time to read the volume or to compute the phantom.
    pub read_seconds: f64,
}

impl<'a> Render<'a> {
    /// Draws the volume at `path`: a file, or a folder with one DICOM series or numbered slices.
    pub fn file(path: impl AsRef<Path>) -> Render<'a> {
        Render::files(vec![path.as_ref().to_owned()])
    }

    /// Draws the volume made of several files: the slices of one series, in any order.
    pub fn files(paths: Vec<PathBuf>) -> Render<'a> {
        Render::new(Source::Files(paths), Scene::default())
    }

    /// Draws a built-in phantom.
    pub fn phantom(phantom: Phantom) -> Render<'a> {
        Render::scene(Scene {
            volume: Some(VolumeSource {
                phantom: Some(phantom.name().to_owned()),
                ..VolumeSource::default()
            }),
            ..Scene::default()
        })
    }

    /// Draws a volume in memory. (A picture file then does not contain the place of its
    /// volume.)
    pub fn volume(volume: &Volume) -> Render<'a> {
        Render::new(Source::Volume(volume.clone()), Scene::default())
    }

    /// Draws a scene. Its paths are relative to the current folder.
    pub fn scene(scene: Scene) -> Render<'a> {
        Render::new(Source::Scene, scene)
    }

    /// Draws the scene in a file.
    pub fn scene_file(file: SceneFile) -> Render<'a> {
        Render {
            scene_path: Some(file.path),
            is_complete: file.software.is_some_and(|software| software != SOFTWARE),
            carried: file.carried,
            confinement: file.confinement,
            ..Render::new(Source::Scene, file.scene)
        }
    }

    fn new(source: Source, scene: Scene) -> Render<'a> {
        Render {
            source,
            scene,
            scene_path: None,
            options: Options::default(),
            with_depth: false,
            is_complete: false,
            carried: CarriedFiles::default(),
            backend: Backend::default(),
            control: Control::NONE,
            show: None,
            session: None,
            budget: None,
            confinement: None,
        }
    }

    /// Draws the volume of these files instead of the scene's own.
    pub fn with_files(mut self, paths: Vec<PathBuf>) -> Render<'a> {
        self.source = Source::Files(paths);
        self
    }

    /// Uses the preset `name`; see [`presets`](strahl_scene::presets).
    pub fn preset(self, name: &str) -> Render<'a> {
        self.with(|scene| scene.preset = Some(name.to_owned()))
    }

    /// Sets the composite rule: how the samples of a ray become a pixel.
    pub fn method(self, method: Method) -> Render<'a> {
        self.with(|scene| scene.method = Some(method))
    }

    /// Draws the surface at this value of the volume.
    pub fn surface(self, threshold: f64) -> Render<'a> {
        self.with(|scene| {
            scene.method = Some(Method::FirstHit);
            scene.threshold = Some(threshold);
        })
    }

    /// Sets the transfer function, which maps values to color and opacity.
    pub fn transfer_function(self, function: TransferFunction) -> Render<'a> {
        self.with(|scene| scene.transfer_function = Some(function))
    }

    /// Looks from a side of the patient (or of the box).
    pub fn view(self, view: View) -> Render<'a> {
        self.camera(Camera {
            view: Some(view),
            ..Camera::default()
        })
    }

    /// Sets the camera.
    pub fn camera(self, camera: Camera) -> Render<'a> {
        self.with(|scene| scene.camera = Some(camera))
    }

    /// Sets width and height in pixels.
    pub fn size(self, width: u32, height: u32) -> Render<'a> {
        self.with(|scene| scene.size = Some([width, height]))
    }

    /// Sets the background.
    pub fn background(self, background: Background) -> Render<'a> {
        self.with(|scene| scene.background = Some(background))
    }

    /// Adds a clip, which cuts a part away.
    pub fn clip(self, clip: Clip) -> Render<'a> {
        self.with(|scene| scene.clips.get_or_insert_default().push(clip))
    }

    /// Changes the scene directly, for all other settings.
    pub fn with(mut self, change: impl FnOnce(&mut Scene)) -> Render<'a> {
        change(&mut self.scene);
        self
    }

    /// Draws with this many threads; 0, the default, means all cores. The picture does not
    /// depend on it.
    pub fn threads(mut self, threads: usize) -> Render<'a> {
        self.options.threads = threads;
        self
    }

    /// Also computes the depth of `first-hit` surfaces and meshes. EXR files get a channel `Z`.
    pub fn with_depth(mut self) -> Render<'a> {
        self.with_depth = true;
        self
    }

    /// Draws with this renderer instead of the CPU renderer.
    pub fn backend(mut self, backend: Backend) -> Render<'a> {
        self.backend = backend;
        self
    }

    /// Reads and draws under `control`, which receives progress and can cancel.
    pub fn control(mut self, control: &Control) -> Render<'a> {
        self.control = control.clone();
        self
    }

    /// Refuses what would take more than `budget`; without, more than [`Budget::of_machine`] says.
    pub fn budget(mut self, budget: Budget) -> Render<'a> {
        self.budget = Some(budget);
        self
    }

    /// Lets the scene read nothing but what `confinement` says. Files that are named beside the scene may lie anywhere.
    pub fn confined(mut self, confinement: Confinement) -> Render<'a> {
        self.confinement = Some(confinement);
        self
    }

    /// Lets a confined scene read the file or folder `path` wherever it lies, and what its reader needs beside it.
    ///
    /// # Errors
    /// The path is empty.
    pub fn allowing(mut self, path: &Path) -> Result<Render<'a>, Error> {
        if let Some(confinement) = self.confinement.take() {
            self.confinement = Some(confinement.with_file(path)?);
        }
        Ok(self)
    }

    /// Draws in stages, from a coarse picture to the finished one. `show` gets each stage with
    /// the settings for a file. The last stage has the same bytes as a picture drawn at once.
    /// Only the CPU renderer ([`strahl_cpu::Renderer::refine`]) supports stages; others refuse.
    pub fn in_stages(mut self, show: ShowStage<'a>) -> Render<'a> {
        self.show = Some(show);
        self
    }

    /// Draws with the data of `session`, and keeps there what the next picture can use. Without
    /// a session, everything is dropped with the picture.
    pub fn in_session(mut self, session: &'a Session) -> Render<'a> {
        self.session = Some(session);
        self
    }

    /// Reads and draws.
    ///
    /// # Errors
    /// Any problem with the volume or the scene; cancellation.
    pub fn picture(&self) -> Result<Picture, Error> {
        let start = Instant::now();
        let budget = self.budget.unwrap_or_default();
        let session = self.session();
        let data = self.data(&session)?;
        let read_seconds = start.elapsed().as_secs_f64();
        let (headers, scene) = (data.headers(), self.known_scene());
        let mut plan = self.checked(resolve_with(&scene, &headers))?;
        plan.with_depth = self.with_depth;
        let graph = match &scene.graph {
            Some(text) => {
                let name = self.graph_name();
                Some(SceneGraph::with_carried(&name, Some(text), &self.carried)?)
            }
            None => None,
        };
        let mut files = data.carried.clone();
        if let Some(graph) = &graph {
            files.extend(graph.carried());
        }
        let datasets = data.datasets();
        let threads = self.options.threads;
        budget.check(&plan, &datasets, &self.backend, graph.is_some(), threads)?;
        let wanted = DrawRequest {
            data: &datasets,
            plan: &plan,
            graph: graph.as_ref(),
        };
        let (options, control) = (&self.options, &self.control);
        let drawn = draw(
            &session,
            &self.backend,
            &wanted,
            options,
            self.show,
            control,
        )?;
        let mut notes = self.notes(&scene, &plan, &headers, data.notes);
        notes.extend(drawn.notes);
        notes.extend(of_clips(&session, &scene, &plan, &datasets, control)?);
        notes.extend(of_colors(&drawn.rendered.image));
        notes.extend(of_emptiness(&drawn.rendered, &plan, &headers));
        Ok(Picture {
            image: drawn.rendered.image,
            depth_mm: drawn.rendered.depth_mm,
            display: plan.display,
            scene: settled_with(&scene, &headers),
            made_from: MadeFrom {
                given: scene,
                files,
            },
            notes,
            stats: drawn.rendered.stats,
            drawn_by: drawn.drawn_by,
            read_seconds,
        })
    }

    /// Reads, and draws into a texture on the session's device ([`Session::on_device`]). The
    /// picture does not pass through memory. Backend, threads and depth have no effect.
    ///
    /// # Errors
    /// As [`Render::picture`]; a scene with a graph; a texture that is smaller than the
    /// picture, is on another device, or cannot be drawn into.
    #[cfg(feature = "gpu")]
    pub fn draw_into(&self, target: &TextureTarget) -> Result<ShownPicture, Error> {
        let session = self.session();
        let data = self.data(&session)?;
        let (headers, scene) = (data.headers(), self.known_scene());
        let plan = self.checked(resolve_with(&scene, &headers))?;
        if scene.graph.is_some() {
            return Err(Error::NoGraph);
        }
        let control = &self.control;
        let devices = session.devices();
        let (stats, drawn_by) = devices.draw(None, &data.datasets(), control, |renderer| {
            let adapter = renderer.device().adapter().to_string();
            let stats = renderer.render_into(&plan, target, control)?;
            Ok((stats, DrawnBy::Gpu { adapter }))
        })?;
        Ok(ShownPicture {
            display: plan.display,
            scene: settled_with(&scene, &headers),
            notes: self.notes(&scene, &plan, &headers, data.notes),
            stats,
            drawn_by,
        })
    }

    /// Notes of the data and of the keys of the scene.
    fn notes(
        &self,
        scene: &Scene,
        plan: &plan::Plan,
        headers: &Headers,
        of_data: Vec<String>,
    ) -> Vec<Note> {
        let mut notes: Vec<Note> = of_data.into_iter().map(Note::Data).collect();
        if scene.segments.is_some() && headers.labels.is_none() {
            notes.push(Note::NoLabels);
        }
        let of_preset = preset_notes(scene, headers);
        notes.extend(of_preset.into_iter().map(Note::Data));
        // Where every key is set, those are too that have no effect.
        if !self.is_complete {
            let keys = keys_without_effect(scene, plan, headers);
            notes.extend(keys.into_iter().map(Note::WithoutEffect));
        }
        if self.with_depth && scene.graph.is_none() && !has_depth(plan) {
            let method = plan.technique().composite.function().word;
            notes.push(Note::WithoutEffect(WithoutEffect {
                key: "depth".into(),
                why: format!("{method} finds no surface, and there is no mesh"),
            }));
        }
        notes
    }

    /// The scene that would be drawn, with every default filled in. Reads the volume and draws
    /// nothing.
    ///
    /// # Errors
    /// As [`Render::picture`].
    pub fn settled_scene(&self) -> Result<Scene, Error> {
        Ok(self.settle()?.0)
    }

    /// What a user should know about the scene and its data before it is drawn, such as keys without effect. Draws
    /// nothing.
    ///
    /// # Errors
    /// As [`Render::picture`].
    pub fn scene_notes(&self) -> Result<Vec<Note>, Error> {
        let data = self.data(&self.session())?;
        let (headers, scene) = (data.headers(), self.known_scene());
        let plan = self.checked(resolve_with(&scene, &headers))?;
        Ok(self.notes(&scene, &plan, &headers, data.notes))
    }

    /// The Plan of the scene, with the data read to resolve it. Draws nothing.
    ///
    /// # Errors
    /// As [`Render::picture`].
    pub fn plan(&self) -> Result<plan::Plan, Error> {
        Ok(self.settle()?.1)
    }

    /// The graph that draws the scene, with all edits applied: its own one or the standard
    /// graph.
    ///
    /// # Errors
    /// The text of the graph is wrong, or a file that it names cannot be read.
    #[cfg(feature = "graph")]
    pub fn graph(&self) -> Result<SceneGraph, Error> {
        SceneGraph::with_carried(&self.graph_name(), self.scene.graph.as_ref(), &self.carried)
    }

    fn graph_name(&self) -> String {
        match &self.scene_path {
            Some(path) => format!("{}: graph", path.display()),
            None => "graph".to_owned(),
        }
    }

    fn session(&self) -> SessionHandle<'a> {
        match self.session {
            Some(session) => SessionHandle::Given(session),
            None => SessionHandle::Own(Box::default()),
        }
    }

    /// Everything that the scene names.
    fn data(&self, session: &Session) -> Result<SceneData, Error> {
        let (carried, within) = (&self.carried, self.confinement.as_ref());
        let own = self.own()?;
        let budget = self.budget.unwrap_or_default();
        let control = self.control.with_memory(budget.memory_bytes);
        SceneData::load(session, &self.scene, own, carried, within, &control)
            .map_err(|error| error.of_scene(&self.scene_path))
    }

    fn settle(&self) -> Result<(Scene, plan::Plan), Error> {
        let headers = self.data(&self.session())?.headers();
        let scene = self.known_scene();
        let plan = self.checked(resolve_with(&scene, &headers))?;
        let mut settled = settled_with(&scene, &headers);
        leave_out_unused(&mut settled, &scene, &plan, &headers);
        Ok((settled, plan))
    }

    /// Draws into the file `path`: 8-bit PNG or 32-bit EXR, depending on its name.
    ///
    /// # Errors
    /// As [`Render::picture`]; if the file cannot be written, which is checked before anything
    /// is read.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<Picture, Error> {
        let encoding = Encoding::for_path(path.as_ref(), None)?;
        let output = Output::create(path.as_ref())?;
        let mut picture = self.picture()?;
        picture.notes.extend(picture.untold_places(output.folder()));
        picture.write(encoding, output)?;
        Ok(picture)
    }

    /// The scene as far as a file can contain it. A scene cannot name several files or a volume
    /// in memory.
    fn known_scene(&self) -> Scene {
        let mut scene = self.scene.clone();
        match &self.source {
            Source::Scene => {}
            Source::Files(paths) => {
                let mut volume = scene.volume.take().unwrap_or_default();
                (volume.phantom, volume.path) = (None, None);
                if let [path] = paths.as_slice() {
                    volume.path = path.to_str().map(str::to_owned);
                }
                scene.volume = volume.path.is_some().then_some(volume);
            }
            Source::Volume(_) => scene.volume = None,
        }
        scene
    }

    /// Which volume is the scene's own.
    fn own(&self) -> Result<OwnVolume<'_>, Error> {
        let source = match (&self.source, &self.scene.volume) {
            (Source::Volume(volume), _) => return Ok(OwnVolume::Volume(volume)),
            (Source::Files(paths), source) => {
                let options = match source {
                    Some(source) => self.read_options(&VolumeSource {
                        path: Some(String::new()),
                        phantom: None,
                        ..source.clone()
                    })?,
                    None => ReadOptions::default(),
                };
                return Ok(OwnVolume::Given(paths.clone(), options));
            }
            (Source::Scene, Some(source)) => source,
            (Source::Scene, None) => {
                let scene = self.scene_path.clone();
                return Err(Error::NoVolume { scene });
            }
        };
        let options = self.read_options(source)?;
        // One of the two is there and known, as has just been checked.
        match source.phantom.as_deref().and_then(Phantom::from_name) {
            Some(phantom) => {
                let dims = source.dims.unwrap_or(phantom.default_dims());
                Ok(OwnVolume::Phantom(phantom, dims))
            }
            None => {
                let path = PathBuf::from(source.path.clone().unwrap_or_default());
                Ok(OwnVolume::Files(vec![path], options))
            }
        }
    }

    fn read_options(&self, source: &VolumeSource) -> Result<ReadOptions, Error> {
        self.checked(source.read_options())
    }

    fn checked<T>(&self, result: Result<T, strahl_scene::Problems>) -> Result<T, Error> {
        result.map_err(|problems| Error::from(problems).of_scene(&self.scene_path))
    }
}

/// Takes looks of the scene that draw nothing out of what was filled in, where segments have techniques of their own:
/// whoever reads them there would believe that they matter.
fn leave_out_unused(settled: &mut Scene, scene: &Scene, plan: &plan::Plan, headers: &Headers) {
    for unused in keys_without_effect(settled, plan, headers) {
        match &*unused.key {
            "transfer_function" if scene.transfer_function.is_none() => {
                settled.transfer_function = None;
            }
            "shading" if scene.shading.is_none() => settled.shading = None,
            "method" if scene.method.is_none() => settled.method = None,
            "preset" if scene.preset.is_none() => settled.preset = None,
            "gradient.of" if scene.gradient.is_none_or(|gradient| gradient.of.is_none()) => {
                if let Some(gradient) = &mut settled.gradient {
                    gradient.of = None;
                }
            }
            _ => {}
        }
    }
}

/// Whether something of a picture has a distance.
fn has_depth(plan: &plan::Plan) -> bool {
    let reports = |technique: &plan::Technique| {
        let text = technique.composite.function().text;
        text.contains("report_hit(")
    };
    !plan.meshes.is_empty()
        || !plan.modules.is_empty()
        || plan.labeled().is_some()
        || plan.drawn_techniques().any(reports)
}

/// A note if pixels have colors that no light has.
fn of_colors(image: &Image) -> Option<Note> {
    // Rounding may leave a little less than nothing.
    let is_light = |number: f32| number.is_finite() && number > -1e-3;
    let is_wrong = |pixel: &&[f32; 4]| !pixel.iter().all(|number| is_light(*number));
    match image.pixels().iter().filter(is_wrong).count() {
        0 => None,
        pixels => Some(Note::NoLight { pixels }),
    }
}

/// A note if the picture shows nothing but its background.
fn of_emptiness(rendered: &Rendered, plan: &plan::Plan, headers: &Headers) -> Option<Note> {
    // There is a note already if every segment is hidden.
    if let Some(labeled) = plan.labeled() {
        let mut looks = labeled.looks.values().chain([&labeled.others]);
        if looks.all(|look| look.technique.is_none()) {
            return None;
        }
    }
    let pixels = rendered.image.pixels();
    let first = *pixels.first()?;
    // All are the color of the background, bit by bit, as nothing was added to it.
    let is_background = match plan.background[3] {
        0.0 => first[3] == 0.0,
        _ => {
            let image = Image::from_pixels(1, 1, vec![plan.background]);
            image.into_linear(plan.compositing).pixels()[0] == first
        }
    };
    let is_empty = is_background && pixels.iter().all(|pixel| *pixel == first);
    is_empty.then(|| Note::Empty {
        why: why_nothing_is_seen(plan, headers),
    })
}

/// The session that a picture is drawn in.
enum SessionHandle<'a> {
    Given(&'a Session),
    /// For this picture alone.
    Own(Box<Session>),
}

impl Deref for SessionHandle<'_> {
    type Target = Session;

    fn deref(&self) -> &Session {
        match self {
            SessionHandle::Given(session) => session,
            SessionHandle::Own(session) => session,
        }
    }
}

impl Session {
    /// Draws `scene` under `control`, on the CPU; [`Render::in_session`] has more settings. The
    /// scene's paths are relative to the current folder.
    ///
    /// # Errors
    /// Any problem with the data or the scene; cancellation.
    pub fn draw(&self, scene: &Scene, control: &Control) -> Result<Picture, Error> {
        Render::scene(scene.clone())
            .in_session(self)
            .control(control)
            .picture()
    }
}

/// What a picture file says about how it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Told {
    /// The scene, with and without defaults, its shader functions, and patterns and textures of its graph. Paths are
    /// relative to the file's folder; of what lies on another branch of the file system only the last name is told.
    #[default]
    Scene,
    /// The scene without what may say whose data it is: of paths only the last names, no series, no files.
    Anonymous,
    /// Nothing.
    Nothing,
}

impl Picture {
    /// A note if a picture in `folder` tells only the names of files of its scene, because they lie on another branch of
    /// the file system: whoever draws it again does not find them.
    pub fn untold_places(&self, folder: &Path) -> Option<Note> {
        let files = names_told_from(folder, &self.scene, &self.made_from.files);
        (!files.is_empty()).then_some(Note::UntoldPlaces { files })
    }

    /// Writes a file with the picture and its scene, as [`Told::Scene`] has it.
    ///
    /// # Errors
    /// If the file cannot be written; nothing is left then.
    pub fn write(&self, encoding: Encoding, output: Output) -> Result<(), Error> {
        self.write_telling(Told::Scene, encoding, output)
    }

    /// Writes a file with the picture, which tells as much as `told` says.
    ///
    /// # Errors
    /// As [`Picture::write`].
    pub fn write_telling(
        &self,
        told: Told,
        encoding: Encoding,
        mut output: Output,
    ) -> Result<(), Error> {
        let (scene, made_from) = (&self.scene, &self.made_from);
        let told = match told {
            Told::Scene => {
                let folder = output.folder();
                let made_from = made_from_told_from(folder, made_from);
                Some((told_from(folder, scene), made_from))
            }
            Told::Anonymous => Some((anonymous(scene), anonymous_made_from(made_from))),
            Told::Nothing => None,
        };
        let recipe =
            told.map(|(scene, made_from)| Recipe::new(scene.to_json()).with_made_from(&made_from));
        write_picture(
            &self.image,
            self.depth_mm.as_deref(),
            &self.display,
            encoding,
            recipe.as_ref(),
            &mut output,
        )?;
        output.finish()
    }

    /// Writes a file: 8-bit PNG or 32-bit EXR, depending on its name.
    ///
    /// # Errors
    /// If the name has another ending, or the file cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let encoding = Encoding::for_path(path.as_ref(), None)?;
        self.write(encoding, Output::create(path.as_ref())?)
    }
}
