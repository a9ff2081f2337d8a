//! The renderers under test.

use crate::truth::{self, Bounds, Field};
use crate::twins;
use std::fmt;
use std::sync::OnceLock;
use strahl_gpu::Device;
use strahl_program::Functions;
use strahl_scene::{Image, plan::Plan};
use strahl_shader::SLOTS;
use strahl_volume::{Control, Samples, Volume};

/// A renderer, as the tests see it.
#[derive(Clone, Copy, Debug)]
pub struct Renderer {
    /// The name in messages.
    pub name: &'static str,
    /// It draws one random scene in so many: some take long to begin a picture.
    pub one_in: u64,
    /// What of the light that passes a sample may be lost in rounding its power, which lies just below 1: half a unit
    /// in the last place, and on devices three more, as WGSL lets `exp2` be off.
    pub lost_per_sample: f64,
    draw: fn(&Volume, &Plan) -> Image,
    /// Whether it runs a program linked from functions in WGSL, which reads voxels from textures.
    runs_programs: bool,
    /// Whether a texture unit interpolates, with weights of a few bits.
    is_coarse: bool,
}

/// Its name.
impl fmt::Display for Renderer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

impl PartialEq for Renderer {
    /// By name: there is one of each.
    fn eq(&self, other: &Renderer) -> bool {
        self.name == other.name
    }
}

impl Renderer {
    /// Draws a Plan of a volume.
    ///
    /// # Panics
    /// If it cannot: see [`Renderer::can_draw`].
    pub fn draw(&self, volume: &Volume, plan: &Plan) -> Image {
        (self.draw)(volume, plan)
    }

    /// Whether it draws the Plan, and has every number of the volume exactly: textures have no integers of 32
    /// bits and no double precision that could be interpolated, and programs sample by the regular rule only.
    pub fn can_draw(&self, volume: &Volume, plan: &Plan) -> bool {
        let is_narrow = !matches!(
            volume.samples(),
            Samples::U32(_) | Samples::I32(_) | Samples::F64(_)
        );
        !self.runs_programs || (is_narrow && functions(plan).is_some())
    }

    /// What it may make of each pixel of a Plan over `field`, before [`tolerance`](Renderer::tolerance).
    pub fn bounds(&self, plan: &Plan, field: &dyn Field) -> Vec<Bounds> {
        if self.runs_programs {
            truth::bounds_of_programs(plan, field)
        } else {
            truth::bounds(plan, field)
        }
    }

    /// How far a pixel may lie outside its [bounds](Renderer::bounds), as a share of the brightest color
    /// that the Plan can give (at least 1): what is lost where the samples of a ray are added up. Where a texture unit
    /// interpolates, what it and the functions of the program may be off ([`twins`](crate::twins)).
    pub fn tolerance(&self, plan: &Plan) -> f64 {
        if !self.is_coarse {
            return 1e-6;
        }
        let functions = functions(plan).into_iter().flatten();
        let tolerance = functions
            .map(|(slot, name)| twins::alike_of(slot, &name).tolerance)
            .fold(0.0, f32::max);
        f64::from(tolerance + twins::HARDWARE_WEIGHTS)
    }
}

/// Slot and name of every function that the program of a Plan has; none if there is no such program.
fn functions(plan: &Plan) -> Option<Vec<(&'static str, String)>> {
    let threshold = |_, threshold| f64::from(threshold);
    let functions = Functions::of(plan, false, threshold).ok()?;
    let of = |slot| functions.selection.of(slot).iter();
    let named = |slot| of(slot).map(|module| (slot.name, module.name().to_owned()));
    Some(SLOTS.iter().flat_map(named).collect())
}

/// Every renderer that is tested; that of the GPU where there is an adapter. A new one is one more
/// line.
pub fn renderers() -> Vec<Renderer> {
    let mut all = vec![
        Renderer {
            name: "cpu",
            one_in: 1,
            lost_per_sample: 0.0,
            draw: draw_on_cpu,
            runs_programs: false,
            is_coarse: false,
        },
        Renderer {
            name: "evaluator",
            one_in: 5,
            lost_per_sample: 3e-8,
            draw: draw_by_evaluator,
            runs_programs: true,
            is_coarse: false,
        },
    ];
    all.extend(device().map(|device| Renderer {
        name: "gpu",
        one_in: 20,
        lost_per_sample: 2e-7,
        draw: draw_on_gpu,
        runs_programs: true,
        is_coarse: !device.adapter().is_software,
    }));
    all
}

/// The graphics device of all tests; none, and a line that says so, without an adapter.
///
/// # Panics
/// Without an adapter if the environment says `CI=true`.
pub fn device() -> Option<&'static Device> {
    static DEVICE: OnceLock<Option<Device>> = OnceLock::new();
    let open = || match Device::open(None) {
        Ok(device) => Some(device),
        Err(error) if std::env::var("CI").is_ok_and(|ci| ci == "true") => panic!("{error}"),
        Err(error) => {
            println!("skipped: {error}");
            None
        }
    };
    DEVICE.get_or_init(open).as_ref()
}

fn draw_on_cpu(volume: &Volume, plan: &Plan) -> Image {
    strahl_cpu::Renderer::new(volume)
        .render(plan, &strahl_cpu::Options::default(), &Control::NONE)
        .unwrap_or_else(|error| panic!("cpu: {error}"))
        .image
}

fn draw_by_evaluator(volume: &Volume, plan: &Plan) -> Image {
    strahl_evaluate::Evaluator::new(volume)
        .render(plan, &Control::NONE)
        .unwrap_or_else(|error| panic!("evaluator: {error}"))
        .image
}

fn draw_on_gpu(volume: &Volume, plan: &Plan) -> Image {
    let device = device().expect("it is in the list only with a device");
    strahl_gpu::Renderer::new(device, volume)
        .render(plan, &Control::NONE)
        .unwrap_or_else(|error| panic!("gpu: {error}"))
        .image
}
