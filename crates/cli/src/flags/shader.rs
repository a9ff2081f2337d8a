//! Flags of `strahl shader`.

use clap::{Args, Subcommand};
use std::path::PathBuf;

#[derive(Debug, Subcommand)]
pub enum ShaderCommand {
    List(ShaderListFlags),
    Show(ShaderShowFlags),
    Check(ShaderCheckFlags),
    Wgsl(ShaderSceneFlags),
    Cost(ShaderCostFlags),
}

/// List the slots, their signatures, and the functions of the library
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl shader list
  strahl shader list --json")]
pub struct ShaderListFlags {
    /// Print JSON, with parameters and needs
    #[arg(long)]
    pub json: bool,
}

/// Print the source of a library function, to start your own from it
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl shader show blinn_phong
  strahl shader show classify/table > mine.wgsl")]
pub struct ShaderShowFlags {
    /// Name of the function, or slot/name
    pub name: String,
}

/// Check files with shader functions and report every problem
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl shader check mine.wgsl
  strahl shader check functions/*.wgsl")]
pub struct ShaderCheckFlags {
    /// WGSL files
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
}

/// Print the WGSL program that draws a scene on a GPU
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl shader wgsl scene.json
  strahl shader wgsl head.nii.gz > head.wgsl")]
pub struct ShaderSceneFlags {
    /// A scene, a volume, or a picture made by Strahl
    #[arg(value_name = "SCENE|VOLUME")]
    pub input: PathBuf,
}

/// Count the texture reads and instructions of the program that draws a scene
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl shader cost scene.json
  strahl shader cost scene.json --json")]
pub struct ShaderCostFlags {
    /// A scene, a volume, or a picture made by Strahl
    #[arg(value_name = "SCENE|VOLUME")]
    pub input: PathBuf,

    /// Print JSON
    #[arg(long)]
    pub json: bool,
}
