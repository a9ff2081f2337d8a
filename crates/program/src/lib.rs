//! Makes the linked program that draws a Plan, and the data that the program reads.
//!
//! Every renderer of linked programs needs the functions that a Plan selects, the bytes of two uniform
//! blocks, and the tables and bricks as one texture each. The GPU renderer copies this data to a
//! device. The evaluator reads it in place.
//!
//! ```
//! use strahl_program::program;
//! use strahl_scene::{Scene, resolve};
//! use strahl_volume::Phantom;
//!
//! let volume = Phantom::Tree.volume([8, 8, 8])?;
//! let plan = resolve(&Scene::default(), &volume.header(), None)?;
//! assert!(program(&plan)?.wgsl().contains("fn composite_add"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![warn(missing_docs)]

mod bricks;
mod frame;
mod functions;
mod segments;
mod slicing;
mod tables;

pub use bricks::{occupancy, visible_bricks};
pub use frame::{Frame, ImportanceBlock, Object, rows, single};
pub use functions::Functions;
pub use segments::SegmentTable;
pub use slicing::{
    Blend, BlendPart, Factor, MOST_SLICES, Operation, Order, Slices, Slicing, SlicingError,
};
pub use tables::{Table2d, noise_tile, stacked, tables};

use std::sync::Arc;
use strahl_scene::plan::Plan;
use strahl_shader::{Error, Linker, Program, RayLoop, Techniques, Texels, ray_loop};

/// The program that draws `plan` where the texture unit interpolates the volumes; no device is needed.
///
/// # Errors
/// The functions cannot be linked.
pub fn program(plan: &Plan) -> Result<Arc<Program>, Error> {
    let functions = Functions::of(plan, true, |_, threshold| f64::from(threshold))?;
    let skeleton = ray_loop(&loop_of(plan, Texels::Float))?;
    Linker::new().link(&skeleton, &functions.selection)
}

/// On what it depends by which technique a sample of `plan` is drawn.
pub fn techniques_of(plan: &Plan) -> Techniques {
    if plan.labeled().is_some() {
        Techniques::OfSegments
    } else if plan.has_one_technique() {
        Techniques::One
    } else {
        Techniques::OfObjects
    }
}

/// Whether the runs of segments of `plan` have the importance of their places, too.
pub fn has_important_places(plan: &Plan) -> bool {
    plan.weighs_runs() && plan.importance.is_some()
}

/// The ray loop of `plan` over volumes that are all read in the same way.
pub fn loop_of(plan: &Plan, texels: Texels) -> RayLoop {
    let volumes = plan.drawn_fields().map(|field| field.volume + 1).max();
    RayLoop {
        volumes: vec![texels; volumes.unwrap_or(1)],
        objects: plan.layers.len(),
        is_before_geometry: !plan.meshes.is_empty(),
        techniques: techniques_of(plan),
        is_finite: false,
        has_important_places: has_important_places(plan),
    }
}
