//! What can be typed about labels.

use clap::Args;
use std::path::PathBuf;

/// That the numbers are object ids, and their names.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Labels")]
pub struct LabelFlags {
    /// The numbers are object ids, even if the file does not say so
    #[arg(long)]
    pub as_labels: bool,

    /// Names and colors of the object ids: JSON, CSV, or a table of FreeSurfer, 3D Slicer, ITK-SNAP;
    /// without, those in the file or in a table beside it. Implies --as-labels
    #[arg(long, value_name = "FILE")]
    pub label_table: Option<PathBuf>,
}
