//! What can be attached to a run from outside: counters and traces see the wires and never change them.

use crate::messages::{
    Classified, LitSample, Read, Return, Sample, Slot, Terminate, VisibleSample,
};

/// The words on the wires in one clock that is not frozen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wires {
    /// Clock, frozen ones included.
    pub clock: u64,
    /// Clocks that the memory then holds everything.
    pub frozen: u32,
    /// Rays that wait in the queue.
    pub waiting: usize,
    /// Queue → memory.
    pub issue: Option<Read>,
    /// Memory → interpolation.
    pub data: Option<Read>,
    /// Address generator → queue.
    pub sort: Option<Return>,
    /// Interpolation → classification.
    pub sample: Option<Sample>,
    /// Classification → absorption.
    pub classified: Option<Classified>,
    /// Absorption → shading.
    pub visible: Option<VisibleSample>,
    /// Absorption → queue.
    pub terminate: Option<Terminate>,
    /// Shading → compositing.
    pub lit: Option<LitSample>,
    /// What compositing has added this clock.
    pub composited: Option<Slot>,
}

/// Sees every clock of a run.
pub trait Observer {
    /// Whether anybody looks; without, nothing is put together.
    const LOOKS: bool = true;

    /// After all units of a clock, before the clock edge.
    fn clock(&mut self, wires: &Wires);

    /// A tile begins: which, and which half of the parameter RAM holds it.
    fn tile(&mut self, _clock: u64, _tile: usize, _half: usize) {}
}

/// Nobody looks.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoObserver;

impl Observer for NoObserver {
    const LOOKS: bool = false;

    fn clock(&mut self, _: &Wires) {}
}
