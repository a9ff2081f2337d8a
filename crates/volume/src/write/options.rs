//! How files are written.

use crate::Label;

/// How to write.
#[derive(Clone, Debug, PartialEq)]
pub struct WriteOptions {
    /// Packs the samples of NRRD (gzip) and MetaImage (zlib). NIfTI goes by its name; npy and raw
    /// are never packed.
    pub compress: bool,
    /// The names and colors if the samples are object ids: NRRD keeps them as 3D Slicer does, NIfTI
    /// keeps only that they are ids.
    pub labels: Option<Vec<Label>>,
}

impl Default for WriteOptions {
    fn default() -> WriteOptions {
        WriteOptions {
            compress: true,
            labels: None,
        }
    }
}
