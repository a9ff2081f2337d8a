//! From a volume or a scene to a picture: [`Render`] and [`render_file`].

use crate::backend::{Backend, DrawnBy, Wanted, draw};
use crate::note::Note;
use crate::scene_data::{Own, SceneData};
use crate::scene_file::{SceneFile, seen_from};
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
    Background, Camera, Clip, Image, Method, Scene, Stats, TransferFunction, View, VolumeSource,
    plan, resolve_with, settled_with,
};
use strahl_volume::read::ReadOptions;
use strahl_volume::{Control, Phantom, Volume};

/// Draws the volume at `volume_path` (a file, or a folder with one DICOM series or numbered slices)
/// into the picture `picture_path` (`.png` or `.exr`), with everything chosen from the data.
///
/// # Errors
/// Whatever is wrong with either file, by name.
pub fn render_file(
    volume_path: impl AsRef<Path>,
    picture_path: impl AsRef<Path>,
) -> Result<(), Error> {
    Render::file(volume_path).save(picture_path).map(drop)
}

/// A picture in the making: a volume, and what is not left to the defaults.
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
/// Mistakes (an unknown preset, a size of 0) are reported by [`Render::picture`], all at once.
#[derive(Clone)]
#[must_use = "nothing is drawn before `picture` or `save`"]
pub struct Render<'a> {
    source: Source,
    scene: Scene,
    scene_path: Option<PathBuf>,
    options: Options,
    with_depth: bool,
    backend: Backend,
    control: Control,
    show: Option<ShowStage<'a>>,
    session: Option<&'a Session>,
}

#[derive(Clone)]
enum Source {
    /// What `scene.volume` says.
    Scene,
    /// One volume from these files; `scene.volume` says how to read them.
    Files(Vec<PathBuf>),
    /// One that is in memory.
    Volume(Volume),
}

/// What `Render::draw_into` has to say of a picture that lies in a texture.
#[derive(Clone, Debug)]
pub struct Shown {
    /// Exposure and tone map, which whoever shows the texture applies.
    pub display: plan::Display,
    /// The scene with every default filled in.
    pub scene: Scene,
    /// What the user should know.
    pub notes: Vec<Note>,
    /// What drawing has cost.
    pub stats: Stats,
    /// The renderer that has drawn.
    pub drawn_by: DrawnBy,
}

/// A picture, and how it came about.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Linear, premultiplied pixels, background included.
    pub image: Image,
    /// Distance of the first hit or of a mesh from the start of each ray in mm, row by row from the top, infinite
    /// without; only if [`Render::with_depth`] asks for it.
    pub depth_mm: Option<Vec<f32>>,
    /// Exposure and tone map for a file with display colours.
    pub display: plan::Display,
    /// The scene with every default filled in: drawing it again gives this picture.
    pub scene: Scene,
    /// What the user should know: slices left out, fields of the file that were put right.
    pub notes: Vec<Note>,
    /// What drawing has cost.
    pub stats: Stats,
    /// The renderer that has drawn.
    pub drawn_by: DrawnBy,
    /// Reading the volume, or computing the phantom.
    pub read_seconds: f64,
}

impl<'a> Render<'a> {
    /// Draws the volume at `path`: a file, or a folder with one DICOM series or numbered slices.
    pub fn file(path: impl AsRef<Path>) -> Render<'a> {
        Render::files(vec![path.as_ref().to_owned()])
    }

    /// Draws the volume that several files make together: the slices of one series, in any order.
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

    /// Draws a volume that is in memory. (A picture file will not say where it came from.)
    pub fn volume(volume: &Volume) -> Render<'a> {
        Render::new(Source::Volume(volume.clone()), Scene::default())
    }

    /// Draws a scene; its paths count from the current folder.
    pub fn scene(scene: Scene) -> Render<'a> {
        Render::new(Source::Scene, scene)
    }

    /// Draws the scene in a file.
    pub fn scene_file(file: SceneFile) -> Render<'a> {
        Render {
            scene_path: Some(file.path),
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
            backend: Backend::default(),
            control: Control::NONE,
            show: None,
            session: None,
        }
    }

    /// Draws the volume of these files instead of the scene's own.
    pub fn with_files(mut self, paths: Vec<PathBuf>) -> Render<'a> {
        self.source = Source::Files(paths);
        self
    }

    /// Takes the preset called `name`; see [`presets`](strahl_scene::presets).
    pub fn preset(self, name: &str) -> Render<'a> {
        self.with(|scene| scene.preset = Some(name.to_owned()))
    }

    /// How the samples of a ray become a pixel.
    pub fn method(self, method: Method) -> Render<'a> {
        self.with(|scene| scene.method = Some(method))
    }

    /// Draws the surface where the volume has this value.
    pub fn surface(self, threshold: f64) -> Render<'a> {
        self.with(|scene| {
            scene.method = Some(Method::FirstHit);
            scene.threshold = Some(threshold);
        })
    }

    /// Value → colour and opacity.
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

    /// Where the picture is taken from.
    pub fn camera(self, camera: Camera) -> Render<'a> {
        self.with(|scene| scene.camera = Some(camera))
    }

    /// Width and height in pixels.
    pub fn size(self, width: u32, height: u32) -> Render<'a> {
        self.with(|scene| scene.size = Some([width, height]))
    }

    /// What is behind everything.
    pub fn background(self, background: Background) -> Render<'a> {
        self.with(|scene| scene.background = Some(background))
    }

    /// Cuts a part away; may be called several times.
    pub fn clip(self, clip: Clip) -> Render<'a> {
        self.with(|scene| scene.clips.get_or_insert_default().push(clip))
    }

    /// Anything else: changes the scene by hand.
    pub fn with(mut self, change: impl FnOnce(&mut Scene)) -> Render<'a> {
        change(&mut self.scene);
        self
    }

    /// Draws with this many threads; 0, the default, means all cores. The picture is the same.
    pub fn threads(mut self, threads: usize) -> Render<'a> {
        self.options.threads = threads;
        self
    }

    /// Also finds how far away what is seen is: EXR files get a channel `Z`. Method `first-hit` and
    /// meshes have a depth.
    pub fn with_depth(mut self) -> Render<'a> {
        self.with_depth = true;
        self
    }

    /// Draws with this renderer instead of the CPU's.
    pub fn backend(mut self, backend: Backend) -> Render<'a> {
        self.backend = backend;
        self
    }

    /// Reads and draws under `control`, which is told how far that is and may end it.
    pub fn control(mut self, control: &Control) -> Render<'a> {
        self.control = control.clone();
        self
    }

    /// Draws in stages, each of which `show` gets with what a file of it needs: soon a coarse picture, in the end the
    /// finished one. It has the same bytes as without. Of the CPU's renderer only
    /// ([`strahl_cpu::Renderer::refine`]): others refuse it.
    pub fn in_stages(mut self, show: ShowStage<'a>) -> Render<'a> {
        self.show = Some(show);
        self
    }

    /// Draws with what `session` keeps, and leaves there what the next picture can use. Without, everything is given
    /// up with the picture.
    pub fn in_session(mut self, session: &'a Session) -> Render<'a> {
        self.session = Some(session);
        self
    }

    /// Reads and draws.
    ///
    /// # Errors
    /// Whatever is wrong with the volume or the scene; it was cancelled.
    pub fn picture(&self) -> Result<Picture, Error> {
        let start = Instant::now();
        let session = self.session();
        let data = self.data(&session)?;
        let read_seconds = start.elapsed().as_secs_f64();
        let (headers, scene) = (data.headers(), self.known_scene());
        let mut plan = self.checked(resolve_with(&scene, &headers))?;
        plan.with_depth = self.with_depth;
        let graph = match &scene.graph {
            Some(text) => Some(SceneGraph::new(&self.graph_name(), Some(text))?),
            None => None,
        };
        let wanted = Wanted {
            data: &data.datasets(),
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
        let of_data = data.notes.into_iter().map(Note::Data);
        let notes = of_data.chain(drawn.notes).collect();
        Ok(Picture {
            image: drawn.rendered.image,
            depth_mm: drawn.rendered.depth_mm,
            display: plan.display,
            scene: settled_with(&scene, &headers),
            notes,
            stats: drawn.rendered.stats,
            drawn_by: drawn.drawn_by,
            read_seconds,
        })
    }

    /// Reads, and draws into a texture on the device that the session was given ([`Session::on_device`]): the picture does
    /// not come to memory. Backend, threads and depth have no say.
    ///
    /// # Errors
    /// As [`Render::picture`]; a scene with a graph; a texture that is smaller than the picture, lies on another device or
    /// cannot be drawn into.
    #[cfg(feature = "gpu")]
    pub fn draw_into(&self, target: &TextureTarget) -> Result<Shown, Error> {
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
        Ok(Shown {
            display: plan.display,
            scene: settled_with(&scene, &headers),
            notes: data.notes.into_iter().map(Note::Data).collect(),
            stats,
            drawn_by,
        })
    }

    /// The scene that would be drawn, with every default filled in; reads the volume for it, and
    /// draws nothing.
    ///
    /// # Errors
    /// As [`Render::picture`].
    pub fn settled_scene(&self) -> Result<Scene, Error> {
        Ok(self.settle()?.0)
    }

    /// The plan of the scene, with what resolving it has read. Draws nothing.
    ///
    /// # Errors
    /// As [`Render::picture`].
    pub fn plan(&self) -> Result<plan::Plan, Error> {
        Ok(self.settle()?.1)
    }

    /// The graph that draws the scene: its own, or the standard one that its settings make, after all edits.
    ///
    /// # Errors
    /// The text of the graph is wrong, or a file that it names cannot be read.
    #[cfg(feature = "graph")]
    pub fn graph(&self) -> Result<SceneGraph, Error> {
        SceneGraph::new(&self.graph_name(), self.scene.graph.as_ref())
    }

    fn graph_name(&self) -> String {
        match &self.scene_path {
            Some(path) => format!("{}: graph", path.display()),
            None => "graph".to_owned(),
        }
    }

    fn session(&self) -> SessionUsed<'a> {
        match self.session {
            Some(session) => SessionUsed::Given(session),
            None => SessionUsed::Own(Box::default()),
        }
    }

    /// Everything that the scene names.
    fn data(&self, session: &Session) -> Result<SceneData, Error> {
        SceneData::load(session, &self.scene, self.own()?, &self.control)
            .map_err(|error| error.of_scene(&self.scene_path))
    }

    fn settle(&self) -> Result<(Scene, plan::Plan), Error> {
        let headers = self.data(&self.session())?.headers();
        let scene = self.known_scene();
        let plan = self.checked(resolve_with(&scene, &headers))?;
        Ok((settled_with(&scene, &headers), plan))
    }

    /// Draws into the file `path`: PNG in 8 bit or EXR in 32 bit, by its name.
    ///
    /// # Errors
    /// As [`Render::picture`]; if the file cannot be written, which is found before anything is
    /// read.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<Picture, Error> {
        let encoding = Encoding::for_path(path.as_ref(), None)?;
        let output = Output::create(path.as_ref())?;
        let picture = self.picture()?;
        picture.write(encoding, output)?;
        Ok(picture)
    }

    /// The scene as far as a file can say it: several files have no name in a scene, a volume in
    /// memory has none at all.
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
    fn own(&self) -> Result<Own<'_>, Error> {
        let source = match (&self.source, &self.scene.volume) {
            (Source::Volume(volume), _) => return Ok(Own::Volume(volume)),
            (Source::Files(paths), source) => {
                let options = match source {
                    Some(source) => self.read_options(&VolumeSource {
                        path: Some(String::new()),
                        phantom: None,
                        ..source.clone()
                    })?,
                    None => ReadOptions::default(),
                };
                return Ok(Own::Files(paths.clone(), options));
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
                Ok(Own::Phantom(phantom, dims))
            }
            None => {
                let path = PathBuf::from(source.path.clone().unwrap_or_default());
                Ok(Own::Files(vec![path], options))
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

/// The session that a picture is drawn in.
enum SessionUsed<'a> {
    Given(&'a Session),
    /// For this picture alone.
    Own(Box<Session>),
}

impl Deref for SessionUsed<'_> {
    type Target = Session;

    fn deref(&self) -> &Session {
        match self {
            SessionUsed::Given(session) => session,
            SessionUsed::Own(session) => session,
        }
    }
}

impl Session {
    /// Draws `scene` under `control`, on the CPU; [`Render::in_session`] is the same with everything that can be
    /// said. The scene's paths count from the current folder.
    ///
    /// # Errors
    /// Whatever is wrong with the data or the scene; it was cancelled.
    pub fn draw(&self, scene: &Scene, control: &Control) -> Result<Picture, Error> {
        Render::scene(scene.clone())
            .in_session(self)
            .control(control)
            .picture()
    }
}

impl Picture {
    /// Writes a file with the picture and its scene, whose paths are put as seen from the file's
    /// folder.
    ///
    /// # Errors
    /// If the file cannot be written; nothing is left then.
    pub fn write(&self, encoding: Encoding, mut output: Output) -> Result<(), Error> {
        let scene = seen_from(output.folder(), &self.scene);
        let recipe = Recipe::new(scene.to_json());
        write_picture(
            &self.image,
            self.depth_mm.as_deref(),
            &self.display,
            encoding,
            Some(&recipe),
            &mut output,
        )?;
        output.finish()
    }

    /// Writes a file: PNG in 8 bit or EXR in 32 bit, by its name.
    ///
    /// # Errors
    /// If the name has another ending, or the file cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let encoding = Encoding::for_path(path.as_ref(), None)?;
        self.write(encoding, Output::create(path.as_ref())?)
    }
}
