//! Flags of `strahl graph`.

use super::draw::{DrawFlags, RenderFlags};
use clap::{Args, Subcommand};
use std::path::PathBuf;

#[derive(Debug, Subcommand)]
pub enum GraphCommand {
    Show(Box<GraphShowFlags>),
    /// Check graphs and scenes with graphs, and report every problem
    Check(GraphInputFlags),
    /// Print the WGSL program that a graph compiles to
    Wgsl(GraphInputFlags),
    Dot(Box<GraphDotFlags>),
    /// Draw by a graph: same as `strahl render`
    Run(Box<RenderFlags>),
    Patterns(GraphPatternsFlags),
    /// Print the JSON schema of graphs
    Schema,
}

/// Print the graph that draws a scene, with all edits applied (the standard graph if it has none)
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
    /// Scenes or graphs; a graph without a scene is checked with a built-in phantom
    #[arg(required = true, value_name = "SCENE|GRAPH")]
    pub inputs: Vec<PathBuf>,
}

/// Print a graph in the DOT language of Graphviz
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  strahl graph dot scene.json --svg graph.svg
  strahl graph dot tone.graph.json --details | dot -Tpng > tone.png")]
pub struct GraphDotFlags {
    /// A scene, a graph, a volume, or a scene or graph and a volume
    #[arg(required = true, value_name = "SCENE|GRAPH|VOLUME")]
    pub inputs: Vec<PathBuf>,

    /// Write an SVG file; needs Graphviz
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,

    /// Show types, meanings, constants and the purpose of each node
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
    /// Only nodes with this word in their names
    #[arg(value_name = "WORD")]
    pub names: Vec<String>,

    /// Print JSON
    #[arg(long)]
    pub json: bool,
}
