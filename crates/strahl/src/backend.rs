//! Which renderer draws.

use crate::Error;
use crate::note::Note;
use crate::scene_graph::SceneGraph;
use crate::session::Session;
use crate::show_stage::ShowStage;
use strahl_scene::{Rendered, plan::Plan};
use strahl_volume::{Control, Datasets};

/// Which renderer draws.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Backend {
    /// The GPU if there is one, else the CPU, with a note that says why. An
    /// adapter that is itself a program on the CPU does not count: ours is faster.
    Auto,
    /// The CPU: the same bytes on every machine. Functions of files, which have no twin there, are
    /// evaluated, with a note that says so.
    #[default]
    Cpu,
    /// The GPU, or an error.
    Gpu {
        /// Part of the adapter's name; the best one if not said.
        adapter: Option<String>,
    },
}

/// Which renderer has drawn a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DrawnBy {
    /// The CPU's own ray loop.
    Cpu,
    /// The CPU, by the program that a GPU would run.
    Evaluator,
    /// The GPU.
    Gpu {
        /// The adapter.
        adapter: String,
    },
}

/// A picture, and what was not done as asked.
pub(crate) struct DrawnPicture {
    pub rendered: Rendered,
    pub drawn_by: DrawnBy,
    pub notes: Vec<Note>,
}

/// What is to be drawn.
pub(crate) struct DrawRequest<'w> {
    pub data: &'w Datasets,
    pub plan: &'w Plan,
    /// What it is drawn by, if not by the Plan alone.
    pub graph: Option<&'w SceneGraph>,
}

/// Draws what is `wanted` with what `session` keeps, in stages if `show` wants them, under `control`.
pub(crate) fn draw(
    session: &Session,
    backend: &Backend,
    wanted: &DrawRequest,
    options: &strahl_cpu::Options,
    show: Option<ShowStage>,
    control: &Control,
) -> Result<DrawnPicture, Error> {
    if show.is_some() && (*backend != Backend::Cpu || wanted.graph.is_some()) {
        return Err(Error::NoStages);
    }
    match backend {
        Backend::Cpu => on_cpu(session, wanted, options, show, control),
        Backend::Gpu { adapter } => on_gpu(session, adapter.as_deref(), wanted, control),
        Backend::Auto => {
            let why = match hardware(session) {
                None => "there is no GPU".to_owned(),
                adapter => match on_gpu(session, adapter, wanted, control) {
                    Ok(drawn) => return Ok(drawn),
                    // What is wrong with a graph is wrong everywhere.
                    #[cfg(feature = "graph")]
                    Err(error @ Error::Graph(_)) => return Err(error),
                    Err(Error::Cancelled) => return Err(Error::Cancelled),
                    Err(error) => error.to_string(),
                },
            };
            let mut drawn = on_cpu(session, wanted, options, None, control)?;
            drawn.notes.insert(0, Note::NoGraphics { why });
            Ok(drawn)
        }
    }
}

/// By the twins of the functions, or by the program where one has none.
fn on_cpu(
    session: &Session,
    wanted: &DrawRequest,
    options: &strahl_cpu::Options,
    show: Option<ShowStage>,
    control: &Control,
) -> Result<DrawnPicture, Error> {
    if wanted.graph.is_some() {
        let mut drawn = evaluated(session, wanted, options.threads, control)?;
        drawn.notes.push(Note::GraphEvaluated);
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
        Ok(rendered) => Ok(DrawnPicture {
            rendered,
            drawn_by: DrawnBy::Cpu,
            notes: Vec::new(),
        }),
        Err(strahl_cpu::Error::NoTwin { function, .. }) if show.is_none() => {
            let mut drawn = evaluated(session, wanted, options.threads, control)?;
            drawn.notes.push(Note::FunctionEvaluated { function });
            Ok(drawn)
        }
        Err(error) => Err(error.into()),
    }
}

/// By the program that a GPU would run.
#[cfg(feature = "graph")]
fn evaluated(
    session: &Session,
    wanted: &DrawRequest,
    threads: usize,
    control: &Control,
) -> Result<DrawnPicture, Error> {
    let pool = session.pools().of(threads)?;
    let draw = || {
        session.with_evaluator(|evaluator| {
            evaluator.set_data(wanted.data);
            let (rendered, notes) = match wanted.graph {
                None => (evaluator.render(wanted.plan, control)?, Vec::new()),
                Some(graph) => graph.draw(evaluator, wanted.plan, control)?,
            };
            Ok(DrawnPicture {
                rendered,
                drawn_by: DrawnBy::Evaluator,
                notes,
            })
        })
    };
    match pool {
        Some(pool) => pool.install(draw),
        None => draw(),
    }
}

#[cfg(not(feature = "graph"))]
fn evaluated(
    _session: &Session,
    wanted: &DrawRequest,
    _threads: usize,
    _control: &Control,
) -> Result<DrawnPicture, Error> {
    match wanted.graph {
        Some(graph) => match *graph {},
        // A Plan without a file of a function has a twin of each.
        None => Err(Error::NoGraphs {
            file: None,
            what: "a shader function of a file",
        }),
    }
}

#[cfg(feature = "gpu")]
fn hardware(session: &Session) -> Option<&str> {
    session.devices().hardware()
}

#[cfg(not(feature = "gpu"))]
fn hardware(_session: &Session) -> Option<&str> {
    None
}

#[cfg(not(feature = "gpu"))]
fn on_gpu(
    _session: &Session,
    _adapter: Option<&str>,
    _wanted: &DrawRequest,
    _control: &Control,
) -> Result<DrawnPicture, Error> {
    Err(Error::NoGpu)
}

#[cfg(feature = "gpu")]
fn on_gpu(
    session: &Session,
    adapter_name: Option<&str>,
    wanted: &DrawRequest,
    control: &Control,
) -> Result<DrawnPicture, Error> {
    let devices = session.devices();
    devices.draw(adapter_name, wanted.data, control, |renderer| {
        let (rendered, mut notes) = match wanted.graph {
            None => (renderer.render(wanted.plan, control)?, Vec::new()),
            #[cfg(feature = "graph")]
            Some(graph) => graph.draw(renderer, wanted.plan, control)?,
            #[cfg(not(feature = "graph"))]
            Some(graph) => match *graph {},
        };
        let used = renderer.device().adapter();
        let adapter = used.to_string();
        // Who asks for a software renderer by name knows what it is.
        if used.is_software && adapter_name.is_none() {
            let adapter = adapter.clone();
            notes.push(Note::SoftwareAdapter { adapter });
        }
        Ok(DrawnPicture {
            rendered,
            drawn_by: DrawnBy::Gpu { adapter },
            notes,
        })
    })
}
