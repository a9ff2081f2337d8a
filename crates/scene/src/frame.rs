//! Frames of objects, in which clips may lie.

use glam::DAffine3;
use strahl_volume::Grid;

/// The frame of an object, in which clips may lie.
pub(crate) struct PlacedFrame {
    pub name: String,
    pub world_from_object: DAffine3,
    /// Where the voxels of level 0 lie, if the object shows a volume.
    pub grid: Option<Grid>,
}
