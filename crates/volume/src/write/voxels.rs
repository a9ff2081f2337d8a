//! Numbers of voxels that are written.

use crate::Volume;
use crate::error::{Error, ErrorKind};

/// What is written: one number per voxel, or several.
pub(crate) struct Voxels<'a> {
    /// Place, rescale and metadata of all of them.
    pub(crate) first: &'a Volume,
    /// One for each number of a voxel, all of one grid, type and rescale.
    pub(crate) all: &'a [Volume],
}

impl<'a> Voxels<'a> {
    /// Checks that the volumes belong together.
    ///
    /// # Errors
    /// None, or such that differ in grid, type or rescale.
    pub(crate) fn new(all: &'a [Volume]) -> Result<Voxels<'a>, Error> {
        let first = all
            .first()
            .ok_or_else(|| Error::field("number of components", 0, "1 or more"))?;
        let kind = |volume: &Volume| (*volume.grid(), volume.sample_type(), volume.rescale());
        match all.iter().all(|volume| kind(volume) == kind(first)) {
            true => Ok(Voxels { first, all }),
            false => Err(ErrorKind::Unsupported {
                feature: "a file of components that differ in grid, type or rescale".into(),
                instead: "write one of them".into(),
            }
            .into()),
        }
    }
}
