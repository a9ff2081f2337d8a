//! The table of everything that can be typed. Meanings and checks are in [`crate::args`].

mod read;
mod sim;

pub use read::ReadFlags;
pub use sim::{
    SimCommand, SimRunFlags, SimScriptFlags, SimSpecFlags, SimStatsFormat, SimStudyFlags,
};

use clap::builder::PossibleValuesParser;
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;
use strahl::scene::{DebugView, ShadingModel, ToneMap};
use strahl::volume::Phantom;
use strahl::{ColorMap, Method, View, presets};

/// A volume renderer: from a scan to a picture.
#[derive(Debug, Parser)]
#[command(version, propagate_version = true, subcommand_required = true)]
#[command(arg_required_else_help = true, max_term_width = 100)]
pub struct Flags {
    #[command(subcommand)]
    pub command: Command,

    /// Print no progress and no notes
    #[arg(long, short, global = true, help_heading = "General")]
    pub quiet: bool,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    Render(Box<RenderFlags>),
    Demo(Box<DemoFlags>),
    Info(InfoFlags),
    Convert(ConvertFlags),
    /// What scenes may say, whether one is right, and all that one means
    #[command(subcommand)]
    Scene(SceneCommand),
    /// The functions of the ray: the library, and a check of your own
    #[command(subcommand)]
    Shader(ShaderCommand),
    /// Rays programmed by wiring typed nodes: the graph that draws a scene, and your own
    #[command(subcommand)]
    Graph(GraphCommand),
    Presets(PresetsFlags),
    /// A model of a ray-casting processor, clock by clock
    #[command(subcommand)]
    Sim(SimCommand),
    Completions(CompletionsFlags),
}

/// Draw a volume, a scene, or a picture again
#[derive(Debug, Args)]
#[command(after_help = RENDER_EXAMPLES)]
pub struct RenderFlags {
    /// A volume file, a folder with one series, or the slices of one series; or a scene, or a picture
    /// that Strahl made, and after it the volume to draw instead of its own
    #[arg(required = true, value_name = "SCENE | VOLUME")]
    pub inputs: Vec<PathBuf>,

    /// The picture: .png or .exr
    #[arg(long, short, value_name = "PICTURE")]
    pub output: PathBuf,

    #[command(flatten)]
    pub draw: DrawFlags,

    #[command(flatten)]
    pub file: PictureFlags,

    #[command(flatten)]
    pub read: ReadFlags,
}

const RENDER_EXAMPLES: &str = "Examples:
  strahl render head.nii.gz -o head.png
  strahl render dicom-folder/ -o head.png --preset ct-bone --view left
  strahl render bonsai_256x256x256_uint8.raw -o bonsai.png --azimuth 30 --elevation 20
  strahl render brain.nrrd -o brain.png --method mip --size 1920x1080 --transparent
  strahl render engine.nhdr -o engine.png --method first-hit --threshold 120
  strahl render scene.json -o picture.exr --stats json
  strahl render scene.json other-head.nii.gz -o other.png
  strahl render head.png -o again.png --view back";

/// Draw a built-in phantom: a picture without any file
#[derive(Debug, Args)]
#[command(after_help = DEMO_EXAMPLES)]
pub struct DemoFlags {
    /// Which phantom
    #[arg(default_value = "anatomy", value_parser = PossibleValuesParser::new(Phantom::NAMES))]
    pub phantom: String,

    /// The picture: .png or .exr
    #[arg(long, short, value_name = "PICTURE", default_value = "strahl-demo.png")]
    pub output: PathBuf,

    /// Voxels along x, y, z; without, enough to show the phantom well
    #[arg(long, value_name = "X,Y,Z")]
    pub dims: Option<String>,

    #[command(flatten)]
    pub draw: DrawFlags,

    #[command(flatten)]
    pub file: PictureFlags,
}

const DEMO_EXAMPLES: &str = "Examples:
  strahl demo
  strahl demo --preset ct-soft-tissue --view left -o head.png
  strahl demo hydrogen --azimuth 40";

/// What is drawn and how; each of these overrides the scene.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Look")]
pub struct DrawFlags {
    /// Look of a preset instead of the scene's own (`strahl presets` lists them); without preset and
    /// scene it is chosen from modality and values
    #[arg(long, value_name = "NAME", hide_possible_values = true,
          value_parser = PossibleValuesParser::new(presets().iter().map(|preset| preset.name)))]
    pub preset: Option<String>,

    /// A graph, or edits of the graph that the settings make, instead of the scene's own (`strahl graph`)
    #[arg(long, value_name = "FILE")]
    pub graph: Option<PathBuf>,

    /// How the samples of a ray become a pixel
    #[arg(long, value_name = "METHOD", visible_alias = "composite",
          value_parser = PossibleValuesParser::new(Method::ALL.map(Method::name)))]
    pub method: Option<String>,

    /// The value of the surface that first-hit draws
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true)]
    pub threshold: Option<f64>,

    /// Width of the window of values that the transfer function is spread over
    #[arg(long, value_name = "VALUES", allow_negative_numbers = true)]
    pub window: Option<f64>,

    /// Middle of the window
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true)]
    pub level: Option<f64>,

    /// Colours over the window
    #[arg(long, value_name = "MAP",
          value_parser = PossibleValuesParser::new(ColorMap::ALL.map(ColorMap::name)))]
    pub color_map: Option<String>,

    /// Opacity at the low and at the high end of the window, each 0 to 1
    #[arg(long, value_name = "LOW,HIGH", allow_hyphen_values = true)]
    pub opacity: Option<String>,

    /// Light on surfaces, or the plain colours
    #[arg(long, value_name = "MODEL",
          value_parser = PossibleValuesParser::new(ShadingModel::ALL.map(ShadingModel::name)))]
    pub shade: Option<String>,

    /// Draw the segments of this label volume, each in its color
    #[arg(long, value_name = "FILE", help_heading = "Segments")]
    pub labels: Option<PathBuf>,

    /// Draw these segments and no others: an id, or a name with * and ?; repeatable
    #[arg(long, value_name = "SEGMENT", help_heading = "Segments")]
    pub only: Vec<String>,

    /// Draw these segments, too, 0 for the background; repeatable
    #[arg(long, value_name = "SEGMENT", help_heading = "Segments")]
    pub show: Vec<String>,

    /// Leave out these segments; repeatable
    #[arg(long, value_name = "SEGMENT", help_heading = "Segments")]
    pub hide: Vec<String>,

    /// Draw these segments solid and all others as a glimpse; repeatable
    #[arg(long, value_name = "SEGMENT", help_heading = "Segments")]
    pub highlight: Vec<String>,

    /// Keep the side of a plane that its normal points to: the normal (RAS), and the plane's distance
    /// from the world's origin in mm (without, it goes through the volume's centre); repeatable
    #[arg(long, value_name = "X,Y,Z[,MM]", allow_hyphen_values = true)]
    pub clip_plane: Vec<String>,

    /// Keep the inside of a box between two corners in RAS mm; repeatable
    #[arg(long, value_name = "X,Y,Z,X,Y,Z", allow_hyphen_values = true)]
    pub clip_box: Vec<String>,

    /// What --clip-box counts in: RAS mm, voxels, or shares of the volume from 0 to 1
    #[arg(long, value_name = "SPACE", requires = "clip_box",
          value_parser = ["world", "voxels", "fraction"])]
    pub clip_space: Option<String>,

    /// Behind everything: "#rrggbb", black, white or transparent
    #[arg(long, value_name = "COLOR")]
    pub background: Option<String>,

    /// The same as --background transparent
    #[arg(long, conflicts_with = "background")]
    pub transparent: bool,

    /// Multiply the light by this before it becomes display colours
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true)]
    pub exposure: Option<f64>,

    /// How light above white is brought down
    #[arg(long, value_name = "MAP",
          value_parser = PossibleValuesParser::new(ToneMap::ALL.map(ToneMap::name)))]
    pub tone_map: Option<String>,

    /// The light that reinhard-extended and hable make white; without, 4 and 11.2
    #[arg(long, value_name = "LIGHT", allow_negative_numbers = true)]
    pub white_point: Option<f64>,

    /// Encode PNG by the power 1/GAMMA instead of the curve of sRGB
    #[arg(long, value_name = "GAMMA", allow_negative_numbers = true)]
    pub gamma: Option<f64>,

    /// Smooth jagged edges of the finished PNG; --fxaa=off takes it from a scene
    #[arg(long, value_name = "on|off", num_args = 0..=1, require_equals = true,
          default_missing_value = "on", value_parser = ["on", "off"], hide_possible_values = true)]
    pub fxaa: Option<String>,

    /// The side that the volume is seen from; replaces the scene's camera
    #[arg(long, value_name = "SIDE", help_heading = "Camera",
          value_parser = PossibleValuesParser::new(View::ALL.map(View::name)))]
    pub view: Option<String>,

    /// Turn the camera about the up direction, to the right of the picture, in degrees
    #[arg(
        long,
        value_name = "DEG",
        help_heading = "Camera",
        allow_negative_numbers = true
    )]
    pub azimuth: Option<f64>,

    /// Turn the camera up, in degrees
    #[arg(
        long,
        value_name = "DEG",
        help_heading = "Camera",
        allow_negative_numbers = true
    )]
    pub elevation: Option<f64>,

    /// Enlarge; 1 fits the sphere around the volume, without it its box fits
    #[arg(
        long,
        value_name = "FACTOR",
        help_heading = "Camera",
        allow_negative_numbers = true
    )]
    pub zoom: Option<f64>,

    /// How rays spread
    #[arg(long, value_name = "KIND", help_heading = "Camera",
          value_parser = ["perspective", "orthographic"])]
    pub projection: Option<String>,

    /// The point that is looked at, RAS mm
    #[arg(
        long,
        value_name = "X,Y,Z",
        help_heading = "Camera",
        allow_hyphen_values = true
    )]
    pub focus: Option<String>,

    /// Put the eye here instead of on an orbit, RAS mm
    #[arg(long, value_name = "X,Y,Z", help_heading = "Camera", allow_hyphen_values = true,
          conflicts_with_all = ["view", "azimuth", "elevation"])]
    pub position: Option<String>,

    /// Width and height of the picture in pixels
    #[arg(long, value_name = "WxH", help_heading = "Quality")]
    pub size: Option<String>,

    /// Distance between samples in mm
    #[arg(
        long,
        value_name = "MM",
        help_heading = "Quality",
        allow_negative_numbers = true
    )]
    pub step: Option<f64>,

    /// Distance between samples in smallest voxel spacings; without both, 0.5
    #[arg(
        long,
        value_name = "VOXELS",
        help_heading = "Quality",
        allow_negative_numbers = true,
        conflicts_with = "step"
    )]
    pub step_voxels: Option<f64>,

    /// Start every ray elsewhere in its first step, to turn rings into grain
    #[arg(long, value_name = "SEED", help_heading = "Quality")]
    pub jitter: Option<u32>,

    /// How a value between voxels is found
    #[arg(long, value_name = "KIND", help_heading = "Quality",
          value_parser = ["trilinear", "nearest", "b-spline", "b-spline-interpolating", "catmull-rom"])]
    pub reconstruct: Option<String>,

    /// Reconstruction, gradient and light from the cheapest to the best; what is said otherwise counts more
    #[arg(long, value_name = "LEVEL", help_heading = "Quality",
          value_parser = ["null", "minimum", "medium", "maximum"])]
    pub quality: Option<String>,

    /// Draw the mean of this many pictures, each with its own jitter (needs --jitter to differ)
    #[arg(long, value_name = "N", help_heading = "Quality")]
    pub frames: Option<u32>,

    /// Draw how the picture is made instead
    #[arg(long, value_name = "VIEW", help_heading = "Quality",
          value_parser = PossibleValuesParser::new(DebugView::ALL.map(DebugView::name)))]
    pub debug: Option<String>,
}

/// The picture file and how it is made; no part of a scene.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Output")]
pub struct PictureFlags {
    /// Bits per channel: 8 or 16 for PNG, 16 or 32 (floating point) for EXR
    #[arg(long, value_name = "N")]
    pub bits: Option<u32>,

    /// Also write how far away what is seen is (method first-hit, meshes): channel Z of EXR
    #[arg(long)]
    pub depth: bool,

    /// Also write the stages of the picture into this folder, as stage-1.png and so on: soon a coarse one, in the end
    /// the picture (on the CPU only)
    #[arg(long, value_name = "FOLDER")]
    pub stages: Option<PathBuf>,

    /// Threads that draw; without, one per core. The picture is the same
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,

    /// Which renderer draws: `auto` takes the GPU if there is one, `gpu` the GPU or nothing
    #[arg(long, value_name = "BACKEND", default_value = "cpu")]
    pub backend: BackendName,

    /// Part of the name of the graphics adapter that draws (`strahl info --adapters` lists them)
    #[arg(long, value_name = "NAME", conflicts_with_all = ["threads"])]
    pub adapter: Option<String>,

    /// Print timings and counts on stdout
    #[arg(long, value_name = "FORMAT")]
    pub stats: Option<StatsFormat>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum BackendName {
    Auto,
    #[default]
    Cpu,
    Gpu,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum StatsFormat {
    Json,
}

/// Say what is in a volume file or DICOM folder
#[derive(Debug, Args)]
#[command(after_help = INFO_EXAMPLES)]
pub struct InfoFlags {
    /// A volume file, a folder with one series, or the slices of one series
    #[arg(required_unless_present = "adapters", value_name = "FILE")]
    pub volume: Vec<PathBuf>,

    /// List the graphics adapters of this machine instead
    #[arg(long, conflicts_with = "volume")]
    pub adapters: bool,

    /// Print JSON
    #[arg(long)]
    pub json: bool,

    #[command(flatten)]
    pub read: ReadFlags,
}

const INFO_EXAMPLES: &str = "Examples:
  strahl info head.nii.gz
  strahl info dicom-folder/ --series 2
  strahl info bonsai_256x256x256_uint8.raw --json
  strahl info --adapters";

/// Write a volume in another format
#[derive(Debug, Args)]
#[command(after_help = CONVERT_EXAMPLES)]
pub struct ConvertFlags {
    /// A volume file, a folder with one series, or the slices of one series
    #[arg(required = true, value_name = "IN")]
    pub inputs: Vec<PathBuf>,

    /// The new file: .nii, .nii.gz, .nrrd, .mha, .mhd, .npy or .raw
    #[arg(required = true, value_name = "OUT")]
    pub output: PathBuf,

    /// Do not pack the samples of NRRD and MetaImage; NIfTI goes by its name
    #[arg(long)]
    pub uncompressed: bool,

    #[command(flatten)]
    pub read: ReadFlags,
}

const CONVERT_EXAMPLES: &str = "Examples:
  strahl convert dicom-folder/ head.nii.gz
  strahl convert head.nii.gz head.nrrd --uncompressed
  strahl convert heart-4d.nii frame-3.mha --time 3
  strahl convert bonsai_256x256x256_uint8.raw bonsai.nrrd --spacing 0.5";

#[derive(Debug, Subcommand)]
pub enum SceneCommand {
    /// Print the JSON schema of scenes, for editors that complete and check
    #[command(after_help = "Examples:
  strahl scene schema > scene.schema.json")]
    Schema,
    Check(SceneCheckFlags),
    Show(Box<SceneShowFlags>),
}

/// Say what is wrong with scenes, all at once
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl scene check head.json
  strahl scene check scenes/*.json")]
pub struct SceneCheckFlags {
    /// Scene files, or pictures that Strahl made
    #[arg(required = true, value_name = "SCENE")]
    pub scenes: Vec<PathBuf>,
}

/// Print a scene with every default filled in: what `render` would draw with the same words
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl scene show head.nii.gz --preset ct-angio -o head.json
  strahl scene show head.json
  strahl scene show picture.png")]
pub struct SceneShowFlags {
    /// As for `strahl render`
    #[arg(required = true, value_name = "SCENE | VOLUME")]
    pub inputs: Vec<PathBuf>,

    /// Write a scene file, with paths as seen from its folder, instead of printing
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,

    #[command(flatten)]
    pub draw: DrawFlags,

    #[command(flatten)]
    pub read: ReadFlags,
}

/// List the presets, or print one as the scene that it is
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl presets
  strahl presets ct-bone > bone.json
  strahl presets --json")]
pub struct PresetsFlags {
    /// Print this one
    #[arg(hide_possible_values = true, conflicts_with = "json",
          value_parser = PossibleValuesParser::new(presets().iter().map(|preset| preset.name)))]
    pub name: Option<String>,

    /// Print all of them as JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Subcommand)]
pub enum ShaderCommand {
    List(ShaderListFlags),
    Show(ShaderShowFlags),
    Check(ShaderCheckFlags),
    Wgsl(ShaderSceneFlags),
    Cost(ShaderCostFlags),
}

#[derive(Debug, Subcommand)]
pub enum GraphCommand {
    Show(Box<GraphShowFlags>),
    /// Say whether graphs, and scenes with graphs, can be drawn, and what is wrong with them where
    Check(GraphInputFlags),
    /// Print the program that a graph compiles to
    Wgsl(GraphInputFlags),
    Dot(Box<GraphDotFlags>),
    /// Draw a volume by a graph: the same as `strahl render`
    Run(Box<RenderFlags>),
    Patterns(GraphPatternsFlags),
    /// Print the JSON schema of graphs
    Schema,
}

/// Print the graph that draws a scene, after all edits: the standard one if the scene has none of its own
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl graph show scene.json
  strahl graph show head.nii.gz --method mip
  strahl graph show tone.graph.json head.nii.gz > whole.graph.json")]
pub struct GraphShowFlags {
    /// A scene, a graph, a volume, or a scene or graph and a volume
    #[arg(required = true, value_name = "SCENE|GRAPH|VOLUME")]
    pub inputs: Vec<PathBuf>,

    #[command(flatten)]
    pub draw: DrawFlags,
}

#[derive(Debug, Args)]
pub struct GraphInputFlags {
    /// Scenes or graphs; a graph alone is checked over a built-in phantom
    #[arg(required = true, value_name = "SCENE|GRAPH")]
    pub inputs: Vec<PathBuf>,
}

/// Print a graph as a drawing in the language of Graphviz
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl graph dot scene.json --svg graph.svg
  strahl graph dot tone.graph.json --details | dot -Tpng > tone.png")]
pub struct GraphDotFlags {
    /// A scene, a graph, a volume, or a scene or graph and a volume
    #[arg(required = true, value_name = "SCENE|GRAPH|VOLUME")]
    pub inputs: Vec<PathBuf>,

    /// Write an SVG; needs Graphviz
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,

    /// Show types, meanings, constants and what each node does
    #[arg(long)]
    pub details: bool,

    #[command(flatten)]
    pub draw: DrawFlags,
}

/// List the nodes that graphs can use, with their ports
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl graph patterns
  strahl graph patterns opacity
  strahl graph patterns --json")]
pub struct GraphPatternsFlags {
    /// Only those with this in their names
    #[arg(value_name = "WORD")]
    pub names: Vec<String>,

    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// List the slots of the ray, their signatures, and the functions of the library
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl shader list
  strahl shader list --json")]
pub struct ShaderListFlags {
    /// Print JSON, with parameters and needs
    #[arg(long)]
    pub json: bool,
}

/// Print the text of a function of the library, to start one's own from
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl shader show blinn_phong
  strahl shader show classify/table > mine.wgsl")]
pub struct ShaderShowFlags {
    /// Its name, or slot/name
    pub name: String,
}

/// Say whether files are shader functions, for which slot, and what is wrong with them where
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl shader check mine.wgsl
  strahl shader check functions/*.wgsl")]
pub struct ShaderCheckFlags {
    /// The modules
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
}

/// Print the program that draws a scene on a GPU, with a comment per function
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl shader wgsl scene.json
  strahl shader wgsl head.nii.gz > head.wgsl")]
pub struct ShaderSceneFlags {
    /// A scene, a volume, or a picture with its scene
    #[arg(value_name = "SCENE|VOLUME")]
    pub input: PathBuf,
}

/// Count texture reads and instructions of the program that draws a scene
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl shader cost scene.json
  strahl shader cost scene.json --json")]
pub struct ShaderCostFlags {
    /// A scene, a volume, or a picture with its scene
    #[arg(value_name = "SCENE|VOLUME")]
    pub input: PathBuf,

    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Print a script that completes commands and flags in a shell
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl completions bash > ~/.local/share/bash-completion/completions/strahl
  strahl completions zsh > ~/.zfunc/_strahl
  strahl completions fish > ~/.config/fish/completions/strahl.fish")]
pub struct CompletionsFlags {
    /// The shell
    pub shell: clap_complete::Shell,
}
