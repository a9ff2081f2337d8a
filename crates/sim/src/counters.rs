//! What is counted, and what follows from it.

use serde::Serialize;

/// Counts of a run. Every clock is an issued read (of a view or a light ray), a bubble or frozen; every sample of every ray is read or skipped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counters {
    /// Clocks from the first ray to the last result.
    pub clocks: u64,
    /// Reads issued: eight voxels and a distance each.
    pub reads: u64,
    /// Reads of empty cells: only their distance counts.
    pub distance_only_reads: u64,
    /// Reads whose sample goes through the data path.
    pub sample_reads: u64,
    /// Samples that came too late for their ray: read before the news that it had ended reached the queue.
    pub wasted_samples: u64,
    /// Samples leapt over in empty space.
    pub skipped_by_leaping: u64,
    /// Samples left out because rays ended early.
    pub skipped_by_termination: u64,
    /// Samples interpolated instead of read, by adaptive sampling.
    pub skipped_by_adaptive_sampling: u64,
    /// Samples that brute force reads.
    pub samples: u64,
    /// Reads of light rays.
    pub light_reads: u64,
    /// Samples of light rays that brute force reads.
    pub light_samples: u64,
    /// Reads that found a row closed, by the rows of all eight neighbours.
    pub row_stalls: u64,
    /// Rows opened, over all modules.
    pub row_changes: u64,
    /// Row changes as the document counts them: the block of S0 only.
    pub thesis_row_changes: u64,
    /// Rows of the distance store opened.
    pub distance_row_changes: u64,
    /// Clocks frozen for rows.
    pub frozen_for_rows: u64,
    /// Clocks frozen for refreshes.
    pub frozen_for_refresh: u64,
    /// Clocks frozen because a module delivers one word after the other, or a burst.
    pub frozen_for_words: u64,
    /// Clocks frozen for rows of the distance store, beyond those for voxels.
    pub frozen_for_distances: u64,
    /// Clocks without a ray in the queue.
    pub bubbles_empty: u64,
    /// Clocks in which the next ray turned out to have ended.
    pub bubbles_ended: u64,
    /// Clocks in which no ray had its rows open (ready-row-first).
    pub bubbles_rows: u64,
    /// Clocks in which a tile's rays were shifted in (serial handover).
    pub bubbles_filling: u64,
    /// Clocks in which the next tile's parameters were still on the bus.
    pub bubbles_host: u64,
    /// Clocks in which other pipelines had the memory. With n pipelines, n · clocks are reads, bubbles and n · frozen.
    pub bubbles_shared: u64,
    /// Words found in caches …
    pub cache_hits: u64,
    /// … and not found.
    pub cache_misses: u64,
    /// Rays that were sent.
    pub rays: u64,
    /// Rays that ended early.
    pub rays_ended_early: u64,
    /// Tiles drawn.
    pub tiles: u64,
    /// Bytes to and from the host for tiles.
    pub host_bytes: u64,
    /// Clocks of the distance engine, once per classification and beside `clocks`; 0 for software.
    pub coding_clocks: u64,
}

impl Counters {
    /// Frames per second at this clock.
    pub fn frames_per_second(&self, clock_mhz: f64) -> f64 {
        clock_mhz * 1e6 / self.clocks.max(1) as f64
    }

    /// Share of clocks in which a read is issued.
    pub fn utilisation(&self) -> f64 {
        (self.reads + self.light_reads) as f64 / self.clocks.max(1) as f64
    }

    /// Row stalls per read.
    pub fn stalls_per_read(&self) -> f64 {
        self.row_stalls as f64 / (self.reads + self.light_reads).max(1) as f64
    }

    /// Row changes per read, as the document counts.
    pub fn thesis_changes_per_read(&self) -> f64 {
        self.thesis_row_changes as f64 / (self.reads + self.light_reads).max(1) as f64
    }

    /// Clocks frozen, for whatever reason.
    pub fn frozen(&self) -> u64 {
        self.frozen_for_rows
            + self.frozen_for_refresh
            + self.frozen_for_words
            + self.frozen_for_distances
    }

    /// Clocks without a read that are not frozen.
    pub fn bubbles(&self) -> u64 {
        self.bubbles_empty
            + self.bubbles_ended
            + self.bubbles_rows
            + self.bubbles_filling
            + self.bubbles_host
            + self.bubbles_shared
    }

    /// Adds the counts of another frame.
    pub fn add(&mut self, other: &Counters) {
        let fields = [
            (&mut self.clocks, other.clocks),
            (&mut self.reads, other.reads),
            (&mut self.distance_only_reads, other.distance_only_reads),
            (&mut self.sample_reads, other.sample_reads),
            (&mut self.wasted_samples, other.wasted_samples),
            (&mut self.skipped_by_leaping, other.skipped_by_leaping),
            (
                &mut self.skipped_by_termination,
                other.skipped_by_termination,
            ),
            (
                &mut self.skipped_by_adaptive_sampling,
                other.skipped_by_adaptive_sampling,
            ),
            (&mut self.samples, other.samples),
            (&mut self.light_reads, other.light_reads),
            (&mut self.light_samples, other.light_samples),
            (&mut self.row_stalls, other.row_stalls),
            (&mut self.row_changes, other.row_changes),
            (&mut self.thesis_row_changes, other.thesis_row_changes),
            (&mut self.frozen_for_rows, other.frozen_for_rows),
            (&mut self.frozen_for_refresh, other.frozen_for_refresh),
            (&mut self.frozen_for_words, other.frozen_for_words),
            (&mut self.bubbles_empty, other.bubbles_empty),
            (&mut self.bubbles_ended, other.bubbles_ended),
            (&mut self.bubbles_rows, other.bubbles_rows),
            (&mut self.bubbles_filling, other.bubbles_filling),
            (&mut self.bubbles_host, other.bubbles_host),
            (&mut self.bubbles_shared, other.bubbles_shared),
            (&mut self.cache_hits, other.cache_hits),
            (&mut self.cache_misses, other.cache_misses),
            (&mut self.rays, other.rays),
            (&mut self.rays_ended_early, other.rays_ended_early),
            (&mut self.tiles, other.tiles),
            (&mut self.host_bytes, other.host_bytes),
            (&mut self.coding_clocks, other.coding_clocks),
            (&mut self.distance_row_changes, other.distance_row_changes),
            (&mut self.frozen_for_distances, other.frozen_for_distances),
        ];
        for (mine, theirs) in fields {
            *mine += theirs;
        }
    }
}
