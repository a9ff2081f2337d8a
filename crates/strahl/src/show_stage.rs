//! Reports of a picture in stages.

use std::ops::ControlFlow;
use strahl_scene::{Image, plan};

/// What [`Render::in_stages`](crate::Render::in_stages) tells of each stage of a picture: `Break` ends it.
pub type ShowStage<'a> =
    &'a (dyn Fn(&Image, &plan::Display, strahl_cpu::Stage) -> ControlFlow<()> + Sync);
