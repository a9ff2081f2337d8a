//! Draws a Plan on the processor.
//!
//! [`Renderer::new`] prepares a volume once (min/max bricks), [`Renderer::render`] draws Plans of
//! it. A picture has the same bytes whatever the number of threads, the size of tiles and the SIMD
//! width, and with skipping or without.
//!
//! Inside, `march` holds the one ray loop; it goes over packets of rays (`lanes`) and calls the
//! functions of the slots (`library`). `skip` says which lattice points cannot matter, `tiles`
//! spreads the picture over the cores.
//!
//! ```
//! use strahl_cpu::{Options, Renderer, no_progress};
//! use strahl_scene::{Scene, resolve};
//! use strahl_volume::Phantom;
//!
//! let volume = Phantom::Tree.volume([32, 32, 32])?;
//! let scene = Scene::parse("scene", r#"{ "size": [64, 48] }"#)?;
//! let plan = resolve(&scene, &volume.header(), None)?;
//! let drawn = Renderer::new(&volume).render(&plan, &Options::default(), &no_progress)?;
//! assert_eq!((drawn.image.width(), drawn.image.height()), (64, 48));
//! assert!(drawn.stats.samples < drawn.stats.lattice_points);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![warn(missing_docs)]

mod elementary;
mod lanes;
mod library;
mod march;
mod ray;
mod skip;
mod tiles;

use library::fetch::Linear;
use march::{Counts, Slots};
use skip::Skip;
use std::ops::ControlFlow;
use std::time::Instant;
use strahl_scene::{Image, plan::Plan};
use strahl_volume::{Volume, bricks::Bricks, with_samples};

/// Called after every tile, from any thread, with the number of tiles drawn and of all tiles;
/// `Break` ends the picture with [`Error::Cancelled`].
pub type Progress<'p> = &'p (dyn Fn(usize, usize) -> ControlFlow<()> + Sync);

/// A [`Progress`] that does nothing.
pub fn no_progress(_drawn: usize, _total: usize) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Draws Plans of one volume.
pub struct Renderer<'v> {
    volume: &'v Volume,
    bricks: Bricks,
    bricks_seconds: f64,
}

/// What does not change a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Number of threads; 0 means the surrounding rayon pool, by default all cores.
    pub threads: usize,
    /// Edge of a tile in pixels, > 0.
    pub tile: u32,
    /// Whether bricks that cannot show anything are left out.
    pub skip: bool,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            threads: 0,
            tile: 32,
            skip: true,
        }
    }
}

/// A picture and what it has cost.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// The picture.
    pub image: Image,
    /// What it has cost.
    pub stats: Stats,
}

/// What a picture has cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stats {
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
    /// Threads that drew.
    pub threads: usize,
    /// Building the bricks of the volume, once per [`Renderer`].
    pub bricks_seconds: f64,
    /// Preparing the Plan.
    pub prepare_seconds: f64,
    /// Drawing.
    pub draw_seconds: f64,
}

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The caller's progress function asked for it.
    #[error("cancelled")]
    Cancelled,
    /// The Plan was resolved for another volume.
    #[error(
        "the plan is for a grid of {plan:?} voxels, the volume has {volume:?} (or lies elsewhere); resolve the scene with this volume's header"
    )]
    OtherGrid {
        /// Dimensions in the Plan.
        plan: [usize; 3],
        /// Dimensions of the volume.
        volume: [usize; 3],
    },
    /// The step is too short for the length of the rays.
    #[error(
        "a step of {step_mm} mm gives up to {points:.0} samples on a ray; at most 16777216 are possible, take a step of at least {least_mm} mm"
    )]
    StepTooShort {
        /// Of the Plan.
        step_mm: f64,
        /// On the longest diagonal.
        points: f64,
        /// The shortest possible step.
        least_mm: f64,
    },
    /// The option `tile` is 0.
    #[error("tile is 0; allowed: 1 and above")]
    NoTile,
    /// The operating system gave no threads.
    #[error("cannot start {threads} threads: {why}")]
    Threads {
        /// Number asked for.
        threads: usize,
        /// What was said.
        why: String,
    },
}

impl<'v> Renderer<'v> {
    /// Prepares `volume`, on all cores.
    pub fn new(volume: &'v Volume) -> Renderer<'v> {
        let start = Instant::now();
        let bricks = Bricks::new(volume);
        Renderer {
            volume,
            bricks,
            bricks_seconds: start.elapsed().as_secs_f64(),
        }
    }

    /// Draws `plan`.
    ///
    /// # Errors
    /// If the Plan belongs to another grid, its step is too short for f32 to count the samples of a
    /// ray, an option is not allowed, threads cannot be started, or `progress` says stop.
    pub fn render(
        &self,
        plan: &Plan,
        options: &Options,
        progress: Progress,
    ) -> Result<Rendered, Error> {
        self.check(plan, options)?;
        if options.threads == 0 {
            return self.draw(plan, options, progress);
        }
        rayon::ThreadPoolBuilder::new()
            .num_threads(options.threads)
            .build()
            .map_err(|why| Error::Threads {
                threads: options.threads,
                why: why.to_string(),
            })?
            .install(|| self.draw(plan, options, progress))
    }

    fn check(&self, plan: &Plan, options: &Options) -> Result<(), Error> {
        if plan.volume.grid != *self.volume.grid() {
            return Err(Error::OtherGrid {
                plan: plan.volume.grid.dims(),
                volume: self.volume.grid().dims(),
            });
        }
        let points = ray::most_points(plan);
        if points > ray::MAX_POINTS {
            let step_mm = plan.lattice.step_mm;
            return Err(Error::StepTooShort {
                step_mm,
                points,
                least_mm: step_mm * points / ray::MAX_POINTS,
            });
        }
        if options.tile == 0 {
            return Err(Error::NoTile);
        }
        Ok(())
    }

    fn draw(&self, plan: &Plan, options: &Options, progress: Progress) -> Result<Rendered, Error> {
        let start = Instant::now();
        let skip = options
            .skip
            .then(|| Skip::new(&self.bricks, plan))
            .flatten();
        let slots = Slots::new(plan, skip);
        let prepared = Instant::now();
        let (image, counts) = with_samples!(self.volume.samples(), samples => {
            let fetch = Linear::new(self.volume.grid(), samples);
            tiles::draw(plan, &slots, &fetch, options.tile, progress)?
        });
        let stats = Stats {
            rays: u64::from(plan.width) * u64::from(plan.height),
            rays_in_volume: counts.rays_in_volume,
            rays_ended_early: counts.ended_early,
            lattice_points: counts.points,
            samples: counts.samples,
            samples_visible: counts.visible,
            points_skipped: counts.skipped,
            skipped_mm: counts.skipped as f64 * plan.lattice.step_mm,
            threads: rayon::current_num_threads(),
            bricks_seconds: self.bricks_seconds,
            prepare_seconds: (prepared - start).as_secs_f64(),
            draw_seconds: prepared.elapsed().as_secs_f64(),
        };
        Ok(Rendered { image, stats })
    }
}

impl Counts {
    fn plus(self, other: Counts) -> Counts {
        Counts {
            points: self.points + other.points,
            samples: self.samples + other.samples,
            visible: self.visible + other.visible,
            skipped: self.skipped + other.skipped,
            rays_in_volume: self.rays_in_volume + other.rays_in_volume,
            ended_early: self.ended_early + other.ended_early,
        }
    }
}
