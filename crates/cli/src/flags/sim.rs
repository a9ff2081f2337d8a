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

/// Draw a picture with the simulated processor and count its clocks
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

    /// Spec file with the design of the processor (`strahl sim spec` prints the default)
    #[arg(long, value_name = "FILE")]
    pub spec: Option<PathBuf>,

    /// Change a field of the Spec; repeatable
    #[arg(long, value_name = "PATH=VALUE", allow_hyphen_values = true)]
    pub set: Vec<String>,

    /// Read every sample of every ray: no leaping, no early termination
    #[arg(long)]
    pub brute_force: bool,

    /// Number of voxels of a phantom along x, y and z [default for jaw: 128,128,64]
    #[arg(long, value_name = "X,Y,Z", id = "phantom_dims")]
    pub voxels: Option<String>,

    /// The picture to write: PNG
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    pub output: Option<PathBuf>,

    /// Bits per channel of the picture
    #[arg(long, value_name = "N", default_value = "8", help_heading = "Output",
          value_parser = clap::builder::PossibleValuesParser::new(["8", "16"]))]
    pub bits: String,

    /// Write a picture of the row changes per pixel: PNG
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub row_changes: Option<PathBuf>,

    /// Print all counts to stdout
    #[arg(long, value_name = "FORMAT", help_heading = "Output")]
    pub stats: Option<SimStatsFormat>,

    /// Write the waveforms of the clocks in --window: VCD
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub vcd: Option<PathBuf>,

    /// Write a diagram of the pipeline for the clocks in --window: SVG
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub diagram: Option<PathBuf>,

    /// Clocks of --vcd and --diagram: the first, and the one after the last
    #[arg(
        long,
        value_name = "A..B",
        default_value = "0..80",
        help_heading = "Output"
    )]
    pub window: String,

    /// Write what a host sends to draw one tile: a script for `strahl sim script`
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub host_script: Option<PathBuf>,

    /// Tile of --host-script, from 0 at the bottom left
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = "Output")]
    pub tile: usize,

    /// Write all results on one page: HTML
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

/// Print the default Spec with comments, its JSON schema, or its wires
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

    /// Use words so wide that rounding is invisible
    #[arg(long)]
    pub wide: bool,

    /// Print the JSON schema
    #[arg(long, conflicts_with_all = ["wires", "set", "spec", "wide"])]
    pub schema: bool,

    /// Print every wire with its width
    #[arg(long)]
    pub wires: bool,
}

/// Run a script of accesses to the local bus, and print what they read
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl sim run jaw --voxels 16,16,16 --host-script tile.txt --tile 1
  strahl sim script tile.txt
  strahl sim script tile.txt --set host.single_clocks=9 -o read.txt")]
pub struct SimScriptFlags {
    /// The script: LB_CLK, WAITING, SWR_ACC, SRD_ACC, DDW_ACC, DDR_ACC, one per line
    #[arg(value_name = "FILE")]
    pub script: PathBuf,

    /// Spec file with the design of the processor
    #[arg(long, value_name = "FILE")]
    pub spec: Option<PathBuf>,

    /// Change a field of the Spec; repeatable
    #[arg(long, value_name = "PATH=VALUE", allow_hyphen_values = true)]
    pub set: Vec<String>,

    /// File for what was read [default: stdout]
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// Run a study, or all of them, and write its tables and curves
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl sim study --list
  strahl sim study row-changes -o out/
  strahl sim study all -o out/ --volume engine.nii.gz --volume bonsai.nii.gz --phantom anatomy
  strahl sim study frame-rate -o out/ --large")]
pub struct SimStudyFlags {
    /// Name of the study, or all
    #[arg(required_unless_present = "list", value_name = "NAME")]
    pub name: Option<String>,

    /// Folder for CSV, JSON, SVG, PNG and report.html; created if it does not exist
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

    /// Also simulate 512³ in the study `frame-rate`; takes minutes and 2 GiB
    #[arg(long)]
    pub large: bool,
}
