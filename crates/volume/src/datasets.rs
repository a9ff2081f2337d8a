//! The data of one picture.

use crate::{Mesh, Volume};

/// The data that one picture is drawn from, in the order in which a Plan counts it.
///
/// ```
/// use strahl_volume::{Datasets, Phantom};
/// let volume = Phantom::Tree.volume([8, 8, 8])?;
/// let data = Datasets::from(&volume);
/// assert_eq!(data.volumes.len(), 1);
/// # Ok::<(), strahl_volume::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Datasets<'v> {
    /// The volumes that objects show.
    pub volumes: Vec<&'v Volume>,
    /// The volumes that clips take as masks.
    pub masks: Vec<&'v Volume>,
    /// The opaque surfaces.
    pub meshes: Vec<&'v Mesh>,
}

impl<'v> From<&'v Volume> for Datasets<'v> {
    /// One volume and nothing else.
    fn from(volume: &'v Volume) -> Datasets<'v> {
        Datasets {
            volumes: vec![volume],
            ..Datasets::default()
        }
    }
}
