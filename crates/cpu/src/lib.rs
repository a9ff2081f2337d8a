//! Draws a Plan on the processor.
//!
//! [`Renderer::new`] prepares a volume once (min/max bricks), [`Renderer::render`] draws Plans of
//! it. A picture has the same bytes whatever the number of threads, the size of tiles and the SIMD
//! width, and with skipping or without.
//!
//! Inside, `march` holds the one ray loop, compiled for each instruction set (`levels`); it goes over
//! packets of rays (`lanes`, and `doubles` where the lattice is laid) and calls the
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

mod clipped;
mod doubles;
mod elementary;
mod even;
mod kept;
#[cfg(feature = "bench-kernels")]
#[doc(hidden)]
pub mod kernels;
mod lanes;
mod levels;
mod library;
mod march;
mod meshes;
mod of_bricks;
mod ray;
mod refine;
mod rejection;
mod scenery;
mod skip;
mod strides;
mod tiles;

pub use levels::InstructionSet;
pub use refine::Stage;

use clipped::{Clipped, Masks, RecentClipped};
use even::EvenCubes;
use levels::{Level, Task, dispatch};
use library::classify::RecentIntegrals;
use library::fetch::{MarschnerLobb, Noise, Shape};
use library::jitter::Jitters;
use library::reconstruct::{Values, of_fetch, values};
use library::shade::Shading;
use march::Counts;
use meshes::Meshes;
use of_bricks::RecentOfBricks;
use rejection::{OfCubic, Rejection};
use scenery::{Object, Scenery, Stored};
use skip::{Recent, Skip};
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Instant;
use strahl_scene::Image;
use strahl_scene::plan::{ClipShape, Fetch, Plan, PlanObject, Reconstruct, Sampling};
use strahl_volume::bricks::{BrickRange, Bricks};
use strahl_volume::{Datasets, Rescale, Volume};
use strides::Strides;
use tiles::Raster;

/// Called after every tile, from any thread, with the number of tiles drawn and of all tiles;
/// `Break` ends the picture with [`Error::Cancelled`].
pub type Progress<'p> = &'p (dyn Fn(usize, usize) -> ControlFlow<()> + Sync);

/// A [`Progress`] that does nothing.
pub fn no_progress(_drawn: usize, _total: usize) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Draws Plans of the same data.
pub struct Renderer<'v> {
    data: Datasets<'v>,
    /// Of each volume.
    bricks: Vec<Bricks>,
    bricks_seconds: f64,
    /// What is known of them.
    recent: Recent,
    recent_of_bricks: RecentOfBricks,
    recent_integrals: RecentIntegrals,
    recent_clipped: RecentClipped,
    masks: Masks<'v>,
    /// Of the volume with this number: made when a Plan first asks for it.
    coefficients: Mutex<Vec<Option<Arc<Coefficients>>>>,
    /// Likewise, of the voxels themselves.
    of_cubic: Vec<OnceLock<OfCubic>>,
    meshes: Meshes,
}

/// What an interpolating B-spline reads in place of the voxels.
struct Coefficients {
    volume: Volume,
    of_cubic: OfCubic,
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
    /// The instructions to draw with; `None` takes what `STRAHL_SIMD` says, or the fastest that the
    /// processor has.
    pub instructions: Option<InstructionSet>,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            threads: 0,
            tile: 32,
            skip: true,
            instructions: None,
        }
    }
}

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
    /// The Plan counts more data than was handed over.
    #[error(
        "the plan needs {what} number {index}, of which {there} were handed to the renderer; hand over the data that the plan was resolved for"
    )]
    NoData {
        /// `volume`, `mask` or `mesh`.
        what: &'static str,
        /// Which one, from 0.
        index: usize,
        /// How many there are.
        there: usize,
    },
    /// A shader function without a twin for the processor.
    #[error(
        "the function {function} for the slot {slot} has no form for this renderer; draw its program with strahl-evaluate or on a graphics processor, or leave it out"
    )]
    NoTwin {
        /// Name of the function.
        function: String,
        /// Its slot.
        slot: &'static str,
    },
    /// The coefficients of an interpolating B-spline cannot be made.
    #[error(transparent)]
    Coefficients(#[from] strahl_volume::Error),
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
    /// The option `instructions`, or the environment variable `STRAHL_SIMD`, names no set that there is.
    #[error(
        "there are no instructions {value:?} on this processor; set STRAHL_SIMD (or the option) to avx512, avx2 or portable, or leave it out for the fastest that it has"
    )]
    NoSuchInstructions {
        /// What it names.
        value: String,
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

/// A picture to be drawn with any instruction set.
struct Drawing<'d, 'v> {
    renderer: &'d Renderer<'v>,
    plan: &'d Plan,
    options: &'d Options,
    progress: Progress<'d>,
}

/// Runs `task` with the instructions and the number of threads that `options` say.
fn run<T, R>(options: &Options, task: T) -> Result<R, Error>
where
    T: Task<Output = Result<R, Error>> + Send,
    R: Send,
{
    let set = match options.instructions {
        Some(set) => set,
        None => InstructionSet::from_environment()?,
    };
    if !set.is_there() {
        return Err(Error::NoSuchInstructions {
            value: set.to_string(),
        });
    }
    if options.threads == 0 {
        return dispatch(set, task);
    }
    rayon::ThreadPoolBuilder::new()
        .num_threads(options.threads)
        .build()
        .map_err(|why| Error::Threads {
            threads: options.threads,
            why: why.to_string(),
        })?
        .install(|| dispatch(set, task))
}

impl Task for Drawing<'_, '_> {
    type Output = Result<Rendered, Error>;

    fn run<S: Level>(self) -> Result<Rendered, Error> {
        self.renderer
            .draw::<S>(self.plan, self.options, self.progress)
    }
}

impl<'v> Renderer<'v> {
    /// Prepares `data`, one volume or more, on all cores.
    pub fn new(data: impl Into<Datasets<'v>>) -> Renderer<'v> {
        let start = Instant::now();
        let data = data.into();
        Renderer {
            bricks: data
                .volumes
                .iter()
                .map(|volume| Bricks::with_edge(volume, Skip::EDGE))
                .collect(),
            bricks_seconds: start.elapsed().as_secs_f64(),
            recent: Recent::default(),
            recent_of_bricks: RecentOfBricks::default(),
            recent_integrals: RecentIntegrals::default(),
            recent_clipped: RecentClipped::default(),
            masks: Masks::new(&data.masks),
            coefficients: Mutex::new(vec![None; data.volumes.len()]),
            of_cubic: data.volumes.iter().map(|_| OnceLock::new()).collect(),
            meshes: Meshes::new(&data.meshes),
            data,
        }
    }

    /// Draws `plan`.
    ///
    /// # Errors
    /// If the Plan belongs to other data or names a function that the processor does not have, its step
    /// is too short for f32 to count the samples of a ray, an option is not allowed, threads cannot be
    /// started, or `progress` says stop.
    pub fn render(
        &self,
        plan: &Plan,
        options: &Options,
        progress: Progress,
    ) -> Result<Rendered, Error> {
        self.check(plan, options)?;
        run(
            options,
            Drawing {
                renderer: self,
                plan,
                options,
                progress,
            },
        )
    }

    fn check(&self, plan: &Plan, options: &Options) -> Result<(), Error> {
        let there = |what, index: usize, there: usize| {
            (index < there)
                .then_some(())
                .ok_or(Error::NoData { what, index, there })
        };
        for object in &plan.objects {
            there("volume", object.volume, self.data.volumes.len())?;
            let own = self.data.volumes[object.volume].grid();
            // An object may be placed elsewhere, but has the voxels of its volume.
            if object.grid.dims() != own.dims() || !self.has_place(object) {
                return Err(Error::OtherGrid {
                    plan: object.grid.dims(),
                    volume: own.dims(),
                });
            }
        }
        for clip in &plan.sample_clips {
            if let ClipShape::Mask { mask, .. } = clip.shape {
                there("mask", mask, self.data.masks.len())?;
            }
        }
        for mesh in &plan.meshes {
            there("mesh", mesh.mesh, self.data.meshes.len())?;
        }
        if let Some(module) = plan.modules.first() {
            return Err(Error::NoTwin {
                function: module.module.name().to_owned(),
                slot: module.module.slot().name,
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

    /// Whether an object lies where its volume does; a Plan of one volume that lies elsewhere is that of
    /// another one, unless its scene moves it.
    fn has_place(&self, object: &PlanObject) -> bool {
        let own = self.data.volumes[object.volume].grid();
        object.is_moved || object.grid == *own
    }

    /// The coefficients that `plan` reads for an object, if it reads any.
    fn coefficients_for(
        &self,
        plan: &Plan,
        object: &PlanObject,
    ) -> Result<Option<Arc<Coefficients>>, Error> {
        if plan.reconstruct != Reconstruct::BSplineInterpolating || plan.fetch != Fetch::Stored {
            return Ok(None);
        }
        let mut known = self
            .coefficients
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let of_volume = &mut known[object.volume];
        if of_volume.is_none() {
            let volume = self.data.volumes[object.volume].b_spline_coefficients()?;
            let of_cubic = OfCubic::new(&volume);
            *of_volume = Some(Arc::new(Coefficients { volume, of_cubic }));
        }
        Ok(of_volume.clone())
    }

    /// The values of an object: slots fetch and reconstruct.
    fn values<'a, S: Level>(
        &'a self,
        plan: &Plan,
        object: &PlanObject,
        coefficients: Option<&'a Coefficients>,
    ) -> Box<dyn Values<S> + 'a> {
        let shape = Shape::new(&object.grid);
        match (plan.fetch, coefficients) {
            (Fetch::MarschnerLobb { frequency, alpha }, _) => {
                let fetch = MarschnerLobb {
                    shape,
                    frequency,
                    alpha,
                };
                of_fetch(fetch, Rescale::IDENTITY, plan.reconstruct)
            }
            (
                Fetch::Noise {
                    cell_voxels,
                    octaves,
                    seed,
                },
                _,
            ) => {
                let fetch = Noise {
                    shape,
                    cell_voxels,
                    octaves,
                    seed,
                };
                of_fetch(fetch, Rescale::IDENTITY, plan.reconstruct)
            }
            (Fetch::Stored, Some(Coefficients { volume, .. })) => {
                let samples = volume.samples();
                values(&object.grid, samples, volume.rescale(), plan.reconstruct)
            }
            (Fetch::Stored, None) => {
                let samples = self.data.volumes[object.volume].samples();
                values(&object.grid, samples, object.rescale, plan.reconstruct)
            }
        }
    }

    /// What object number `object` is reconstructed from, its bricks, and what there is for cubic kernels.
    fn read_for<'a>(
        &'a self,
        plan: &Plan,
        object: usize,
        coefficients: &'a [Option<Arc<Coefficients>>],
    ) -> (&'a Volume, &'a Bricks, Option<&'a OfCubic>) {
        if let Some(Coefficients { volume, of_cubic }) = coefficients[object].as_deref() {
            return (volume, &of_cubic.bricks, Some(of_cubic));
        }
        let index = plan.objects[object].volume;
        let volume = self.data.volumes[index];
        match plan.reconstruct {
            Reconstruct::BSpline | Reconstruct::CatmullRom if plan.fetch == Fetch::Stored => {
                let of_cubic = self.of_cubic[index].get_or_init(|| OfCubic::new(volume));
                (volume, &of_cubic.bricks, Some(of_cubic))
            }
            _ => (volume, &self.bricks[index], None),
        }
    }

    /// What `draw` makes of `plan` with everything prepared.
    fn with_scenery<S: Level, R>(
        &self,
        plan: &Plan,
        options: &Options,
        draw: impl FnOnce(&Scenery<S>) -> R,
    ) -> Result<R, Error> {
        let coefficients = plan
            .objects
            .iter()
            .map(|object| self.coefficients_for(plan, object))
            .collect::<Result<Vec<_>, Error>>()?;
        let sources: Vec<_> = plan
            .objects
            .iter()
            .zip(&coefficients)
            .map(|(object, coefficients)| self.values(plan, object, coefficients.as_deref()))
            .collect();
        let masks: Vec<Box<dyn Values<S> + '_>> = self
            .data
            .masks
            .iter()
            .map(|mask| {
                let trilinear = Reconstruct::Trilinear;
                values(mask.grid(), mask.samples(), mask.rescale(), trilinear)
            })
            .collect();
        let object = |index: usize| {
            let (volume, bricks, of_cubic) = self.read_for(plan, index, &coefficients);
            let clipped = Clipped::new(&self.recent_clipped, &self.masks, bricks, plan, index);
            let clipped = clipped.as_ref();
            let skip = options
                .skip
                .then(|| Skip::new(&self.recent, bricks, plan, index, clipped))
                .flatten();
            let rescale = match coefficients[index] {
                Some(_) => volume.rescale(),
                None => plan.objects[index].rescale,
            };
            let rejection = of_cubic
                .filter(|_| options.skip)
                .and_then(|of_cubic| Rejection::new(of_cubic, plan, index, rescale));
            let is_plain =
                plan.fetch == Fetch::Stored && plan.reconstruct == Reconstruct::Trilinear;
            let stored = is_plain
                .then(|| Stored::new(&plan.objects[index].grid, volume.samples()))
                .flatten();
            // Both need what is beside a voxel to have a value: bricks side by side have one in common then.
            let is_whole = plan.sampling == Sampling::Regular || is_whole(volume, bricks);
            let skip = skip.filter(|_| is_whole || !plan.sampling.is_of_segments());
            let even = is_whole
                .then(|| EvenCubes::new(&self.recent_of_bricks, bricks, plan, index))
                .flatten();
            let strides = Strides::new(&self.recent_of_bricks, bricks, plan, index, clipped);
            let integrals = self.recent_integrals.of_plan(plan, index);
            let source = &*sources[index];
            Object::new(
                plan, index, source, stored, &masks, skip, rejection, even, strides, integrals,
            )
        };
        Ok(draw(&Scenery {
            plan,
            objects: (0..plan.objects.len()).map(object).collect(),
            shading: Shading::new(plan),
            jitters: Jitters::new(plan),
            meshes: &self.meshes,
        }))
    }

    fn draw<S: Level>(
        &self,
        plan: &Plan,
        options: &Options,
        progress: Progress,
    ) -> Result<Rendered, Error> {
        let start = Instant::now();
        self.with_scenery::<S, _>(plan, options, |scenery| {
            let prepared = Instant::now();
            let drawn = tiles::draw(scenery, Raster::ALL, options.tile, progress)?;
            let image = Image::from_pixels(plan.width, plan.height, drawn.pixels);
            Ok(Rendered {
                image: image.into_linear(plan.compositing),
                depth_mm: plan.with_depth.then_some(drawn.depth_mm),
                stats: Stats {
                    prepare_seconds: (prepared - start).as_secs_f64(),
                    draw_seconds: prepared.elapsed().as_secs_f64(),
                    ..self.stats(plan, drawn.counts)
                },
            })
        })?
    }

    /// What `counts` say of a picture of `plan`; no times but that of the bricks.
    fn stats(&self, plan: &Plan, counts: Counts) -> Stats {
        Stats {
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
            prepare_seconds: 0.0,
            draw_seconds: 0.0,
        }
    }
}

/// Whether every voxel has a value, and none is so large that differences overflow.
fn is_whole(volume: &Volume, bricks: &Bricks) -> bool {
    let fits = |range: BrickRange| range.lo > -1e37 && range.hi < 1e37;
    volume.statistics().not_finite == 0 && bricks.ranges().all(fits)
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
