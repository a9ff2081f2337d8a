//! Draws Plans of the same data.

use crate::error::Error;
use crate::levels::{Level, Task};
use crate::line::MAX_POINTS;
use crate::making::Making;
use crate::march::Counts;
use crate::options::Options;
use crate::pools::{Pool, Pools};
use crate::prepared::Prepared;
use crate::raster::Raster;
use crate::ray_packet::most_points;
use crate::ray_states::RayStates;
use crate::tiles;
use std::sync::Arc;
use strahl_scene::plan::Plan;
use strahl_scene::{Image, Rendered, Stats};
use strahl_volume::{Control, Datasets, Stopwatch, Store, Work, cores};

/// Draws Plans of the same data. What it makes of the data for that it keeps in a [`Store`], for the next picture.
pub struct Renderer {
    data: Datasets,
    store: Arc<Store>,
    pools: Pools,
}

/// A picture to be drawn with any instruction set.
struct Drawing<'d> {
    prepared: Prepared,
    plan: &'d Plan,
    /// How far its rays have come; without, they are marched from their first lattice points to their ends.
    states: Option<&'d RayStates>,
    options: &'d Options,
    control: &'d Control,
}

impl Task for Drawing<'_> {
    type Output = Result<Rendered, Error>;

    fn run<S: Level>(self) -> Result<Rendered, Error> {
        let (plan, edge) = (self.plan, self.options.tile);
        let [bricks_seconds, prepare_seconds] =
            [self.prepared.bricks_seconds, self.prepared.seconds];
        let start = Stopwatch::start();
        let drawn = self.prepared.with_scenery::<S, _>(plan, |scenery| {
            let tiles = Raster::ALL.tiles(plan, edge);
            let parts = self.control.parts(Work::Drawing, tiles);
            tiles::draw(scenery, Raster::ALL, edge, self.states, &parts)
        })?;
        let image = Image::from_pixels(plan.width, plan.height, drawn.pixels);
        Ok(Rendered {
            image: image.into_linear(plan.compositing),
            depth_mm: plan.with_depth.then_some(drawn.depth_mm),
            stats: Stats {
                bricks_seconds,
                prepare_seconds,
                draw_seconds: start.seconds(),
                ..stats_of(plan, drawn.counts)
            },
        })
    }
}

impl Renderer {
    /// Draws from `data`, one volume or more. Nothing is made before the first picture.
    pub fn new(data: impl Into<Datasets>) -> Renderer {
        Renderer::with_store(data, Arc::default(), Pools::default())
    }

    /// The same with what others share: what is made of the data, and pools of threads.
    pub fn with_store(data: impl Into<Datasets>, store: Arc<Store>, pools: Pools) -> Renderer {
        Renderer {
            data: data.into(),
            store,
            pools,
        }
    }

    /// What is made of the data, kept from picture to picture.
    pub fn store(&self) -> &Arc<Store> {
        &self.store
    }

    /// Draws `plan`, under `control`.
    ///
    /// # Errors
    /// If the Plan belongs to other data or names a function that the CPU does not have, its step
    /// is too short for f32 to count the samples of a ray, an option is not allowed, threads cannot be
    /// started, or `control` was cancelled.
    pub fn render(
        &self,
        plan: &Plan,
        options: &Options,
        control: &Control,
    ) -> Result<Rendered, Error> {
        self.check(plan, options)?;
        self.draw(plan, None, options, control)
    }

    /// The same for a Plan that was checked, or the picture that the rays `states` of it make.
    pub(crate) fn draw(
        &self,
        plan: &Plan,
        states: Option<&RayStates>,
        options: &Options,
        control: &Control,
    ) -> Result<Rendered, Error> {
        let pool = self.pools.of(options.threads)?;
        let pool = pool.as_deref();
        let drawing = Drawing {
            prepared: self.prepare(plan, options, control, pool)?,
            plan,
            states,
            options,
            control,
        };
        options.run(pool, drawing)
    }

    /// Pools of threads for pictures.
    pub(crate) fn pools(&self) -> &Pools {
        &self.pools
    }

    /// What `plan` needs, before anything runs in a pool.
    pub(crate) fn prepare(
        &self,
        plan: &Plan,
        options: &Options,
        control: &Control,
        pool: Option<&Pool>,
    ) -> Result<Prepared, Error> {
        let making = Making {
            store: &self.store,
            control,
            pool,
        };
        Prepared::new(&making, &self.data, plan, options.skip)
    }

    pub(crate) fn check(&self, plan: &Plan, options: &Options) -> Result<(), Error> {
        plan.check(&self.data)?;
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
        let pixels = u64::from(plan.width) * u64::from(plan.height);
        check_memory("the picture", pixels * size_of::<[f32; 5]>() as u64)
    }
}

/// Whether there is room for as many bytes; they are given back at once.
pub(crate) fn check_memory(what: &'static str, bytes: u64) -> Result<(), Error> {
    let reserved = usize::try_from(bytes)
        .ok()
        .map(|number| Vec::<u8>::new().try_reserve_exact(number));
    match reserved {
        Some(Ok(())) => Ok(()),
        _ => Err(Error::NoMemory { what, bytes }),
    }
}

/// What `counts` say of a picture of `plan`; no times.
pub(crate) fn stats_of(plan: &Plan, counts: Counts) -> Stats {
    Stats {
        threads: cores::number(),
        counts: Some(strahl_scene::Counts {
            rays: u64::from(plan.width) * u64::from(plan.height),
            rays_in_volume: counts.rays_in_volume,
            rays_ended_early: counts.ended_early,
            lattice_points: counts.points,
            samples: counts.samples,
            samples_visible: counts.visible,
            points_skipped: counts.skipped,
            skipped_mm: counts.skipped as f64 * plan.lattice.step_mm,
        }),
        ..Stats::default()
    }
}
