//! Studies: every table and curve of the document's chapter 9, and what goes beyond it, each by one name.

mod beyond;
mod document;
mod extensions;
mod lab;

use crate::Error;
use crate::report::Report;

pub use lab::{Lab, psnr_db};

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

impl Lab<'_> {
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
}
