//! What studies are made with: runs on all cores, the machine of the document, numbers in words.

use crate::Error;
use crate::NoObserver;
use crate::picture::draw;
use crate::processor::Run;
use crate::spec::{Light, Spec};
use crate::statistics::Statistics;
use crate::subject::Subject;
use crate::volume_store::VolumeStore;
use rayon::prelude::*;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What studies are made with.
pub struct Lab<'l> {
    /// Volumes beside the phantom, for the study `volumes`: with the curve that suits them, or an empty one.
    pub volumes: Vec<(VolumeStore, Vec<[f64; 2]>)>,
    /// Whether 512³ is simulated too; it takes minutes and 2 GiB.
    pub with_large: bool,
    /// Asked after every tile and told the runs done so far; `Break` ends the study with [`Error::Stopped`].
    pub progress: &'l (dyn Fn(usize) -> ControlFlow<()> + Sync),
    done: AtomicUsize,
}

/// A run to make: a name for its row, what is built, and the volume.
pub type Case<'v> = (String, Spec, &'v VolumeStore);

impl<'l> Lab<'l> {
    /// A laboratory with nothing but the phantom.
    pub fn new(progress: &'l (dyn Fn(usize) -> ControlFlow<()> + Sync)) -> Lab<'l> {
        Lab {
            volumes: Vec::new(),
            with_large: false,
            progress,
            done: AtomicUsize::new(0),
        }
    }

    /// Draws every case, on all cores.
    pub(super) fn run(&self, cases: Vec<Case>) -> Result<Vec<(Run, Statistics)>, Error> {
        cases
            .into_par_iter()
            .map(|(_, spec, volume)| {
                let progress = |_, _| (self.progress)(self.done.load(Ordering::Relaxed));
                let drawn = draw(&spec, &Subject::of(volume), &mut NoObserver, &progress)?;
                self.done.fetch_add(1, Ordering::Relaxed);
                if !drawn.is_complete {
                    return Err(Error::Stopped);
                }
                let statistics = Statistics::new(&volume.name, &spec, &drawn);
                Ok((drawn, statistics))
            })
            .collect()
    }
}

/// Curves of the document.
pub const LINEAR_1000: [[f64; 2]; 2] = [[1000.0, 0.0], [4095.0, 1.0]];
pub const LINEAR_0: [[f64; 2]; 2] = [[0.0, 0.0], [4095.0, 1.0]];
pub const THRESHOLD_1300: [[f64; 2]; 2] = [[1300.0, 0.0], [1300.0, 1.0]];

/// The jaw that most figures of the document are about.
pub fn small_jaw() -> Result<VolumeStore, Error> {
    VolumeStore::new(&crate::jaw([128, 128, 64])?)
}

/// The document's machine with the curve "linear from 1000".
pub fn document_spec() -> Spec {
    let mut spec = Spec::default();
    spec.look.opacity = LINEAR_1000.to_vec();
    spec.look.lights = vec![Light {
        direction: [-0.4, -1.0, 0.6],
        intensity: 1.0,
    }];
    spec
}

/// A number with a sensible number of digits.
pub fn digits(value: f64) -> String {
    let magnitude = value.abs();
    match magnitude {
        m if m >= 100.0 => format!("{value:.0}"),
        m if m >= 10.0 => format!("{value:.1}"),
        m if m >= 0.1 || m == 0.0 => format!("{value:.3}"),
        _ => format!("{value:.5}"),
    }
}

/// 10 log₁₀(1 / mean squared difference) of pictures from 0 to 1, in dB; infinite for identical ones.
pub fn psnr_db(a: &[f32], b: &[f32]) -> f64 {
    let sum: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    -10.0 * (sum / a.len().max(1) as f64).log10()
}
