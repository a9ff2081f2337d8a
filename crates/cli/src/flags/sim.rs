//! `strahl sim`.

use super::read::ReadFlags;
use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;

#[derive(Debug, Subcommand)]
pub enum SimCommand {
    Run(Box<SimRunFlags>),
    Spec(SimSpecFlags),
    Study(SimStudyFlags),
    Script(SimScriptFlags),
}

/// Draw a picture on the modelled processor and count its clocks
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl sim run jaw -o jaw.png
  strahl sim run engine.nii.gz -o engine.png --set view.rotate_z_deg=30 --stats json
  strahl sim run jaw --brute-force --set memory.row_rule=thesis
  strahl sim run jaw --spec mine.json --vcd jaw.vcd --diagram jaw.svg --window 300..400
  strahl sim run scene.json --report run.html")]
pub struct SimRunFlags {
    /// A volume file, a scene, or a phantom: jaw, or one of `strahl demo`
    #[arg(required = true, value_name = "SCENE | VOLUME | PHANTOM")]
    pub inputs: Vec<PathBuf>,

    /// What is built: a Spec (`strahl sim spec` prints the default)
    #[arg(long, value_name = "FILE")]
    pub spec: Option<PathBuf>,

    /// Change a field of the Spec; repeatable
    #[arg(long, value_name = "PATH=VALUE", allow_hyphen_values = true)]
    pub set: Vec<String>,

    /// No leaping and no early termination: every sample of every ray
    #[arg(long)]
    pub brute_force: bool,

    /// Voxels of a phantom along x, y, z; jaw has 128,128,64 without
    #[arg(long, value_name = "X,Y,Z", id = "phantom_dims")]
    pub voxels: Option<String>,

    /// The picture: PNG
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    pub output: Option<PathBuf>,

    /// Bits of the picture: 8 or 16
    #[arg(long, value_name = "N", default_value = "8", help_heading = "Output",
          value_parser = clap::builder::PossibleValuesParser::new(["8", "16"]))]
    pub bits: String,

    /// A picture of the row changes that each pixel's ray met: PNG
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub row_changes: Option<PathBuf>,

    /// Print all counts on stdout
    #[arg(long, value_name = "FORMAT", help_heading = "Output")]
    pub stats: Option<SimStatsFormat>,

    /// Waveforms of the window: VCD
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub vcd: Option<PathBuf>,

    /// A diagram of the pipeline in the window: SVG
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub diagram: Option<PathBuf>,

    /// Clocks of --vcd and --diagram: first and the one behind the last
    #[arg(
        long,
        value_name = "A..B",
        default_value = "0..80",
        help_heading = "Output"
    )]
    pub window: String,

    /// What a host sends to draw one tile of this picture: a script for `strahl sim script`
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub host_script: Option<PathBuf>,

    /// The tile of --host-script, from 0 at the bottom left
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = "Output")]
    pub tile: usize,

    /// Everything on one page: HTML
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub report: Option<PathBuf>,

    #[command(flatten)]
    pub read: ReadFlags,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum SimStatsFormat {
    Json,
    Csv,
}

/// Print the default Spec with comments, its schema, or the wires that it makes
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl sim spec > mine.json
  strahl sim spec --schema > spec.schema.json
  strahl sim spec --set widths.data=12 --wires")]
pub struct SimSpecFlags {
    /// Start from this Spec
    #[arg(long, value_name = "FILE")]
    pub spec: Option<PathBuf>,

    /// Change a field; repeatable
    #[arg(long, value_name = "PATH=VALUE", allow_hyphen_values = true)]
    pub set: Vec<String>,

    /// With words so wide that their rounding cannot be seen
    #[arg(long)]
    pub wide: bool,

    /// Print the JSON schema
    #[arg(long, conflicts_with_all = ["wires", "set", "spec", "wide"])]
    pub schema: bool,

    /// Print every wire with its width
    #[arg(long)]
    pub wires: bool,
}

/// Run the accesses of a host over the local bus, and print what they read
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl sim run jaw --voxels 16,16,16 --host-script tile.txt --tile 1
  strahl sim script tile.txt
  strahl sim script tile.txt --set host.single_clocks=9 -o read.txt")]
pub struct SimScriptFlags {
    /// The script: LB_CLK, WAITING, SWR_ACC, SRD_ACC, DDW_ACC, DDR_ACC, one a line
    #[arg(value_name = "FILE")]
    pub script: PathBuf,

    /// What is built: a Spec
    #[arg(long, value_name = "FILE")]
    pub spec: Option<PathBuf>,

    /// Change a field of the Spec; repeatable
    #[arg(long, value_name = "PATH=VALUE", allow_hyphen_values = true)]
    pub set: Vec<String>,

    /// Where what was read goes; stdout without
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// Make tables and curves of a study, or of all
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl sim study --list
  strahl sim study row-changes -o out/
  strahl sim study all -o out/ --volume engine.nii.gz --volume bonsai.nii.gz --phantom anatomy
  strahl sim study frame-rate -o out/ --large")]
pub struct SimStudyFlags {
    /// Its name, or all
    #[arg(required_unless_present = "list", value_name = "NAME")]
    pub name: Option<String>,

    /// The folder for CSV, JSON, SVG, PNG and report.html; made if it is not there
    #[arg(long, short, value_name = "DIR", required_unless_present = "list")]
    pub output: Option<PathBuf>,

    /// List the studies
    #[arg(long)]
    pub list: bool,

    /// Another volume for the study `volumes`; repeatable
    #[arg(long, value_name = "FILE")]
    pub volume: Vec<PathBuf>,

    /// Another phantom for the study `volumes`; repeatable
    #[arg(long, value_name = "NAME",
          value_parser = clap::builder::PossibleValuesParser::new(strahl::volume::Phantom::NAMES))]
    pub phantom: Vec<String>,

    /// Also simulate 512³ in the study `frame-rate`: minutes and 2 GiB
    #[arg(long)]
    pub large: bool,
}
