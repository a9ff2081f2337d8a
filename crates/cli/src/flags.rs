//! All commands and flags. [`crate::args`] checks their values.

mod draw;
#[cfg(feature = "graph")]
mod graph;
mod labels;
mod read;
#[cfg(feature = "graph")]
mod shader;
#[cfg(feature = "sim")]
mod sim;

pub use draw::{
    BackendName, DemoFlags, DrawFlags, LimitFlags, PictureFlags, RenderFlags, StatsFormat,
    TrustFlags,
};
#[cfg(feature = "graph")]
pub use graph::{GraphCommand, GraphDotFlags, GraphInputFlags, GraphPatternsFlags, GraphShowFlags};
pub use labels::LabelFlags;
pub use read::{Component, MemoryFlags, ReadFlags};
#[cfg(feature = "graph")]
pub use shader::{
    ShaderCheckFlags, ShaderCommand, ShaderCostFlags, ShaderListFlags, ShaderSceneFlags,
    ShaderShowFlags,
};
#[cfg(feature = "sim")]
pub use sim::{
    SimCommand, SimRunFlags, SimScriptFlags, SimSpecFlags, SimStatsFormat, SimStudyFlags,
};

use clap::builder::PossibleValuesParser;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Args, Parser, Subcommand};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use strahl::scene::PresetInfo;
use strahl::{Recipe, presets};

/// A volume renderer: reads CT, MR, microscopy and simulation data and draws it.
#[derive(Debug, Parser)]
#[command(
    name = "strahl",
    version,
    propagate_version = true,
    subcommand_required = true
)]
#[command(arg_required_else_help = true, max_term_width = 100)]
pub struct Flags {
    #[command(subcommand)]
    pub command: Command,

    /// Print errors only: no progress, no notes
    #[arg(long, short, global = true, help_heading = "General")]
    pub quiet: bool,
}

impl Flags {
    /// The parsed command line. Ends the program after `--help` and after wrong usage.
    pub fn from_command_line() -> Flags {
        Flags::try_parse().unwrap_or_else(|mut error| {
            suggest_output(&mut error, std::env::args_os());
            suggest_preset(&mut error);
            error.exit()
        })
    }
}

/// Adds a suggestion to `error` if the output is missing and an argument looks like one:
/// `strahl render in.nii out.png`.
fn suggest_output(error: &mut clap::Error, arguments: impl Iterator<Item = OsString>) {
    if error.kind() != ErrorKind::MissingRequiredArgument || !error.to_string().contains("--output")
    {
        return;
    }
    // A lone picture is an input: it contains a scene.
    let inputs: Vec<PathBuf> = arguments.skip(2).map(PathBuf::from).collect();
    if let Some(picture) = inputs.iter().skip(1).rfind(|path| is_picture(path)) {
        let name = picture.display();
        let mut suggestions = vec![format!("did you mean '-o {name}'?").into()];
        if let (Some(volume), Ok(Some(_))) = (inputs.first(), Recipe::of_file(picture)) {
            let volume = volume.display();
            let of_scene =
                format!("{name} has a scene; '{name} {volume} -o …' draws it with {volume}");
            suggestions.push(of_scene.into());
        }
        error.insert(
            ContextKind::Suggested,
            ContextValue::StyledStrs(suggestions),
        );
    }
}

/// Whether a file is a picture that can be written, by its name.
pub fn is_picture(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    extension == "png" || extension == "exr"
}

/// Puts the preset that was probably meant into `error`: `ct-bone` for `bone`. clap compares whole names only.
fn suggest_preset(error: &mut clap::Error) {
    let text = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text.as_str()),
        _ => None,
    };
    let is_preset = match error.get(ContextKind::ValidValue) {
        Some(ContextValue::Strings(names)) => names.iter().any(|name| name == presets()[0].name),
        _ => false,
    };
    let near = text(ContextKind::InvalidValue).and_then(PresetInfo::nearest);
    if let (true, ErrorKind::InvalidValue) = (is_preset, error.kind()) {
        match near {
            Some(near) => {
                let near = ContextValue::String(near.to_owned());
                error.insert(ContextKind::SuggestedValue, near);
            }
            // clap's own suggestion compares letters only.
            None => {
                error.remove(ContextKind::SuggestedValue);
            }
        }
    }
}

#[derive(Debug, Subcommand)]
pub enum Command {
    Render(Box<RenderFlags>),
    Demo(Box<DemoFlags>),
    Info(InfoFlags),
    Convert(ConvertFlags),
    /// Check a scene, print it with every default filled in, or print the JSON schema
    #[command(subcommand)]
    Scene(SceneCommand),
    /// List, print and check shader functions, the exchangeable steps of the ray
    #[cfg(feature = "graph")]
    #[command(subcommand)]
    Shader(ShaderCommand),
    /// Print, check and draw render graphs
    #[cfg(feature = "graph")]
    #[command(subcommand)]
    Graph(GraphCommand),
    Presets(PresetsFlags),
    /// Simulate a ray-casting processor clock by clock
    #[cfg(feature = "sim")]
    #[command(subcommand)]
    Sim(SimCommand),
    Completions(CompletionsFlags),
    Man(ManFlags),
}

/// Describe a volume file or DICOM folder
#[derive(Debug, Args)]
#[command(after_help = INFO_EXAMPLES)]
pub struct InfoFlags {
    /// A volume file, a DICOM folder, or the slices of one series
    #[arg(required_unless_present = "adapters", value_name = "FILE")]
    pub volume: Vec<PathBuf>,

    /// List the graphics adapters of this machine instead
    #[arg(long, conflicts_with = "volume")]
    pub adapters: bool,

    /// Print JSON
    #[arg(long)]
    pub json: bool,

    /// Leave out names, descriptions and dates
    #[arg(long, conflicts_with = "adapters")]
    pub anonymous: bool,

    #[command(flatten)]
    pub labels: LabelFlags,

    #[command(flatten)]
    pub read: ReadFlags,

    #[command(flatten)]
    pub memory: MemoryFlags,
}

const INFO_EXAMPLES: &str = "Examples:
  strahl info head.nii.gz
  strahl info dicom-folder/ --series 2
  strahl info organs.nii.gz --label-table organs.csv
  strahl info bonsai_256x256x256_uint8.raw --json
  strahl info --adapters";

/// Convert a volume to another format
#[derive(Debug, Args)]
#[command(after_help = CONVERT_EXAMPLES)]
pub struct ConvertFlags {
    /// A volume file, a DICOM folder, or the slices of one series
    #[arg(required = true, value_name = "IN")]
    pub inputs: Vec<PathBuf>,

    /// The file to write: .nii, .nii.gz, .nrrd, .mha, .mhd, .npy or .raw
    #[arg(required = true, value_name = "OUT")]
    pub output: PathBuf,

    /// Do not compress NRRD and MetaImage (for NIfTI, the name decides)
    #[arg(long)]
    pub uncompressed: bool,

    /// Leave out names, descriptions and dates
    #[arg(long)]
    pub anonymous: bool,

    #[command(flatten)]
    pub labels: LabelFlags,

    #[command(flatten)]
    pub read: ReadFlags,

    #[command(flatten)]
    pub memory: MemoryFlags,
}

const CONVERT_EXAMPLES: &str = "Examples:
  strahl convert dicom-folder/ head.nii.gz
  strahl convert head.nii.gz head.nrrd --uncompressed
  strahl convert heart-4d.nii frame-3.mha --time 3
  strahl convert bonsai_256x256x256_uint8.raw bonsai.nrrd --spacing 0.5";

#[derive(Debug, Subcommand)]
pub enum SceneCommand {
    #[cfg(feature = "schema")]
    /// Print the JSON schema of scenes, for editors
    #[command(after_help = "Examples:
  strahl scene schema > scene.schema.json")]
    Schema,
    Check(SceneCheckFlags),
    Show(Box<SceneShowFlags>),
}

/// Check scenes and report every problem at once
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl scene check head.json
  strahl scene check scenes/*.json")]
pub struct SceneCheckFlags {
    /// Scene files, or pictures made by Strahl
    #[arg(required = true, value_name = "SCENE")]
    pub scenes: Vec<PathBuf>,
}

/// Print a scene with every default filled in: what `render` draws with the same arguments
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl scene show head.nii.gz --preset ct-angio -o head.json
  strahl scene show head.json
  strahl scene show picture.png")]
pub struct SceneShowFlags {
    /// As for `strahl render`
    #[arg(required = true, value_name = "SCENE | VOLUME")]
    pub inputs: Vec<PathBuf>,

    /// Write a scene file instead of printing; its paths are relative to its folder
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,

    #[command(flatten)]
    pub draw: DrawFlags,

    #[command(flatten)]
    pub read: ReadFlags,

    #[command(flatten)]
    pub trust: TrustFlags,
}

/// List the presets, or print one as a scene
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl presets
  strahl presets ct-bone > bone.json
  strahl presets --json")]
pub struct PresetsFlags {
    /// Preset to print
    #[arg(hide_possible_values = true, conflicts_with = "json",
          value_parser = PossibleValuesParser::new(presets().iter().map(|preset| draw::with_gray(preset.name))))]
    pub name: Option<String>,

    /// Print all presets as JSON
    #[arg(long)]
    pub json: bool,
}

/// Print a shell script that completes commands and flags
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl completions bash > ~/.local/share/bash-completion/completions/strahl
  strahl completions zsh > ~/.zfunc/_strahl
  strahl completions fish > ~/.config/fish/completions/strahl.fish")]
pub struct CompletionsFlags {
    /// The shell
    pub shell: clap_complete::Shell,
}

/// Write manual pages: strahl.1, and one page per command
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl man ~/.local/share/man/man1
  strahl man pages")]
pub struct ManFlags {
    /// The folder to write them into; created if it does not exist
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
}
