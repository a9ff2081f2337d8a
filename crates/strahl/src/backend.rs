//! Which renderer draws, and what a picture has cost there.

use crate::Error;
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
    /// The processor: the same bytes on every machine.
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
            Stats::Gpu { stats, .. } => stats.draw_seconds,
        }
    }
}

/// A picture, and what was not done as asked.
pub(crate) struct Drawn {
    pub image: Image,
    pub depth_mm: Option<Vec<f32>>,
    pub stats: Stats,
    pub note: Option<String>,
}

/// Draws `plan`; `progress` is told the share that is drawn.
pub(crate) fn draw(
    backend: &Backend,
    data: &Datasets,
    plan: &Plan,
    options: &strahl_cpu::Options,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Drawn, Error> {
    let on_cpu = || -> Result<Drawn, Error> {
        let drawn =
            strahl_cpu::Renderer::new(data.clone()).render(plan, options, &|drawn, total| {
                progress(drawn as f64 / total as f64);
                ControlFlow::Continue(())
            })?;
        Ok(Drawn {
            image: drawn.image,
            depth_mm: drawn.depth_mm,
            stats: Stats::Cpu(drawn.stats),
            note: None,
        })
    };
    match backend {
        Backend::Cpu => on_cpu(),
        Backend::Gpu { adapter } => Ok(on_gpu(adapter.as_deref(), data, plan, progress)?),
        Backend::Auto => {
            let hardware = adapters().into_iter().find(|a| !a.is_software);
            let why = match hardware {
                None => "there is no graphics processor".to_owned(),
                Some(adapter) => match on_gpu(Some(&adapter.name), data, plan, progress) {
                    Ok(drawn) => return Ok(drawn),
                    Err(error) => error.to_string(),
                },
            };
            let drawn = on_cpu()?;
            Ok(Drawn {
                note: Some(format!("drawn on the processor: {why}")),
                ..drawn
            })
        }
    }
}

/// A device may be lost at any time: the driver was updated or reset. It is opened again once.
fn on_gpu(
    adapter: Option<&str>,
    data: &Datasets,
    plan: &Plan,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Drawn, strahl_gpu::Error> {
    match on_device(adapter, data, plan, progress) {
        Err(strahl_gpu::Error::Lost(_)) => on_device(adapter, data, plan, progress),
        done => done,
    }
}

fn on_device(
    adapter: Option<&str>,
    data: &Datasets,
    plan: &Plan,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Drawn, strahl_gpu::Error> {
    let device = Device::open(adapter)?;
    let drawn =
        strahl_gpu::Renderer::new(&device, data.clone())?.render(plan, |drawn, total| {
            progress(drawn as f64 / total as f64);
            ControlFlow::Continue(())
        })?;
    let adapter = device.adapter().to_string();
    Ok(Drawn {
        image: drawn.image,
        depth_mm: drawn.depth_mm,
        stats: Stats::Gpu {
            adapter,
            stats: drawn.stats,
        },
        note: None,
    })
}
