//! A picture as a renderer gives it, and what it has cost.

use crate::Image;

/// A picture and what it has cost.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// The picture.
    pub image: Image,
    /// Distance of the first hit or of opaque geometry from the start of each ray in mm, row by row,
    /// infinite without; `None` if the Plan does not ask.
    pub depth_mm: Option<Vec<f32>>,
    /// What it has cost.
    pub stats: Stats,
}

/// What a picture has cost. A renderer that does not do a thing spends 0 seconds on it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stats {
    /// Threads that drew; 0 on a GPU.
    pub threads: usize,
    /// Making bricks of the volumes; nothing where they were known.
    pub bricks_seconds: f64,
    /// Copying data to the device; almost nothing where it was there.
    pub upload_seconds: f64,
    /// Linking the program and making it ready to run; almost nothing for a combination of functions that was drawn
    /// before.
    pub link_seconds: f64,
    /// Preparing the Plan: tables, what bricks can show, parameters.
    pub prepare_seconds: f64,
    /// Drawing, and copying back.
    pub draw_seconds: f64,
    /// What the rays have met; `None` if the renderer does not count it.
    pub counts: Option<Counts>,
}

/// What the rays of a picture have met.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    /// Pixels.
    pub rays: u64,
    /// Rays that had at least one lattice point.
    pub rays_in_volume: u64,
    /// Rays that ended before their last lattice point.
    pub rays_ended_early: u64,
    /// Lattice points of all rays, sampled or not.
    pub lattice_points: u64,
    /// Lattice points at which the volume was reconstructed. (Refining a hit and gradients take
    /// more reconstructions, which are not counted.)
    pub samples: u64,
    /// Samples that took part in their pixel; for emission–absorption those that were not
    /// transparent, for first hit the hits.
    pub samples_visible: u64,
    /// Lattice points that bricks left out.
    pub points_skipped: u64,
    /// The length of ray that bricks left out, in mm.
    pub skipped_mm: f64,
}
