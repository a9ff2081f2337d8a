//! Draws Plans of the same data: what is prepared for them, and kept from picture to picture.

use crate::brick_number::EDGE;
use crate::clipped::{Clipped, Masks, RecentClipped};
use crate::error::Error;
use crate::even::EvenCubes;
use crate::levels::{Level, Task};
use crate::library::classify::RecentIntegrals;
use crate::library::fetch::{MarschnerLobb, Noise, Shape};
use crate::library::jitter::Jitters;
use crate::library::reconstruct::{Values, of_fetch, values};
use crate::library::shade::Shading;
use crate::line::MAX_POINTS;
use crate::march::Counts;
use crate::meshes::Meshes;
use crate::of_bricks::RecentOfBricks;
use crate::options::Options;
use crate::progress::Progress;
use crate::raster::Raster;
use crate::ray_packet::most_points;
use crate::rejection::{OfCubic, Rejection};
use crate::rendered::{Rendered, Stats};
use crate::scenery::{Object, Scenery, Stored};
use crate::skip::{Recent, Skip};
use crate::strides::Strides;
use crate::tiles;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Instant;
use strahl_scene::Image;
use strahl_scene::plan::{ClipShape, Fetch, Field, Plan, Reconstruct, Sampling};
use strahl_volume::bricks::{BrickRange, Bricks};
use strahl_volume::{Datasets, Rescale, Volume};

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

/// A picture to be drawn with any instruction set.
struct Drawing<'d, 'v> {
    renderer: &'d Renderer<'v>,
    plan: &'d Plan,
    options: &'d Options,
    progress: Progress<'d>,
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
                .map(|volume| Bricks::with_edge(volume, EDGE))
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
        options.run(Drawing {
            renderer: self,
            plan,
            options,
            progress,
        })
    }

    pub(crate) fn check(&self, plan: &Plan, options: &Options) -> Result<(), Error> {
        let there = |what, index: usize, there: usize| {
            (index < there)
                .then_some(())
                .ok_or(Error::NoData { what, index, there })
        };
        for field in plan.drawn_fields() {
            there("volume", field.volume, self.data.volumes.len())?;
            let own = self.data.volumes[field.volume].grid();
            // A field may be placed elsewhere, but has the voxels of its volume.
            if field.grid.dims() != own.dims() || !self.has_place(field) {
                return Err(Error::OtherGrid {
                    plan: field.grid.dims(),
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
        let points = most_points(plan);
        if points > MAX_POINTS {
            let step_mm = plan.lattice.step_mm;
            return Err(Error::StepTooShort {
                step_mm,
                points,
                most: MAX_POINTS,
                least_mm: step_mm * points / MAX_POINTS,
            });
        }
        if options.tile == 0 {
            return Err(Error::NoTile);
        }
        Ok(())
    }

    /// Whether a field lies where its volume does; a Plan of one volume that lies elsewhere is that of
    /// another one, unless its scene moves it.
    fn has_place(&self, field: &Field) -> bool {
        let own = self.data.volumes[field.volume].grid();
        field.is_moved || field.grid == *own
    }

    /// The coefficients that are read for a field, if any are.
    fn coefficients_for(&self, field: &Field) -> Result<Option<Arc<Coefficients>>, Error> {
        if !field.reads_coefficients() {
            return Ok(None);
        }
        let mut known = self
            .coefficients
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let of_volume = &mut known[field.volume];
        if of_volume.is_none() {
            let volume = self.data.volumes[field.volume].b_spline_coefficients()?;
            let of_cubic = OfCubic::new(&volume);
            *of_volume = Some(Arc::new(Coefficients { volume, of_cubic }));
        }
        Ok(of_volume.clone())
    }

    /// The values of a field: slots fetch and reconstruct.
    fn values<'a, S: Level>(
        &'a self,
        field: &Field,
        coefficients: Option<&'a Coefficients>,
    ) -> Box<dyn Values<S> + 'a> {
        let shape = Shape::new(&field.grid);
        match (field.fetch, coefficients) {
            (Fetch::MarschnerLobb { frequency, alpha }, _) => {
                let fetch = MarschnerLobb {
                    shape,
                    frequency,
                    alpha,
                };
                of_fetch(fetch, Rescale::IDENTITY, field.reconstruct)
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
                of_fetch(fetch, Rescale::IDENTITY, field.reconstruct)
            }
            (Fetch::Stored, Some(Coefficients { volume, .. })) => {
                let samples = volume.samples();
                values(&field.grid, samples, volume.rescale(), field.reconstruct)
            }
            (Fetch::Stored, None) => {
                let samples = self.data.volumes[field.volume].samples();
                values(&field.grid, samples, field.rescale, field.reconstruct)
            }
        }
    }

    /// What layer number `layer` is reconstructed from, its bricks, and what there is for cubic kernels.
    fn read_for<'a>(
        &'a self,
        plan: &Plan,
        layer: usize,
        coefficients: &'a [Option<Arc<Coefficients>>],
    ) -> (&'a Volume, &'a Bricks, Option<&'a OfCubic>) {
        if let Some(Coefficients { volume, of_cubic }) = coefficients[layer].as_deref() {
            return (volume, &of_cubic.bricks, Some(of_cubic));
        }
        let field = plan.field_of(layer);
        let volume = self.data.volumes[field.volume];
        match field.reconstruct {
            Reconstruct::BSpline | Reconstruct::CatmullRom if field.fetch == Fetch::Stored => {
                let of_cubic = self.of_cubic[field.volume].get_or_init(|| OfCubic::new(volume));
                (volume, &of_cubic.bricks, Some(of_cubic))
            }
            _ => (volume, &self.bricks[field.volume], None),
        }
    }

    /// What `draw` makes of `plan` with everything prepared.
    pub(crate) fn with_scenery<S: Level, R>(
        &self,
        plan: &Plan,
        options: &Options,
        draw: impl FnOnce(&Scenery<S>) -> R,
    ) -> Result<R, Error> {
        let coefficients = plan
            .drawn_fields()
            .map(|field| self.coefficients_for(field))
            .collect::<Result<Vec<_>, Error>>()?;
        let sources: Vec<_> = plan
            .drawn_fields()
            .zip(&coefficients)
            .map(|(field, coefficients)| self.values(field, coefficients.as_deref()))
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
            let field = plan.field_of(index);
            let (volume, bricks, of_cubic) = self.read_for(plan, index, &coefficients);
            let clipped = Clipped::new(&self.recent_clipped, &self.masks, bricks, plan, index);
            let clipped = clipped.as_ref();
            let skip = options
                .skip
                .then(|| Skip::new(&self.recent, bricks, plan, index, clipped))
                .flatten();
            let rescale = match coefficients[index] {
                Some(_) => volume.rescale(),
                None => field.rescale,
            };
            let rejection = of_cubic
                .filter(|_| options.skip)
                .and_then(|of_cubic| Rejection::new(of_cubic, plan, index, rescale));
            let is_plain =
                field.fetch == Fetch::Stored && field.reconstruct == Reconstruct::Trilinear;
            let stored = is_plain
                .then(|| Stored::new(&field.grid, volume.samples()))
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
            objects: (0..plan.layers.len()).map(object).collect(),
            shading: Shading::new(plan),
            composite: plan.technique().composite,
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
    pub(crate) fn stats(&self, plan: &Plan, counts: Counts) -> Stats {
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
