//! Flags for reading a file.

use clap::Args;
use std::str::FromStr;

/// What the file does not contain itself, or which part of it to read.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Reading")]
pub struct ReadFlags {
    /// Time point of a 4-D file, from 0
    #[arg(long, value_name = "K", hide_short_help = true)]
    pub time: Option<usize>,

    /// Level of detail: 0 is full resolution, 1 is half as many voxels along each axis; fractions allowed
    #[arg(long, value_name = "LEVEL", hide_short_help = true)]
    pub level_of_detail: Option<f64>,

    /// Which component of a voxel with several numbers, from 0, or luminance
    ///
    /// By default, colors become luminance, and `strahl convert` keeps all components.
    #[arg(long, value_name = "K", hide_short_help = true)]
    pub component: Option<Component>,

    /// DICOM series: its number in the list, its series number, or the start of its UID
    #[arg(long, value_name = "SERIES", hide_short_help = true)]
    pub series: Option<String>,

    /// Resample a series with missing or uneven slices to an even grid
    #[arg(long, hide_short_help = true)]
    pub allow_gaps: bool,

    /// Number of voxels along x, y and z of a headerless file
    #[arg(long, value_name = "X,Y,Z", hide_short_help = true)]
    pub dims: Option<String>,

    /// Sample type of a headerless file: u8, i8, u16, i16, u32, i32, f32, f64
    #[arg(long = "type", value_name = "TYPE", hide_short_help = true)]
    pub sample_type: Option<String>,

    /// Distance between voxel centers in mm, for files without it; one number or three
    #[arg(
        long,
        value_name = "MM",
        allow_hyphen_values = true,
        hide_short_help = true
    )]
    pub spacing: Option<String>,

    /// Byte order of a headerless file
    #[arg(long, value_name = "ORDER", value_parser = ["little", "big"], hide_short_help = true)]
    pub endian: Option<String>,

    /// Bytes before the first sample of a headerless file
    #[arg(long, value_name = "N", hide_short_help = true)]
    pub header_bytes: Option<u64>,
}

/// How much memory reading may take.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Limits")]
pub struct MemoryFlags {
    /// Refuse files that need more memory, such as 500M or 8G; without, more than the system has left
    #[arg(long, value_name = "BYTES", hide_short_help = true)]
    pub max_memory: Option<String>,
}

/// What becomes of several numbers per voxel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    /// The one at this place, from 0, is taken.
    One(usize),
    /// Colors become luminance.
    Luminance,
}

impl FromStr for Component {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Component, &'static str> {
        match (text, text.parse()) {
            ("luminance", _) => Ok(Component::Luminance),
            (_, Ok(component)) => Ok(Component::One(component)),
            _ => Err("a number from 0, or luminance"),
        }
    }
}
