//! Counts and what follows from them, as JSON and CSV.

use crate::Error;
use crate::counters::Counters;
use crate::processor::Run;
use crate::spec::Spec;
use serde::Serialize;
use std::fmt::Write;

/// What a run says about itself.
#[derive(Clone, Debug, Serialize)]
pub struct Statistics {
    /// Name of the volume.
    pub volume: String,
    /// Whether the run came to its end.
    pub is_complete: bool,
    /// Pixels per row and rows.
    pub size: [u32; 2],
    /// Frames per second at the clock of the Spec.
    pub frames_per_second: f64,
    /// Share of clocks in which a read is issued; of several boards their mean.
    pub utilisation: f64,
    /// Row stalls per read.
    pub stalls_per_read: f64,
    /// Row changes per read as the document counts them.
    pub thesis_changes_per_read: f64,
    /// Shares of all samples, in percent: leapt over, left out by early termination, distance-only reads, samples read.
    pub percent_of_samples: [f64; 4],
    /// The counts.
    pub counters: Counters,
    /// Clocks of every slab or board, if there are several.
    pub clocks_of_part: Vec<u64>,
    /// The Spec that was run.
    pub spec: Spec,
}

impl Statistics {
    /// Of a run.
    pub fn new(volume: &str, spec: &Spec, run: &Run) -> Statistics {
        let counters = run.counters;
        Statistics {
            volume: volume.to_owned(),
            is_complete: run.is_complete,
            size: run.size,
            frames_per_second: counters.frames_per_second(spec.clock_mhz),
            utilisation: counters.utilisation() / f64::from(spec.merge.boards),
            stalls_per_read: counters.stalls_per_read(),
            thesis_changes_per_read: counters.thesis_changes_per_read(),
            percent_of_samples: percent_of_samples(&counters),
            counters,
            clocks_of_part: run.clocks_of_part.clone(),
            spec: spec.clone(),
        }
    }

    /// As JSON.
    ///
    /// # Errors
    /// Never, in practice: everything in it can be written.
    pub fn to_json(&self) -> Result<String, Error> {
        serde_json::to_string_pretty(self)
            .map(|text| text + "\n")
            .map_err(|error| Error::File {
                file: "statistics".to_owned(),
                problem: error.to_string(),
            })
    }

    /// As CSV: one line of names, one of numbers.
    pub fn to_csv(&self) -> String {
        let mut names =
            String::from("volume,is_complete,width,height,frames_per_second,utilisation");
        let mut numbers = format!(
            "{},{},{},{},{},{}",
            self.volume.replace(',', " "),
            self.is_complete,
            self.size[0],
            self.size[1],
            self.frames_per_second,
            self.utilisation
        );
        for (name, value) in counts(&self.counters) {
            let _ = write!(names, ",{name}");
            let _ = write!(numbers, ",{value}");
        }
        format!("{names}\n{numbers}\n")
    }
}

/// Name and number of every count.
pub fn counts(counters: &Counters) -> Vec<(String, u64)> {
    let value = serde_json::to_value(counters).unwrap_or_default();
    let object = value.as_object().cloned().unwrap_or_default();
    object
        .into_iter()
        .map(|(name, value)| (name, value.as_u64().unwrap_or(0)))
        .collect()
}

/// Leapt over, left out by early termination, distance-only reads, samples read: percent of what brute force reads.
pub fn percent_of_samples(counters: &Counters) -> [f64; 4] {
    let all = counters.samples.max(1) as f64;
    [
        counters.skipped_by_leaping,
        counters.skipped_by_termination,
        counters.distance_only_reads,
        counters.sample_reads,
    ]
    .map(|n| 100.0 * n as f64 / all)
}
