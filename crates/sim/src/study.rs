//! Studies: every table and curve of the document's chapter 9, and what goes beyond it, each by one name.

mod beyond;
mod document;
mod extensions;

use crate::Error;
use crate::Nobody;
use crate::picture::{Subject, draw};
use crate::processor::Run;
use crate::report::Report;
use crate::spec::{Light, Spec};
use crate::statistics::Statistics;
use crate::volume_store::VolumeStore;
use rayon::prelude::*;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A study.
pub struct Study {
    /// What it is called.
    pub name: &'static str,
    /// What it asks.
    pub about: &'static str,
    make: fn(&Lab) -> Result<Report, Error>,
}

/// Every study, those of the document first.
pub const STUDIES: [Study; 14] = [
    Study {
        name: "bundle",
        about: "6.1 bundle size against utilisation",
        make: document::bundle,
    },
    Study {
        name: "row-changes",
        about: "6.2 row changes: brute force, unsorted, sorted",
        make: document::row_changes,
    },
    Study {
        name: "order",
        about: "6.3 sort criterion over rotation",
        make: document::order,
    },
    Study {
        name: "rotation",
        about: "6.4 what is skipped and read over rotation, parallel and perspective",
        make: document::rotation,
    },
    Study {
        name: "memory-model",
        about: "6.5 M8, M1 interleaved and M1 linear over rotation",
        make: document::memory_model,
    },
    Study {
        name: "frame-rate",
        about: "6.6 frame rates by classification and size",
        make: document::frame_rate,
    },
    Study {
        name: "motivation",
        about: "6.8 what reading a volume costs",
        make: document::motivation,
    },
    Study {
        name: "transfer",
        about: "tables 7.2 and 7.3: what goes over the bus",
        make: document::transfer,
    },
    Study {
        name: "leaping",
        about: "leaping rules, early termination and adaptive sampling: clocks and pictures",
        make: beyond::leaping,
    },
    Study {
        name: "widths",
        about: "word widths against real numbers: PSNR",
        make: beyond::widths,
    },
    Study {
        name: "scheduling",
        about: "handover, ready-row-first, host: clocks and bubbles",
        make: beyond::scheduling,
    },
    Study {
        name: "dram",
        about: "SDR, DDR4, LPDDR4 and HBM2 timing, refresh and caches",
        make: beyond::dram,
    },
    Study {
        name: "extensions",
        about: "shadows, boards, slabs, polygons, bent rays, the distance engine: clocks and pictures",
        make: extensions::extensions,
    },
    Study {
        name: "volumes",
        about: "several volumes by all orders and memory models",
        make: beyond::volumes,
    },
];

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
type Case<'v> = (String, Spec, &'v VolumeStore);

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

    /// Makes a study.
    ///
    /// # Errors
    /// If there is none of that name, or somebody stops it.
    pub fn study(&self, name: &str) -> Result<Report, Error> {
        let Some(study) = STUDIES.iter().find(|study| study.name == name) else {
            let known: Vec<&str> = STUDIES.iter().map(|study| study.name).collect();
            return Err(Error::Study {
                name: name.to_owned(),
                known: known.join(", "),
            });
        };
        let mut report = (study.make)(self)?;
        study.name.clone_into(&mut report.name);
        Ok(report)
    }

    /// Draws every case, on all cores.
    fn run(&self, cases: Vec<Case>) -> Result<Vec<(Run, Statistics)>, Error> {
        cases
            .into_par_iter()
            .map(|(_, spec, volume)| {
                let progress = |_, _| (self.progress)(self.done.load(Ordering::Relaxed));
                let drawn = draw(&spec, &Subject::of(volume), &mut Nobody, &progress)?;
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
const LINEAR_1000: [[f64; 2]; 2] = [[1000.0, 0.0], [4095.0, 1.0]];
const LINEAR_0: [[f64; 2]; 2] = [[0.0, 0.0], [4095.0, 1.0]];
const THRESHOLD_1300: [[f64; 2]; 2] = [[1300.0, 0.0], [1300.0, 1.0]];

/// The jaw that most figures of the document are about.
fn small_jaw() -> Result<VolumeStore, Error> {
    VolumeStore::new(&crate::jaw([128, 128, 64])?)
}

/// The document's machine with the curve "linear from 1000".
fn document_spec() -> Spec {
    let mut spec = Spec::default();
    spec.look.opacity = LINEAR_1000.to_vec();
    spec.look.lights = vec![Light {
        direction: [-0.4, -1.0, 0.6],
        intensity: 1.0,
    }];
    spec
}

/// A number with a sensible number of digits.
fn digits(value: f64) -> String {
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
