//! A picture in stages: soon a coarse one, in the end the same bytes as at once.
//!
//! First every fourth pixel along both axes with steps four times as long; then every second one with the full step; then
//! the rest. Every pixel is drawn once with the full step, by the
//! same ray as in a picture drawn at once. Pixels that are not drawn yet lie on lines between those that are.

use crate::error::Error;
use crate::levels::{Level, Task};
use crate::march::Counts;
use crate::options::Options;
use crate::prepared::Prepared;
use crate::raster::Raster;
use crate::renderer::{Renderer, stats_of};
use crate::scenery::Scenery;
use crate::tiles;
use std::ops::ControlFlow;
use strahl_scene::plan::{Lattice, Plan};
use strahl_scene::{Image, Rendered, Stats};
use strahl_volume::{Control, Parts, Stopwatch, Work, cores};

/// How far a picture in stages is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stage {
    /// Number of this stage, from 1.
    pub number: u32,
    /// Number of all stages.
    pub of: u32,
    /// Distance in pixels, along both axes, between pixels that are drawn.
    pub stride: u32,
    /// How many times the step of the Plan a step is.
    pub steps: u32,
}

/// How many times as long the steps of the first stage are.
const COARSE_STEPS: u32 = 4;

/// Stride, steps, and which pixels are drawn. Whole rows of a stage lie as close as they can, so that packets of
/// rays stay together.
const STAGES: [(u32, u32, &[Raster]); 3] = [
    (4, COARSE_STEPS, &[raster([0, 0], [4, 4])]),
    (2, 1, &[raster([0, 0], [2, 2])]),
    (1, 1, &[raster([1, 0], [2, 2]), raster([0, 1], [1, 2])]),
];

const fn raster(first: [u32; 2], stride: [u32; 2]) -> Raster {
    Raster { first, stride }
}

/// What is told of each stage; `Break` ends the picture.
type Show<'s> = &'s mut (dyn FnMut(&Image, Stage) -> ControlFlow<()> + Send);

/// A picture in stages to be drawn with any instruction set.
struct Refining<'d> {
    /// For the first stage, which has longer steps, and for the others.
    plans: [(&'d Plan, Prepared); 2],
    options: &'d Options,
    show: Show<'d>,
    control: &'d Control,
}

impl Task for Refining<'_> {
    type Output = Result<Rendered, Error>;

    fn run<S: Level>(self) -> Result<Rendered, Error> {
        self.draw::<S>()
    }
}

impl Renderer {
    /// Draws `plan` in stages, each nearer to the finished picture: `show` gets every one, and may end the picture
    /// between them by `Break` (the camera has moved, say); `control` may end it at any time. What is
    /// shown last and returned has exactly the bytes that [`render`](Renderer::render) gives.
    ///
    /// ```
    /// use std::ops::ControlFlow;
    /// use strahl_cpu::{Options, Renderer};
    /// use strahl_scene::{Scene, resolve};
    /// use strahl_volume::{Control, Phantom};
    ///
    /// let volume = Phantom::Tree.volume([32, 32, 32])?;
    /// let scene = Scene::parse("scene", r#"{ "size": [64, 48] }"#)?;
    /// let plan = resolve(&scene, &volume.header(), None)?;
    /// let renderer = Renderer::new(&volume);
    /// let mut shown = Vec::new();
    /// let (options, control) = (Options::default(), Control::NONE);
    /// let drawn = renderer.refine(&plan, &options, &control, &mut |picture, stage| {
    ///     shown.push((picture.clone(), stage.stride));
    ///     ControlFlow::Continue(())
    /// })?;
    /// assert_eq!(shown.last(), Some(&(drawn.image.clone(), 1)));
    /// assert_eq!(drawn.image, renderer.render(&plan, &options, &control)?.image);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`render`](Renderer::render); [`Error::Cancelled`] if `show` said stop or `control` was cancelled.
    pub fn refine(
        &self,
        plan: &Plan,
        options: &Options,
        control: &Control,
        show: &mut (dyn FnMut(&Image, Stage) -> ControlFlow<()> + Send),
    ) -> Result<Rendered, Error> {
        self.check(plan, options)?;
        let coarse = Plan {
            lattice: Lattice {
                step_mm: plan.lattice.step_mm * f64::from(COARSE_STEPS),
                frames: 1,
                ..plan.lattice
            },
            ..plan.clone()
        };
        let pool = self.pools().of(options.threads)?;
        let pool = pool.as_deref();
        let prepare = |plan| self.prepare(plan, options, control, pool);
        let refining = Refining {
            plans: [(&coarse, prepare(&coarse)?), (plan, prepare(plan)?)],
            options,
            show,
            control,
        };
        options.run(pool, refining)
    }
}

/// What is drawn so far, and how it goes on.
struct Canvas<'d> {
    pixels: Vec<[f32; 4]>,
    /// Empty if nobody asked.
    depth_mm: Vec<f32>,
    counts: Counts,
    tile: u32,
    /// Tiles of all stages.
    parts: Parts<'d>,
    show: Show<'d>,
}

impl Refining<'_> {
    fn draw<S: Level>(self) -> Result<Rendered, Error> {
        let Refining {
            plans: [(coarse, of_coarse), (plan, of_plan)],
            options,
            show,
            control,
        } = self;
        let tiles = |raster: &Raster| raster.tiles(plan, options.tile);
        let total = STAGES
            .iter()
            .flat_map(|(_, _, rasters)| rasters.iter().map(tiles))
            .sum();
        let number = plan.width as usize * plan.height as usize;
        let mut canvas = Canvas {
            pixels: vec![[0.0; 4]; number],
            depth_mm: vec![f32::INFINITY; if plan.with_depth { number } else { 0 }],
            counts: Counts::default(),
            tile: options.tile,
            parts: control.parts(Work::Drawing, total),
            show,
        };
        let bricks_seconds = of_coarse.bricks_seconds + of_plan.bricks_seconds;
        let prepare_seconds = of_coarse.seconds + of_plan.seconds;
        of_coarse.with_scenery::<S, _>(coarse, |scenery| canvas.stage(0, scenery))?;
        let start = Stopwatch::start();
        let image = of_plan.with_scenery::<S, _>(plan, |scenery| {
            let last = STAGES.len() - 1;
            for stage in 1..last {
                canvas.stage(stage, scenery)?;
            }
            canvas.stage(last, scenery)
        })?;
        Ok(Rendered {
            image,
            depth_mm: plan.with_depth.then_some(canvas.depth_mm),
            stats: Stats {
                bricks_seconds,
                prepare_seconds,
                draw_seconds: start.seconds(),
                ..stats_of(plan, canvas.counts)
            },
        })
    }
}

impl Canvas<'_> {
    /// Draws a stage and shows it; the last one takes the pixels of the canvas.
    fn stage<S: Level>(&mut self, index: usize, scenery: &Scenery<S>) -> Result<Image, Error> {
        let (stride, steps, rasters) = STAGES[index];
        let plan = scenery.plan;
        let width = plan.width as usize;
        for raster in rasters {
            let drawn = tiles::draw(scenery, *raster, self.tile, None, &self.parts)?;
            let [columns, _] = raster.size(plan);
            let place = |i: usize| {
                let along = |n: usize, axis: usize| {
                    raster.first[axis] as usize + n * raster.stride[axis] as usize
                };
                along(i % columns, 0) + width * along(i / columns, 1)
            };
            for (i, pixel) in drawn.pixels.into_iter().enumerate() {
                self.pixels[place(i)] = pixel;
            }
            for (i, depth_mm) in drawn.depth_mm.into_iter().enumerate() {
                self.depth_mm[place(i)] = depth_mm;
            }
            // What the first stage costs is no part of the finished picture.
            if steps == 1 {
                self.counts = self.counts.plus(drawn.counts);
            }
        }
        let pixels = if stride == 1 {
            std::mem::take(&mut self.pixels)
        } else {
            between(&self.pixels, width, stride as usize)
        };
        let image = Image::from_pixels(plan.width, plan.height, pixels);
        let image = image.into_linear(plan.compositing);
        let stage = Stage {
            number: index as u32 + 1,
            of: STAGES.len() as u32,
            stride,
            steps,
        };
        match (self.show)(&image, stage) {
            ControlFlow::Continue(()) => Ok(image),
            ControlFlow::Break(()) => Err(Error::Cancelled),
        }
    }
}

/// A picture of which every `stride`-th pixel along both axes is drawn, the others on lines between those.
fn between(pixels: &[[f32; 4]], width: usize, stride: usize) -> Vec<[f32; 4]> {
    let height = pixels.len() / width;
    let mix = |a: [f32; 4], b: [f32; 4], part: f32| -> [f32; 4] {
        std::array::from_fn(|c| a[c] + (b[c] - a[c]) * part)
    };
    let share = |i: usize| i as f32 / stride as f32;
    let mut all = vec![[0.0; 4]; pixels.len()];
    cores::for_each(all.chunks_mut(width).enumerate(), |(y, row)| {
        // First the drawn columns of this row, from the drawn rows above and below; the last one goes on.
        let above = y - y % stride;
        let below = if above + stride < height {
            above + stride
        } else {
            above
        };
        let columns: Vec<[f32; 4]> = (0..width)
            .step_by(stride)
            .map(|x| {
                mix(
                    pixels[x + width * above],
                    pixels[x + width * below],
                    share(y % stride),
                )
            })
            .collect();
        for (i, part) in row.chunks_mut(stride).enumerate() {
            let (left, right) = (columns[i], columns[(i + 1).min(columns.len() - 1)]);
            for (j, pixel) in part.iter_mut().enumerate() {
                *pixel = mix(left, right, share(j));
            }
        }
    });
    all
}
