//! Which renderer draws, and what a picture has cost there.

use crate::render::ShowStage;
use crate::{Error, SceneGraph};
use std::ops::ControlFlow;
use strahl_gpu::{Device, adapters};
use strahl_scene::{Image, plan::Plan};
use strahl_volume::Datasets;

/// Which renderer draws.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Backend {
    /// The graphics processor if there is one, else the processor, with a note that says why. An
    /// adapter that is itself a program on the processor does not count: ours is faster.
    Auto,
    /// The processor: the same bytes on every machine. Functions of files, which have no twin there, are
    /// evaluated, with a note that says so.
    #[default]
    Cpu,
    /// The graphics processor, or an error.
    Gpu {
        /// Part of the adapter's name; the best one if not said.
        adapter: Option<String>,
    },
}

/// What a picture has cost.
#[derive(Clone, Debug, PartialEq)]
pub enum Stats {
    /// On the processor.
    Cpu(strahl_cpu::Stats),
    /// On the processor, by the program that a graphics processor would run.
    Evaluated {
        /// Threads that drew.
        threads: usize,
        /// Linking, compiling and drawing.
        seconds: f64,
    },
    /// On the graphics processor.
    Gpu {
        /// The adapter that drew.
        adapter: String,
        /// What it took.
        stats: strahl_gpu::Stats,
    },
}

impl Stats {
    /// Drawing alone, without reading and preparing.
    pub fn draw_seconds(&self) -> f64 {
        match self {
            Stats::Cpu(stats) => stats.draw_seconds,
            Stats::Evaluated { seconds, .. } => *seconds,
            Stats::Gpu { stats, .. } => stats.draw_seconds,
        }
    }
}

/// A picture, and what was not done as asked.
pub(crate) struct Drawn {
    pub image: Image,
    pub depth_mm: Option<Vec<f32>>,
    pub stats: Stats,
    pub notes: Vec<String>,
}

/// Draws `plan`, by `graph` if there is one, in stages if `show` wants them; `progress` is told the share that is
/// drawn.
pub(crate) fn draw(
    backend: &Backend,
    data: &Datasets,
    plan: &Plan,
    graph: Option<&SceneGraph>,
    options: &strahl_cpu::Options,
    show: Option<ShowStage>,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Drawn, Error> {
    if show.is_some() && (*backend != Backend::Cpu || graph.is_some()) {
        return Err(Error::NoStages);
    }
    match backend {
        Backend::Cpu => on_cpu(data, plan, graph, options, show, progress),
        Backend::Gpu { adapter } => on_gpu(adapter.as_deref(), data, plan, graph, progress),
        Backend::Auto => {
            let hardware = adapters().into_iter().find(|a| !a.is_software);
            let why = match hardware {
                None => "there is no graphics processor".to_owned(),
                Some(adapter) => match on_gpu(Some(&adapter.name), data, plan, graph, progress) {
                    Ok(drawn) => return Ok(drawn),
                    // What is wrong with a graph is wrong everywhere.
                    Err(error @ Error::Graph(_)) => return Err(error),
                    Err(error) => error.to_string(),
                },
            };
            let drawn = on_cpu(data, plan, graph, options, None, progress)?;
            let why = format!("drawn on the processor: {why}");
            let mut drawn = drawn;
            drawn.notes.insert(0, why);
            Ok(drawn)
        }
    }
}

/// By the twins of the functions, or by the program where one has none.
fn on_cpu(
    data: &Datasets,
    plan: &Plan,
    graph: Option<&SceneGraph>,
    options: &strahl_cpu::Options,
    show: Option<ShowStage>,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Drawn, Error> {
    let share = |drawn, total| {
        progress(drawn as f64 / total as f64);
        ControlFlow::Continue(())
    };
    if graph.is_some() {
        let note = "the graph was evaluated on the processor, which is exact but slow; --backend gpu is faster";
        let mut drawn = evaluated(data, plan, graph, options.threads, share)?;
        drawn.notes.push(note.to_owned());
        return Ok(drawn);
    }
    let renderer = strahl_cpu::Renderer::new(data.clone());
    let drawn = match show {
        None => renderer.render(plan, options, &share),
        Some(show) => renderer.refine(plan, options, &share, &mut |picture, stage| {
            show(picture, &plan.display, stage)
        }),
    };
    match drawn {
        Ok(drawn) => Ok(Drawn {
            image: drawn.image,
            depth_mm: drawn.depth_mm,
            stats: Stats::Cpu(drawn.stats),
            notes: Vec::new(),
        }),
        Err(strahl_cpu::Error::NoTwin { function, .. }) if show.is_none() => {
            let note = format!(
                "the function {function} has no form for the processor: its program was evaluated there, which is exact but slow; --backend gpu is faster"
            );
            let mut drawn = evaluated(data, plan, None, options.threads, share)?;
            drawn.notes.push(note);
            Ok(drawn)
        }
        Err(error) => Err(error.into()),
    }
}

/// By the program that a graphics processor would run.
fn evaluated(
    data: &Datasets,
    plan: &Plan,
    graph: Option<&SceneGraph>,
    threads: usize,
    progress: impl Fn(usize, usize) -> ControlFlow<()> + Sync + Send,
) -> Result<Drawn, Error> {
    let draw = || {
        let mut evaluator = strahl_evaluate::Evaluator::new(data.clone());
        let mut notes = Vec::new();
        let drawn = match graph {
            None => evaluator.render(plan, progress)?,
            Some(graph) => {
                let (what, functions) = (evaluator.loop_of(plan)?, evaluator.functions(plan)?);
                let ready = graph.ready(plan, &what, &functions)?;
                notes = ready.notes;
                let of = &ready.compiled;
                let (program, parameters) = (&of.program, &of.parameters);
                let textures = &ready.textures;
                match &of.slicing {
                    None => evaluator.render_by(plan, program, parameters, textures, progress)?,
                    Some(slicing) => evaluator
                        .render_slices_by(plan, program, parameters, textures, slicing, progress)?,
                }
            }
        };
        Ok(Drawn {
            image: drawn.image,
            depth_mm: drawn.depth_mm,
            stats: Stats::Evaluated {
                threads: rayon::current_num_threads(),
                seconds: drawn.seconds,
            },
            notes,
        })
    };
    if threads == 0 {
        return draw();
    }
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|why| strahl_cpu::Error::Threads {
            threads,
            why: why.to_string(),
        })?
        .install(draw)
}

/// A device may be lost at any time: the driver was updated or reset. It is opened again once.
fn on_gpu(
    adapter: Option<&str>,
    data: &Datasets,
    plan: &Plan,
    graph: Option<&SceneGraph>,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Drawn, Error> {
    match on_device(adapter, data, plan, graph, progress) {
        Err(Error::Gpu(strahl_gpu::Error::Lost(_))) => {
            on_device(adapter, data, plan, graph, progress)
        }
        done => done,
    }
}

fn on_device(
    adapter: Option<&str>,
    data: &Datasets,
    plan: &Plan,
    graph: Option<&SceneGraph>,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Drawn, Error> {
    let device = Device::open(adapter)?;
    let share = |drawn, total| {
        progress(drawn as f64 / total as f64);
        ControlFlow::Continue(())
    };
    let mut renderer = strahl_gpu::Renderer::new(&device, data.clone())?;
    let mut notes = Vec::new();
    let drawn = match graph {
        None => renderer.render(plan, share)?,
        Some(graph) => {
            let (what, functions) = (renderer.loop_of(plan)?, renderer.functions(plan)?);
            let ready = graph.ready(plan, &what, &functions)?;
            notes = ready.notes;
            let of = &ready.compiled;
            let (program, parameters) = (&of.program, &of.parameters);
            let textures = &ready.textures;
            match &of.slicing {
                None => renderer.render_by(plan, program, parameters, textures, share)?,
                Some(slicing) => renderer
                    .render_slices_by(plan, program, parameters, textures, slicing, share)?,
            }
        }
    };
    let adapter = device.adapter().to_string();
    Ok(Drawn {
        image: drawn.image,
        depth_mm: drawn.depth_mm,
        stats: Stats::Gpu {
            adapter,
            stats: drawn.stats,
        },
        notes,
    })
}
