//! Which renderer draws, and what a picture has cost there.

use crate::session::Session;
use crate::show_stage::ShowStage;
use crate::{Error, SceneGraph};
use strahl_scene::{Image, plan::Plan};
use strahl_volume::{Control, Datasets};

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

/// What is to be drawn.
pub(crate) struct Wanted<'w> {
    pub data: &'w Datasets,
    pub plan: &'w Plan,
    /// What it is drawn by, if not by the Plan alone.
    pub graph: Option<&'w SceneGraph>,
}

/// Draws what is `wanted` with what `session` keeps, in stages if `show` wants them, under `control`.
pub(crate) fn draw(
    session: &Session,
    backend: &Backend,
    wanted: &Wanted,
    options: &strahl_cpu::Options,
    show: Option<ShowStage>,
    control: &Control,
) -> Result<Drawn, Error> {
    if show.is_some() && (*backend != Backend::Cpu || wanted.graph.is_some()) {
        return Err(Error::NoStages);
    }
    match backend {
        Backend::Cpu => on_cpu(session, wanted, options, show, control),
        Backend::Gpu { adapter } => on_gpu(session, adapter.as_deref(), wanted, control),
        Backend::Auto => {
            let why = match session.hardware() {
                None => "there is no graphics processor".to_owned(),
                adapter => match on_gpu(session, adapter, wanted, control) {
                    Ok(drawn) => return Ok(drawn),
                    // What is wrong with a graph is wrong everywhere.
                    Err(error @ (Error::Graph(_) | Error::Cancelled)) => return Err(error),
                    Err(error) => error.to_string(),
                },
            };
            let drawn = on_cpu(session, wanted, options, None, control)?;
            let why = format!("drawn on the processor: {why}");
            let mut drawn = drawn;
            drawn.notes.insert(0, why);
            Ok(drawn)
        }
    }
}

/// By the twins of the functions, or by the program where one has none.
fn on_cpu(
    session: &Session,
    wanted: &Wanted,
    options: &strahl_cpu::Options,
    show: Option<ShowStage>,
    control: &Control,
) -> Result<Drawn, Error> {
    if wanted.graph.is_some() {
        let note = "the graph was evaluated on the processor, which is exact but slow; --backend gpu is faster";
        let mut drawn = evaluated(session, wanted, options.threads, control)?;
        drawn.notes.push(note.to_owned());
        return Ok(drawn);
    }
    let (store, pools) = (session.store().clone(), session.pools().clone());
    let renderer = strahl_cpu::Renderer::with_store(wanted.data, store, pools);
    let plan = wanted.plan;
    let drawn = match show {
        None => renderer.render(plan, options, control),
        Some(show) => renderer.refine(plan, options, control, &mut |picture, stage| {
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
            let mut drawn = evaluated(session, wanted, options.threads, control)?;
            drawn.notes.push(note);
            Ok(drawn)
        }
        Err(error) => Err(error.into()),
    }
}

/// By the program that a graphics processor would run.
fn evaluated(
    session: &Session,
    wanted: &Wanted,
    threads: usize,
    control: &Control,
) -> Result<Drawn, Error> {
    let pool = session.pools().of(threads)?;
    let mut evaluator = session.evaluator(control)?;
    let evaluator = &mut *evaluator;
    evaluator.set_data(wanted.data);
    let plan = wanted.plan;
    let mut draw = || {
        let mut notes = Vec::new();
        let drawn = match wanted.graph {
            None => evaluator.render(plan, control)?,
            Some(graph) => {
                let (what, functions) = (evaluator.loop_of(plan)?, evaluator.functions(plan)?);
                let ready = graph.ready(plan, &what, &functions)?;
                notes = ready.notes;
                let of = &ready.compiled;
                let (program, parameters) = (&of.program, &of.parameters);
                let textures = &ready.textures;
                match &of.slicing {
                    None => evaluator.render_by(plan, program, parameters, textures, control)?,
                    Some(slicing) => evaluator
                        .render_slices_by(plan, program, parameters, textures, slicing, control)?,
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
    match pool {
        Some(pool) => pool.install(draw),
        None => draw(),
    }
}

fn on_gpu(
    session: &Session,
    adapter: Option<&str>,
    wanted: &Wanted,
    control: &Control,
) -> Result<Drawn, Error> {
    session.on_gpu(adapter, wanted.data, control, |renderer| {
        let plan = wanted.plan;
        let mut notes = Vec::new();
        let drawn = match wanted.graph {
            None => renderer.render(plan, control)?,
            Some(graph) => {
                let (what, functions) = (renderer.loop_of(plan)?, renderer.functions(plan)?);
                let ready = graph.ready(plan, &what, &functions)?;
                notes = ready.notes;
                let of = &ready.compiled;
                let (program, parameters) = (&of.program, &of.parameters);
                let textures = &ready.textures;
                match &of.slicing {
                    None => renderer.render_by(plan, program, parameters, textures, control)?,
                    Some(slicing) => renderer
                        .render_slices_by(plan, program, parameters, textures, slicing, control)?,
                }
            }
        };
        Ok(Drawn {
            image: drawn.image,
            depth_mm: drawn.depth_mm,
            stats: Stats::Gpu {
                adapter: renderer.device().adapter().to_string(),
                stats: drawn.stats,
            },
            notes,
        })
    })
}
