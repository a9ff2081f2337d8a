//! What can be typed about reading a file.

use clap::Args;

/// What the file does not say itself, or which part of it to take.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Reading")]
pub struct ReadFlags {
    /// Time point of a 4-D file, from 0
    #[arg(long, value_name = "K")]
    pub time: Option<usize>,

    /// Level of detail: 0 is all voxels, 1 half as many along each axis, 1.5 between 1 and 2
    #[arg(long, value_name = "LEVEL")]
    pub level_of_detail: Option<f64>,

    /// Which of several numbers per voxel, from 0; without, colours become luminance
    #[arg(long, value_name = "K")]
    pub component: Option<usize>,

    /// Series of a DICOM folder: its number in the list, its series number, or the start of its UID
    #[arg(long, value_name = "SERIES")]
    pub series: Option<String>,

    /// Resample a series with missing or uneven slices to the even grid
    #[arg(long)]
    pub allow_gaps: bool,

    /// Voxels along x, y, z of a headerless file
    #[arg(long, value_name = "X,Y,Z")]
    pub dims: Option<String>,

    /// Sample type of a headerless file: u8, i8, u16, i16, u32, i32, f32, f64
    #[arg(long = "type", value_name = "TYPE")]
    pub sample_type: Option<String>,

    /// Distance between voxel centres in mm, for files that do not say; one number or three
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    pub spacing: Option<String>,

    /// Byte order of a headerless file
    #[arg(long, value_name = "ORDER", value_parser = ["little", "big"])]
    pub endian: Option<String>,

    /// Bytes before the first sample of a headerless file
    #[arg(long, value_name = "N")]
    pub header_bytes: Option<u64>,
}
