//! Formats by the endings of names, and what each of them keeps.

use super::raw;
use crate::error::Error;
use crate::{SampleType, Volume};

/// The kinds of file that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// NIfTI-1 in one file; NIfTI-2 where NIfTI-1 has no room (an axis above 32767).
    Nifti,
    /// NIfTI packed with gzip.
    NiftiGz,
    /// NRRD, header and samples in one file.
    Nrrd,
    /// MetaImage, header and samples in one file.
    Mha,
    /// MetaImage, a header and a file of samples beside it (`.raw`, packed: `.zraw`).
    Mhd,
    /// A NumPy array of shape (z, y, x).
    Npy,
    /// The samples alone, x fastest, little endian.
    Raw,
}

impl Format {
    /// The format that the end of a file's name stands for, in any case.
    ///
    /// # Errors
    /// Names the endings that are known.
    pub fn of_name(name: &str) -> Result<Format, Error> {
        const ENDINGS: [(&str, Format); 7] = [
            (".nii.gz", Format::NiftiGz),
            (".nii", Format::Nifti),
            (".nrrd", Format::Nrrd),
            (".mha", Format::Mha),
            (".mhd", Format::Mhd),
            (".npy", Format::Npy),
            (".raw", Format::Raw),
        ];
        let lower = name.to_ascii_lowercase();
        ENDINGS
            .iter()
            .find(|(ending, _)| lower.ends_with(ending))
            .map(|&(_, format)| format)
            .ok_or_else(|| {
                let known: Vec<&str> = ENDINGS.iter().map(|(ending, _)| *ending).collect();
                Error::field(
                    "the file's name",
                    format!("`{name}`"),
                    format!("a name that ends in one of {}", known.join(", ")),
                )
            })
    }

    /// Whether files of this format keep several numbers per voxel.
    pub fn keeps_components(self) -> bool {
        !matches!(self, Format::Npy | Format::Raw)
    }

    /// Whether a file of this format keeps the numbers of these volumes, one for each number of a voxel, as colors.
    pub fn keeps_colors(self, volumes: &[Volume]) -> bool {
        let Some(first) = volumes.first() else {
            return false;
        };
        let count = volumes.len();
        first.metadata().components.are_colors
            && match self {
                Format::Nifti | Format::NiftiGz => {
                    first.sample_type() == SampleType::U8 && matches!(count, 3 | 4)
                }
                Format::Nrrd => matches!(count, 3 | 4),
                Format::Mha | Format::Mhd => {
                    raw::value_type_of(volumes) == SampleType::U8 && matches!(count, 2..=4)
                }
                Format::Npy | Format::Raw => false,
            }
    }

    /// Whether files of this format say where their voxels lie in the world.
    pub fn keeps_place(self) -> bool {
        !matches!(self, Format::Npy | Format::Raw)
    }

    /// Whether it says that numbers are object ids.
    pub fn marks_labels(self) -> bool {
        matches!(self, Format::Nifti | Format::NiftiGz | Format::Nrrd)
    }

    /// Whether it keeps the names and colors of object ids.
    pub fn keeps_label_names(self) -> bool {
        self == Format::Nrrd
    }
}
