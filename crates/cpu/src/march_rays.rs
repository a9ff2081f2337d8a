//! A picture drawn interval by interval of the lattice.

use crate::error::Error;
use crate::levels::{Level, Task};
use crate::march;
use crate::options::Options;
use crate::prepared::Prepared;
use crate::raster::Raster;
use crate::ray_state::RayState;
use crate::ray_states::RayStates;
use crate::renderer::{Renderer, check_memory};
use crate::tiles;
use std::ops::Range;
use strahl_scene::Rendered;
use strahl_scene::plan::Plan;
use strahl_volume::{Control, Work};

/// Rays to be moved with any instruction set.
struct Marching<'d> {
    prepared: Prepared,
    plan: &'d Plan,
    options: &'d Options,
    interval: Range<u32>,
    states: &'d mut RayStates,
    control: &'d Control,
}

impl Task for Marching<'_> {
    type Output = Result<(), Error>;

    fn run<S: Level>(self) -> Result<(), Error> {
        let (plan, edge) = (self.plan, self.options.tile);
        let (control, states) = (self.control, self.states);
        self.prepared.with_scenery::<S, _>(plan, |scenery| {
            let parts = control.parts(Work::Drawing, Raster::ALL.tiles(plan, edge));
            tiles::march(scenery, &self.interval, edge, states, &parts)
        })
    }
}

impl Renderer {
    /// The rays of `plan` before their first lattice points.
    ///
    /// With [`march`](Renderer::march) and [`finish`](Renderer::finish) a picture is drawn in parts, of which each has only
    /// some of the lattice points of every ray. However the lattice is cut, and whatever happens to the states in between,
    /// the picture has the bytes that [`render`](Renderer::render) gives. (Samples may differ in number: for `mip` and
    /// `minip` `render` does not go along the lattice.)
    ///
    /// ```
    /// use strahl_cpu::{Options, Renderer};
    /// use strahl_scene::{Scene, resolve};
    /// use strahl_volume::{Control, Phantom};
    ///
    /// let volume = Phantom::Tree.volume([32, 32, 32])?;
    /// let scene = Scene::parse("scene", r#"{ "size": [64, 48] }"#)?;
    /// let plan = resolve(&scene, &volume.header(), None)?;
    /// let renderer = Renderer::new(&volume);
    /// let (options, control) = (Options::default(), Control::NONE);
    /// let mut states = renderer.start(&plan, &options)?;
    /// for interval in [0..20, 20..35, 35..u32::MAX] {
    ///     renderer.march(&plan, interval, &mut states, &options, &control)?;
    /// }
    /// let drawn = renderer.finish(&plan, &states, &options, &control)?;
    /// assert_eq!(drawn.image, renderer.render(&plan, &options, &control)?.image);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`render`](Renderer::render).
    pub fn start(&self, plan: &Plan, options: &Options) -> Result<RayStates, Error> {
        self.check(plan, options)?;
        let rays = u64::from(plan.width) * u64::from(plan.height) * u64::from(plan.lattice.frames);
        check_memory(
            "its rays",
            rays.saturating_mul(size_of::<RayState>() as u64),
        )?;
        Ok(RayStates::new(plan, march::start(plan)))
    }

    /// Moves the rays `states` of `plan` that stand at a lattice point of `interval`, each until it stands at none: behind the
    /// last of the interval (with `back_to_front`: before the first), or a little further where one sample stands for
    /// several lattice points, or until it needs no more. Other rays stay where they are.
    ///
    /// The rules of sampling that look at segments (`refine`, `split`, `integrated`) count the piece of a ray behind its
    /// last lattice point as one more; `u32::MAX` is behind everything.
    ///
    /// # Errors
    /// As [`render`](Renderer::render); [`Error::OtherRays`] if the states are not those of such a Plan. After
    /// [`Error::Cancelled`] some rays have been moved and others have not: the same call goes on.
    pub fn march(
        &self,
        plan: &Plan,
        interval: Range<u32>,
        states: &mut RayStates,
        options: &Options,
        control: &Control,
    ) -> Result<(), Error> {
        self.check(plan, options)?;
        states.check(plan)?;
        let pool = self.pools().of(options.threads)?;
        let pool = pool.as_deref();
        let marching = Marching {
            prepared: self.prepare(plan, options, control, pool)?,
            plan,
            options,
            interval,
            states,
            control,
        };
        options.run(pool, marching)
    }

    /// The picture that the rays `states` of `plan` make, wherever they stand: of rays on their way what they have seen so far.
    ///
    /// # Errors
    /// As [`march`](Renderer::march).
    pub fn finish(
        &self,
        plan: &Plan,
        states: &RayStates,
        options: &Options,
        control: &Control,
    ) -> Result<Rendered, Error> {
        self.check(plan, options)?;
        states.check(plan)?;
        self.draw(plan, Some(states), options, control)
    }
}
