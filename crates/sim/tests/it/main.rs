//! The processor against the document's figures, against itself, and against rules that are written down elsewhere.

mod document;
mod dram;
mod extensions;
mod host;
mod invariants;
mod leaping;
mod shadow;

use strahl_sim::{Frame, NoObserver, Run, Spec, VolumeStore, jaw, no_progress, run};
use strahl_volume::{Grid, Metadata, Rescale, Samples, Volume};

fn small_jaw() -> VolumeStore {
    VolumeStore::new(&jaw([128, 128, 64]).unwrap()).unwrap()
}

/// The document's machine with its curve "linear from 1000".
fn jaw_spec() -> Spec {
    let mut spec = Spec::default();
    spec.look.opacity = vec![[1000.0, 0.0], [4095.0, 1.0]];
    spec
}

fn draw(spec: &Spec, volume: &VolumeStore) -> Run {
    run(
        &Frame::new(spec, volume).unwrap(),
        &mut NoObserver,
        &no_progress,
    )
    .unwrap()
}

/// A volume of 8-bit voxels, x fastest.
fn volume_of(dims: [usize; 3], voxels: Vec<u8>) -> VolumeStore {
    let grid = Grid::centered(dims, glam::DVec3::ONE).unwrap();
    let volume = Volume::new(
        grid,
        Samples::U8(voxels),
        Rescale::IDENTITY,
        Metadata::default(),
    );
    VolumeStore::new(&volume.unwrap()).unwrap()
}
