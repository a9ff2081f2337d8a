//! What a picture is made of.

use crate::volume_store::VolumeStore;
use strahl_volume::Mesh;

/// What is drawn.
#[derive(Clone, Debug)]
pub struct Subject<'a> {
    /// The volume.
    pub volume: &'a VolumeStore,
    /// Those that `merge.volumes` names, in that order.
    pub others: Vec<VolumeStore>,
    /// The mesh that `polygons.shape.file` names.
    pub mesh: Option<Mesh>,
}

impl<'a> Subject<'a> {
    /// One volume and nothing else.
    pub fn of(volume: &'a VolumeStore) -> Subject<'a> {
        Subject {
            volume,
            others: Vec::new(),
            mesh: None,
        }
    }
}
