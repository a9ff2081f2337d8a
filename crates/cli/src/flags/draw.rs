//! Flags of commands that draw.

use super::read::ReadFlags;
use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use strahl::scene::{DebugView, ShadingModel, ToneMap};
use strahl::volume::Phantom;
use strahl::{ColorMap, Method, View, presets};

/// Draw a volume or a scene
#[derive(Debug, Args)]
#[command(after_help = RENDER_SHORT_EXAMPLES, after_long_help = RENDER_EXAMPLES)]
pub struct RenderFlags {
    /// A volume (file, DICOM folder, slices), a scene, or a picture made by Strahl
    ///
    /// A picture made by Strahl contains its scene. A volume after a scene or picture is drawn in place
    /// of the scene's own.
    #[arg(required = true, value_name = "SCENE | VOLUME")]
    pub inputs: Vec<PathBuf>,

    /// The picture to write: .png or .exr
    #[arg(long, short, value_name = "PICTURE")]
    pub output: PathBuf,

    #[command(flatten)]
    pub draw: DrawFlags,

    #[command(flatten)]
    pub file: PictureFlags,

    #[command(flatten)]
    pub read: ReadFlags,

    #[command(flatten)]
    pub trust: TrustFlags,
}

const RENDER_SHORT_EXAMPLES: &str = "Examples:
  strahl render head.nii.gz -o head.png
  strahl render dicom-folder/ -o head.png --preset ct-bone --view left
  strahl render head.png -o again.png --azimuth 30";

const RENDER_EXAMPLES: &str = "Examples:
  strahl render head.nii.gz -o head.png
  strahl render dicom-folder/ -o head.png --preset ct-bone --view left
  strahl render bonsai_256x256x256_uint8.raw -o bonsai.png --azimuth 30 --elevation 20
  strahl render brain.nrrd -o brain.png --method mip --size 1920x1080 --transparent
  strahl render engine.nhdr -o engine.png --method first-hit --threshold 120
  strahl render scene.json -o picture.exr --stats json
  strahl render scene.json other-head.nii.gz -o other.png
  strahl render head.png -o again.png --view back";

/// Draw a built-in phantom, without any file
#[derive(Debug, Args)]
#[command(after_help = DEMO_EXAMPLES)]
pub struct DemoFlags {
    /// Which phantom
    #[arg(default_value = "anatomy", value_parser = PossibleValuesParser::new(Phantom::NAMES))]
    pub phantom: String,

    /// The picture to write: .png or .exr
    #[arg(long, short, value_name = "PICTURE", default_value = "strahl-demo.png")]
    pub output: PathBuf,

    /// Number of voxels along x, y and z [default: depends on phantom]
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

/// A name that may be written in American English, too.
pub(super) fn with_gray(name: &'static str) -> PossibleValue {
    let value = PossibleValue::new(name);
    match name {
        "grey" => value.alias("gray"),
        "inverted-grey" => value.alias("inverted-gray"),
        _ => value,
    }
}

/// What is drawn and how; each flag overrides the scene.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Look")]
pub struct DrawFlags {
    /// Use the look of a preset; `strahl presets` lists them
    ///
    /// By default, the scene chooses the preset. Without a scene, modality and values choose it.
    #[arg(long, value_name = "NAME", hide_possible_values = true,
          value_parser = PossibleValuesParser::new(presets().iter().map(|preset| with_gray(preset.name))))]
    pub preset: Option<String>,

    /// Draw by this graph, or apply these edits to the standard graph (see `strahl graph`)
    #[arg(long, value_name = "FILE", hide_short_help = true)]
    pub graph: Option<PathBuf>,

    /// Composite rule: how the samples of a ray become a pixel
    #[arg(long, value_name = "METHOD", visible_alias = "composite",
          value_parser = PossibleValuesParser::new(Method::ALL.map(Method::name)))]
    pub method: Option<String>,

    /// Value of the surface that first-hit draws; needs --method first-hit
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true)]
    pub threshold: Option<f64>,

    /// Width of the value window that the transfer function covers
    #[arg(long, value_name = "VALUES", allow_negative_numbers = true)]
    pub window: Option<f64>,

    /// Center of the value window
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true)]
    pub level: Option<f64>,

    /// Color map over the value window
    #[arg(long, value_name = "MAP",
          value_parser = PossibleValuesParser::new(ColorMap::ALL.map(|map| with_gray(map.name()))), hide_short_help = true)]
    pub color_map: Option<String>,

    /// Opacity at the low and the high end of the value window, each 0 to 1
    #[arg(
        long,
        value_name = "LOW,HIGH",
        allow_hyphen_values = true,
        hide_short_help = true
    )]
    pub opacity: Option<String>,

    /// Shading model; unlit shows the plain colors
    #[arg(long, alias = "shading", value_name = "MODEL",
          value_parser = PossibleValuesParser::new(ShadingModel::ALL.map(ShadingModel::name)), hide_short_help = true)]
    pub shade: Option<String>,

    /// Draw the segments of this label volume, each in its own color
    ///
    /// It may lie anywhere, with its label table beside it, whatever a scene may read.
    #[arg(long, value_name = "FILE", help_heading = "Segments")]
    pub labels: Option<PathBuf>,

    /// Draw intervals of values as segments: a number of equal ones, such as 4, or the values at which they begin, such as 100,300
    #[arg(
        long,
        value_name = "N|VALUES",
        allow_hyphen_values = true,
        conflicts_with = "labels",
        help_heading = "Segments"
    )]
    pub layers: Option<String>,

    /// Draw only these segments, given by id, by name with * and ?, or by group:NAME; repeat it for more
    #[arg(long, value_name = "SEGMENT", help_heading = "Segments")]
    pub only: Vec<String>,

    /// Also draw these segments, 0 for the background; repeatable
    #[arg(
        long,
        value_name = "SEGMENT",
        help_heading = "Segments",
        hide_short_help = true
    )]
    pub show: Vec<String>,

    /// Hide these segments; repeatable
    #[arg(
        long,
        value_name = "SEGMENT",
        help_heading = "Segments",
        hide_short_help = true
    )]
    pub hide: Vec<String>,

    /// Draw these segments solid and all others faintly; repeatable
    #[arg(long, value_name = "SEGMENT", help_heading = "Segments")]
    pub highlight: Vec<String>,

    /// Cut by a plane, keeping the side that its normal points to
    ///
    /// The numbers are the normal in RAS and the distance of the plane from the world origin in mm.
    /// Without a distance the plane goes through the center of the volume. The flag is repeatable.
    #[arg(long, value_name = "X,Y,Z[,MM]", allow_hyphen_values = true)]
    pub clip_plane: Vec<String>,

    /// Cut by a box, given by two corners in RAS mm, and keep its inside; repeatable
    #[arg(
        long,
        value_name = "X,Y,Z,X,Y,Z",
        allow_hyphen_values = true,
        hide_short_help = true
    )]
    pub clip_box: Vec<String>,

    /// Space of --clip-box: RAS mm, voxels, or fractions of the volume from 0 to 1
    #[arg(long, value_name = "SPACE", requires = "clip_box",
          value_parser = ["world", "voxels", "fraction"], hide_short_help = true)]
    pub clip_space: Option<String>,

    /// Background color: "#rrggbb", black, white or transparent
    #[arg(long, value_name = "COLOR")]
    pub background: Option<String>,

    /// Same as --background transparent
    #[arg(long, conflicts_with = "background", hide_short_help = true)]
    pub transparent: bool,

    /// Multiply the light by this factor before tone mapping
    #[arg(
        long,
        value_name = "FACTOR",
        allow_negative_numbers = true,
        hide_short_help = true
    )]
    pub exposure: Option<f64>,

    /// Tone map: how light brighter than white is compressed
    #[arg(long, value_name = "MAP",
          value_parser = PossibleValuesParser::new(ToneMap::ALL.map(ToneMap::name)), hide_short_help = true)]
    pub tone_map: Option<String>,

    /// Light that becomes white with reinhard-extended and hable [default: 4 and 11.2]
    #[arg(
        long,
        value_name = "LIGHT",
        allow_negative_numbers = true,
        hide_short_help = true
    )]
    pub white_point: Option<f64>,

    /// Encode the PNG with the power 1/GAMMA instead of the sRGB curve
    #[arg(
        long,
        value_name = "GAMMA",
        allow_negative_numbers = true,
        hide_short_help = true
    )]
    pub gamma: Option<f64>,

    /// Smooth jagged edges of the finished PNG; --fxaa=off overrides a scene
    #[arg(long, value_name = "on|off", num_args = 0..=1, require_equals = true,
          default_missing_value = "on", value_parser = ["on", "off"], hide_possible_values = true, hide_short_help = true)]
    pub fxaa: Option<String>,

    /// Side that the volume is seen from; replaces the scene's camera
    #[arg(long, value_name = "SIDE", help_heading = "Camera",
          value_parser = PossibleValuesParser::new(View::ALL.map(View::name)))]
    pub view: Option<String>,

    /// Turn the camera about the up direction, to the right of the picture
    #[arg(
        long,
        value_name = "DEG",
        help_heading = "Camera",
        allow_negative_numbers = true
    )]
    pub azimuth: Option<f64>,

    /// Raise the camera
    #[arg(
        long,
        value_name = "DEG",
        help_heading = "Camera",
        allow_negative_numbers = true
    )]
    pub elevation: Option<f64>,

    /// Enlarge; 1 fits the bounding sphere [default: the bounding box fits]
    #[arg(
        long,
        value_name = "FACTOR",
        help_heading = "Camera",
        allow_negative_numbers = true
    )]
    pub zoom: Option<f64>,

    /// Projection
    #[arg(long, value_name = "KIND", help_heading = "Camera",
          value_parser = ["perspective", "orthographic"], hide_short_help = true)]
    pub projection: Option<String>,

    /// Point that the camera looks at, RAS mm
    #[arg(
        long,
        value_name = "X,Y,Z",
        help_heading = "Camera",
        allow_hyphen_values = true,
        hide_short_help = true
    )]
    pub focus: Option<String>,

    /// Put the camera at this position instead of on an orbit, RAS mm
    #[arg(long, value_name = "X,Y,Z", help_heading = "Camera", allow_hyphen_values = true,
          conflicts_with_all = ["view", "azimuth", "elevation"], hide_short_help = true)]
    pub position: Option<String>,

    /// Width and height of the picture in pixels [default: 1024x1024]
    #[arg(long, value_name = "WxH", help_heading = "Quality")]
    pub size: Option<String>,

    /// Distance between samples in mm
    #[arg(
        long,
        value_name = "MM",
        help_heading = "Quality",
        allow_negative_numbers = true,
        hide_short_help = true
    )]
    pub step: Option<f64>,

    /// Distance between samples in units of the smallest voxel spacing [default: 0.5]
    #[arg(
        long,
        value_name = "VOXELS",
        help_heading = "Quality",
        allow_negative_numbers = true,
        conflicts_with = "step",
        hide_short_help = true
    )]
    pub step_voxels: Option<f64>,

    /// Shift the samples of every ray by a random part of a step: turns rings into grain
    #[arg(
        long,
        value_name = "SEED",
        help_heading = "Quality",
        hide_short_help = true
    )]
    pub jitter: Option<u32>,

    /// Interpolation between voxels
    #[arg(long, value_name = "KIND", help_heading = "Quality",
          value_parser = ["trilinear", "nearest", "b-spline", "b-spline-interpolating", "catmull-rom"], hide_short_help = true)]
    pub reconstruct: Option<String>,

    /// Interpolation, gradient and shading from cheapest to best; other flags and keys take precedence
    #[arg(long, value_name = "LEVEL", help_heading = "Quality", hide_short_help = true,
          value_parser = ["null", "minimum", "medium", "maximum"])]
    pub quality: Option<String>,

    /// Draw the mean of this many pictures, each with its own jitter (needs --jitter)
    #[arg(
        long,
        value_name = "N",
        help_heading = "Quality",
        hide_short_help = true
    )]
    pub frames: Option<u32>,

    /// Draw a debug view instead of the data
    #[arg(long, value_name = "VIEW", help_heading = "Quality",
          value_parser = PossibleValuesParser::new(DebugView::ALL.map(DebugView::name)), hide_short_help = true)]
    pub debug: Option<String>,
}

/// The picture file and how it is made; not part of a scene.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Output")]
pub struct PictureFlags {
    /// Bits per channel: 8 or 16 for PNG, 16 or 32 (floating point) for EXR
    #[arg(long, value_name = "N", hide_short_help = true)]
    pub bits: Option<u32>,

    /// Also write the depth of first-hit surfaces and meshes: channel Z of EXR
    #[arg(long, hide_short_help = true)]
    pub depth: bool,

    /// Also write coarse stages of the picture into this folder while it is drawn (CPU only)
    ///
    /// The files are called stage-1.png and so on; the last one is the picture.
    #[arg(long, value_name = "FOLDER", hide_short_help = true)]
    pub stages: Option<PathBuf>,

    /// Number of threads that draw; the picture does not depend on it [default: one per core]
    #[arg(long, value_name = "N", hide_short_help = true)]
    pub threads: Option<usize>,

    /// Renderer: auto uses a GPU if there is one; gpu fails without a graphics adapter
    #[arg(long, value_name = "BACKEND", default_value = "cpu")]
    pub backend: BackendName,

    /// Use the graphics adapter with this in its name (`strahl info --adapters` lists them)
    #[arg(long, value_name = "NAME", conflicts_with_all = ["threads"], hide_short_help = true)]
    pub adapter: Option<String>,

    /// Print timings and counts to stdout
    #[arg(long, value_name = "FORMAT", hide_short_help = true)]
    pub stats: Option<StatsFormat>,

    /// Tell nothing in the picture that may say whose data it shows: of files only the names, no series
    #[arg(long, hide_short_help = true)]
    pub anonymous: bool,

    /// Write the picture without the scene that made it
    #[arg(long, conflicts_with = "anonymous", hide_short_help = true)]
    pub no_recipe: bool,

    #[command(flatten)]
    pub limits: LimitFlags,
}

/// What a scene may read.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Limits")]
pub struct TrustFlags {
    /// Let the scene read nothing outside of this folder but what the command line names; the scene of a picture reads
    /// only beside the picture, if not said
    #[arg(long, value_name = "FOLDER", hide_short_help = true)]
    pub confine: Option<PathBuf>,
}

/// How much a picture may take.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Limits")]
pub struct LimitFlags {
    /// Refuse what needs more memory, such as 500M or 8G; without, more than the system has left
    #[arg(
        long,
        value_name = "BYTES",
        conflicts_with = "force",
        hide_short_help = true
    )]
    pub max_memory: Option<String>,

    /// Refuse what would take longer than so many seconds, and end after them; without, refuse what would take more
    /// than half an hour
    #[arg(
        long,
        value_name = "SECONDS",
        conflicts_with = "force",
        hide_short_help = true
    )]
    pub max_time: Option<f64>,

    /// Draw it, however much it takes
    #[arg(long, hide_short_help = true)]
    pub force: bool,
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
