//! The processor: the wires between the units, and what happens in one clock.
//!
//! ```text
//!   host ──> parameter RAM ──> queue ──issue──> memory ──data──> interpolate ──sample──> classify ──> absorb ──> shade ──> composite ──> tile
//!                                ^                 │                                                     │
//!                                └── sort bus ── P + Δ·d  (loop)                     terminate ──> queue ┘
//! ```
//!
//! Units are evaluated from the last to the first; every unit takes the word that leaves the delay before it, and puts
//! its own into the delay behind it. A clock in which the memory holds the pipeline is not evaluated, only counted.

use crate::Error;
use crate::counters::Counters;
use crate::frame::{Fragment, Frame};
use crate::latch::Delay;
use crate::memory::{Access, Memory};
use crate::messages::{Classified, Lit, Read, Return, Sample, Slot, Terminate, Visible};
use crate::observer::{Nobody, Observer, Wires};
use crate::ray_queue::{Rank, SortedQueue, Waiting};
use crate::rays::Ray;
use crate::spec::{Classification, Handover, Leaping, Order, Reconstruction, Scheduling};
use crate::stages::absorb::Absorber;
use crate::stages::address::AddressGenerator;
use crate::stages::composite::Compositor;
use crate::stages::interpolate::Interpolator;
use crate::stages::shade::length;
use std::ops::ControlFlow;

/// What a run leaves.
#[derive(Clone, Debug)]
pub struct Run {
    /// Pixels per row and rows.
    pub size: [u32; 2],
    /// The picture, 0 to 1, first row at the top; of colours, their mean.
    pub picture: Vec<f32>,
    /// The picture in colour, if there are materials.
    pub color: Option<Vec<[f32; 3]>>,
    /// How much light each pixel's ray lets pass to the background, 0 to 1, first row at the top.
    pub passing: Vec<f32>,
    /// Row stalls that the reads of each pixel's ray met, first row at the top.
    pub stalls_of_pixel: Vec<u32>,
    /// The same by the document's counter.
    pub thesis_changes_of_pixel: Vec<u32>,
    /// Rays that ended early, as the host reads the register.
    pub ended_early: Vec<bool>,
    /// All counts.
    pub counters: Counters,
    /// Whether all tiles are drawn, or somebody stopped the run.
    pub is_complete: bool,
}

/// Called after every tile with the number of tiles drawn and of all; `Break` stops the run, which then has what there is.
pub type Progress<'p> = &'p dyn Fn(usize, usize) -> ControlFlow<()>;

/// A [`Progress`] that does nothing.
pub fn no_progress(_drawn: usize, _total: usize) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Runs a frame to its end. With several pipelines the observer sees the first.
///
/// # Errors
/// None today; what can be wrong is found by [`Frame::new`].
pub fn run(frame: &Frame, observer: &mut impl Observer, progress: Progress) -> Result<Run, Error> {
    let spec = &frame.spec;
    let pipelines = spec.queue.pipelines as usize;
    let in_background = spec.queue.scheduling != Scheduling::Freeze;
    let mut memory = Memory::new(&spec.memory, frame.layout.clone(), in_background);
    let mut nobody = vec![Nobody; pipelines - 1];
    let mut first = Processor::new(frame, observer, 0);
    let mut others: Vec<_> = nobody
        .iter_mut()
        .enumerate()
        .map(|(i, nobody)| Processor::new(frame, nobody, i + 1))
        .collect();
    let mut turn = 0;
    let mut told = 0;
    let mut is_complete = true;
    while !(first.is_done() && others.iter().all(Processor::is_done)) {
        if others.is_empty() {
            let frozen = first.tick(&mut memory, true, 0);
            first.advance(frozen);
        } else {
            // The memory takes so many reads per clock, in turn; whoever waits for a row holds all.
            let mut ports = spec.memory.ports;
            let mut frozen = 0;
            for k in 0..pipelines {
                let pipeline = (turn + k) % pipelines;
                let (held, has_read) = match pipeline.checked_sub(1) {
                    None => first.tick_counted(&mut memory, ports > 0, frozen),
                    Some(i) => others[i].tick_counted(&mut memory, ports > 0, frozen),
                };
                ports -= u32::from(has_read);
                frozen += held;
            }
            turn = (turn + 1) % pipelines;
            first.advance(frozen);
            for other in &mut others {
                other.advance(frozen);
            }
        }
        let tiles = first.counters.tiles + others.iter().map(|o| o.counters.tiles).sum::<u64>();
        if tiles as usize != told {
            told = tiles as usize;
            if progress(told, frame.setup.tile_count()).is_break() {
                is_complete = first.is_done() && others.iter().all(Processor::is_done);
                break;
            }
        }
    }
    let others = others
        .into_iter()
        .map(|other| (other.counters, other.results))
        .collect();
    Ok(first.finish(others, &mut memory, is_complete))
}

/// Half of the parameter RAM: the tile in it.
#[derive(Clone, Debug, Default)]
struct Half {
    is_active: bool,
    tile: u32,
    /// Rays still to enter the queue, next one last.
    pending: Vec<(Slot, u32)>,
    /// Rays of the tile.
    rays: usize,
    /// Rays that are not at their end.
    rays_left: usize,
    /// Samples on their way through the data path.
    samples: usize,
    /// When its parameters are there.
    arrives: u64,
}

/// State of a ray in the data path.
#[derive(Clone, Copy, Debug, Default)]
struct Light {
    passing: u32,
    accumulator: [u32; 3],
    /// The polygon in front of which the ray still is.
    fragment: Option<Fragment>,
    /// Word (pre-integration) or opacity (adaptive sampling) of the sample before.
    before: u32,
    has_ended: bool,
}

/// A processor in the middle of a frame.
pub struct Processor<'f, O> {
    frame: &'f Frame,
    observer: &'f mut O,
    // Units.
    generator: AddressGenerator,
    interpolator: Interpolator,
    absorber: Absorber,
    compositor: Compositor,
    // State of the ray manager.
    queue: SortedQueue,
    rays: Vec<Ray>,
    /// Rays that are known at the queue to have ended.
    ended: Vec<bool>,
    /// Steps since the sample before, as far as they are to be interpolated.
    gaps: Vec<u8>,
    halves: [Half; 2],
    half_size: usize,
    next_tile: usize,
    /// From one tile to the next: the number of pipelines.
    stride: usize,
    /// Rays in the loop that come back.
    returning: usize,
    bus_free: u64,
    // State of the data path.
    light: Vec<Light>,
    // Latches.
    to_sort: Delay<Return>,
    to_interpolate: Delay<Read>,
    to_classify: Delay<Sample>,
    to_absorb: Delay<Classified>,
    to_shade: Delay<Visible>,
    to_composite: Delay<Lit>,
    to_tile: Delay<Lit>,
    to_queue: Delay<Terminate>,
    // Results.
    clock: u64,
    /// Counts so far.
    pub counters: Counters,
    results: Results,
}

/// Pixels, first row at the bottom.
struct Results {
    picture: Vec<[f32; 3]>,
    passing: Vec<f32>,
    stalls_of_pixel: Vec<u32>,
    thesis_changes_of_pixel: Vec<u32>,
    ended_early: Vec<bool>,
}

impl<'f, O: Observer> Processor<'f, O> {
    /// Before the first clock; `pipeline` is which of `queue.pipelines` it is.
    pub fn new(frame: &'f Frame, observer: &'f mut O, pipeline: usize) -> Processor<'f, O> {
        let spec = &frame.spec;
        let widths = &spec.widths;
        let l = &spec.latency;
        let half_size = (spec.queue.bundle[0] * spec.queue.bundle[1]) as usize;
        let pixels = frame.setup.pixel_count();
        let compositor = Compositor {
            intensity: widths.intensity,
            fraction: widths.accumulator_fraction,
            transmittance: widths.transmittance,
        };
        let background = spec.look.background.clamp(0.0, 1.0) as f32;
        let mut processor = Processor {
            frame,
            observer,
            generator: AddressGenerator::new(widths.position_fraction, widths.fraction),
            interpolator: Interpolator {
                fraction: widths.fraction,
                guard: widths.lerp_guard,
            },
            absorber: Absorber {
                data: widths.data,
                transmittance: widths.transmittance,
                threshold: (spec.optimisation.termination_threshold
                    * f64::from(1u32 << widths.transmittance))
                .round() as u32,
            },
            compositor,
            queue: SortedQueue::new(half_size),
            rays: vec![Ray::default(); 2 * half_size],
            ended: vec![false; 2 * half_size],
            gaps: vec![1; 2 * half_size],
            halves: [Half::default(), Half::default()],
            half_size,
            next_tile: pipeline,
            stride: spec.queue.pipelines as usize,
            returning: 0,
            bus_free: 0,
            light: vec![Light::default(); 2 * half_size],
            to_sort: Delay::new(l.parameter + l.memory + l.multiply + l.add + l.sort),
            to_interpolate: Delay::new(l.parameter + l.memory),
            to_classify: Delay::new(3 * l.lerp),
            to_absorb: Delay::new(l.classify),
            to_shade: Delay::new(l.absorb),
            to_composite: Delay::new(l.shade),
            to_tile: Delay::new(l.composite),
            to_queue: Delay::new(l.absorb + l.terminate),
            clock: 0,
            counters: Counters::default(),
            results: Results {
                picture: vec![[background; 3]; pixels],
                passing: vec![1.0; pixels],
                stalls_of_pixel: vec![0; pixels],
                thesis_changes_of_pixel: vec![0; pixels],
                ended_early: vec![false; pixels],
            },
        };
        for half in 0..2 {
            processor.order_parameters(half);
        }
        processor
    }

    /// Whether the last result is there.
    #[inline(always)]
    pub fn is_done(&self) -> bool {
        self.next_tile >= self.frame.setup.tile_count()
            && !self.halves[0].is_active
            && !self.halves[1].is_active
    }

    /// As [`tick`](Processor::tick), and whether there was a read.
    fn tick_counted(&mut self, memory: &mut Memory, may_read: bool, held: u32) -> (u32, bool) {
        let before = self.counters.reads;
        let frozen = self.tick(memory, may_read, held);
        (frozen, self.counters.reads > before)
    }

    /// The clocks that a tick has taken.
    #[inline(always)]
    fn advance(&mut self, frozen: u32) {
        self.clock += 1 + u64::from(frozen);
    }

    /// One clock: evaluates all units, then the clock edge; how many clocks the memory holds everything behind it. `held`
    /// is how long other pipelines already hold it, `may_read` whether it has a port left.
    #[inline(always)]
    pub fn tick(&mut self, memory: &mut Memory, may_read: bool, held: u32) -> u32 {
        let composited = self.to_tile.output();
        if let Some(lit) = composited {
            self.composite(lit);
        }
        let lit = self.to_composite.output();
        let visible = self.to_shade.output();
        let to_composite = visible.map(|visible| self.shade(visible));
        let classified = self.to_absorb.output();
        let (to_shade, to_queue) = classified.map_or((None, None), |word| self.absorb(word));
        let sample = self.to_classify.output();
        let to_absorb = sample.map(|sample| self.classify(sample));
        let data = self.to_interpolate.output();
        let to_classify = data.map(|read| self.interpolate(read));
        let terminate = self.to_queue.output();
        if let Some(Terminate(slot)) = terminate {
            self.ended[slot.index()] = true;
        }
        let sort = self.to_sort.output();
        let is_sort_bus_free = match sort {
            Some(back) => !self.take_back(back),
            None => true,
        };
        self.feed(is_sort_bus_free);
        let waiting = self.queue.len();
        let (issue, is_sample, back, access) = self.issue(memory, may_read, held);

        let frozen = access.row_clocks + access.refresh_clocks + access.serial_clocks;
        if O::LOOKS {
            self.observer.clock(&Wires {
                clock: self.clock,
                frozen,
                waiting,
                issue,
                data,
                sort,
                sample,
                classified,
                visible,
                terminate,
                lit,
                composited: composited.map(|lit| lit.slot),
            });
        }
        // The clock edge.
        self.to_tile.shift(lit);
        self.to_composite.shift(to_composite);
        self.to_shade.shift(to_shade);
        self.to_queue.shift(to_queue);
        self.to_absorb.shift(to_absorb);
        self.to_classify.shift(to_classify);
        self.to_interpolate.shift(issue.filter(|_| is_sample));
        self.to_sort.shift(back);
        frozen
    }

    // ----- ray manager -----

    /// A ray comes back over the sort bus; whether it does, or is at its end.
    #[inline(always)]
    fn take_back(&mut self, back: Return) -> bool {
        let half = self.half_of(back.slot);
        let Some(key) = back.key else {
            self.end_ray(half);
            return false;
        };
        self.returning -= 1;
        if self.ended[back.slot.index()] {
            self.drop_ended(back.slot);
            return false;
        }
        self.queue.insert(Waiting {
            slot: back.slot,
            rank: Rank::new(self.halves[half].tile, key),
        });
        true
    }

    /// Lets rays of the next tile in, as the handover says.
    #[inline(always)]
    fn feed(&mut self, is_sort_bus_free: bool) {
        match self.frame.spec.queue.handover {
            Handover::WhenEmpty => {
                if self.queue.is_empty() {
                    if self.halves.iter().all(|half| half.pending.is_empty()) {
                        self.begin_tile();
                    }
                    // Preloaded: all of them at once.
                    while self.feed_one() {}
                } else if is_sort_bus_free && self.has_pending() {
                    self.feed_one();
                }
            }
            Handover::WhenDone => {
                if !self.halves[0].is_active && !self.halves[1].is_active {
                    self.begin_tile();
                    while self.feed_one() {}
                }
            }
            Handover::Serial => {
                if !self.halves[0].is_active && !self.halves[1].is_active {
                    self.begin_tile();
                }
                if self.has_pending() {
                    self.feed_one();
                }
            }
            Handover::Refill => {
                // Through the far end, beside the sort bus: with it alone the first few rays would keep it busy, and the
                // others never came in.
                if !self.has_pending() {
                    self.begin_tile();
                }
                self.feed_one();
            }
        }
    }

    fn has_pending(&self) -> bool {
        !self.halves[0].pending.is_empty() || !self.halves[1].pending.is_empty()
    }

    /// One pending ray enters, if a stage is free.
    fn feed_one(&mut self) -> bool {
        if self.queue.len() + self.returning >= self.half_size {
            return false;
        }
        let [a, b] = &self.halves;
        let half = match (a.pending.is_empty(), b.pending.is_empty()) {
            (true, true) => return false,
            (false, true) => 0,
            (true, false) => 1,
            (false, false) => usize::from(b.tile < a.tile),
        };
        let tile = self.halves[half].tile;
        if let Some((slot, key)) = self.halves[half].pending.pop() {
            self.queue.insert(Waiting {
                slot,
                rank: Rank::new(tile, key),
            });
        }
        true
    }

    /// Takes the next tile that has rays into a free half of the parameter RAM.
    fn begin_tile(&mut self) {
        loop {
            if self.next_tile >= self.frame.setup.tile_count() {
                return;
            }
            let half = self.next_tile / self.stride % 2;
            if self.halves[half].is_active {
                return;
            }
            if self.frame.spec.host.is_waited_for && self.halves[half].arrives > self.clock {
                return;
            }
            let tile = self.next_tile;
            self.next_tile += self.stride;
            let rays = self.frame.setup.tile(tile);
            if rays.is_empty() {
                // Nothing is sent for it, and it has no result.
                self.counters.tiles += 1;
                continue;
            }
            self.observer.tile(self.clock, tile, half);
            let first = half * self.half_size;
            let mut pending: Vec<(Slot, u32)> = Vec::with_capacity(rays.len());
            for (i, ray) in rays.iter().enumerate() {
                let slot = first + i;
                self.rays[slot] = *ray;
                self.ended[slot] = false;
                self.gaps[slot] = 1;
                self.light[slot] = Light {
                    passing: self.absorber.full(),
                    fragment: self
                        .frame
                        .fragments
                        .as_ref()
                        .and_then(|f| f[ray.pixel as usize]),
                    ..Light::default()
                };
                self.counters.samples += u64::from(ray.remaining);
                pending.push((Slot(slot as u16), self.key(ray)));
            }
            self.counters.rays += rays.len() as u64;
            // Taken from the end: smallest key last, and the first of equal ones last.
            pending.reverse();
            pending.sort_by_key(|(_, key)| std::cmp::Reverse(*key));
            let state = &mut self.halves[half];
            state.is_active = true;
            state.tile = tile as u32;
            state.pending = pending;
            state.rays = rays.len();
            state.rays_left = rays.len();
            state.samples = 0;
            return;
        }
    }

    /// The sort key of a ray; rays that are not sorted all have the same.
    #[inline(always)]
    fn key(&self, ray: &Ray) -> u32 {
        match self.frame.spec.queue.order {
            Order::PlaneDistance => ray.plane,
            Order::RemainingLength => ((1 << self.frame.spec.widths.key) - 1) - ray.remaining,
            Order::RoundRobin => 0,
        }
    }

    #[inline(always)]
    fn half_of(&self, slot: Slot) -> usize {
        usize::from(slot.index() >= self.half_size)
    }

    fn drop_ended(&mut self, slot: Slot) {
        let half = self.half_of(slot);
        self.counters.skipped_by_termination += u64::from(self.rays[slot.index()].remaining);
        self.end_ray(half);
    }

    #[inline(always)]
    fn end_ray(&mut self, half: usize) {
        self.halves[half].rays_left -= 1;
        self.finish_tile(half);
    }

    /// If nothing of a tile is on its way any more, the host gets it.
    #[inline(always)]
    fn finish_tile(&mut self, half: usize) {
        let state = &self.halves[half];
        if state.rays_left > 0 || state.samples > 0 || !state.is_active {
            return;
        }
        let background = (self.frame.spec.look.background
            * f64::from((1u32 << self.frame.spec.widths.intensity) - 1))
        .round() as u32;
        let first = half * self.half_size;
        for slot in first..first + state.rays {
            let light = &mut self.light[slot];
            if !light.has_ended {
                // A polygon behind the last sample.
                merge_fragment(&self.absorber, &self.compositor, light);
            }
            let pixel = self.rays[slot].pixel as usize;
            self.results.picture[pixel] = light.accumulator.map(|accumulator| {
                let result = self
                    .compositor
                    .finish(accumulator, light.passing, background);
                self.compositor.to_f32(result)
            });
            self.results.passing[pixel] = light.passing as f32 / self.absorber.full() as f32;
            self.results.ended_early[pixel] = light.has_ended;
            self.counters.rays_ended_early += u64::from(light.has_ended);
        }
        self.counters.tiles += 1;
        self.halves[half].is_active = false;
        // Results go first, then the half is free for parameters.
        let results = self.frame.spec.queue.bundle[0] * self.frame.spec.queue.bundle[1];
        self.transfer(u64::from(results) * u64::from(self.frame.spec.widths.intensity.div_ceil(8)));
        if self.next_tile < self.frame.setup.tile_count() {
            self.order_parameters(half);
        }
    }

    /// P, Δ and L of all rays of a tile, in whole bytes each.
    fn order_parameters(&mut self, half: usize) {
        let mut bytes = crate::host::parameter_bytes(&self.frame.spec);
        if let Some(deformation) = &self.frame.deformation {
            bytes += 4 * u64::from(deformation.planes) * self.half_size as u64;
        }
        self.transfer(bytes);
        self.halves[half].arrives = self.bus_free;
    }

    fn transfer(&mut self, bytes: u64) {
        let host = &self.frame.spec.host;
        let clocks = bytes as f64 / host.bus_mb_per_s * self.frame.spec.clock_mhz;
        self.bus_free = self.bus_free.max(self.clock) + clocks.ceil() as u64;
        self.counters.host_bytes += bytes;
    }

    // ----- address generator and memory -----

    /// The next ray goes to the memory: the read, whether its sample goes on, its return, and what the memory said.
    #[inline(always)]
    fn issue(
        &mut self,
        memory: &mut Memory,
        may_read: bool,
        held: u32,
    ) -> (Option<Read>, bool, Option<Return>, Access) {
        let nothing = (None, false, None, Access::default());
        if self.frame.spec.queue.handover == Handover::Serial && self.has_pending() {
            self.counters.bubbles_filling += 1;
            return nothing;
        }
        if !may_read && !self.queue.is_empty() {
            self.counters.bubbles_shared += 1;
            return nothing;
        }
        let now = self.clock + u64::from(held);
        let next = match self.frame.spec.queue.scheduling {
            Scheduling::Freeze => self.queue.pop(),
            Scheduling::ReadyRowFirst { window } => {
                let (next, access) = self.ready_ray(memory, now, window);
                if next.is_none() && !self.queue.is_empty() {
                    self.counters.bubbles_rows += 1;
                    return (None, false, None, access);
                }
                next
            }
        };
        let Some(Waiting { slot, .. }) = next else {
            let is_host_late = self.frame.spec.host.is_waited_for
                && self.next_tile < self.frame.setup.tile_count()
                && !self.halves[self.next_tile / self.stride % 2].is_active;
            if is_host_late {
                self.counters.bubbles_host += 1;
            } else {
                self.counters.bubbles_empty += 1;
            }
            return nothing;
        };
        if self.ended[slot.index()] {
            self.counters.bubbles_ended += 1;
            self.drop_ended(slot);
            return nothing;
        }
        let ray = self.rays[slot.index()];
        let position = self.bent(&ray);
        let cell = self.generator.cell(position);
        let access = memory.access(now, cell);
        self.count_access(&access, ray.pixel);

        // The distance arrives with the voxels; what it does to the ray is known when the ray comes back.
        let word = match &self.frame.distance {
            Some(distance) => u32::from(distance.steps(cell)),
            None => 0,
        };
        let mut is_sample = word == 0 || self.frame.spec.optimisation.leaping == Leaping::Document;
        if self.frame.fragments.is_some() {
            // An empty sample carries the news that a polygon is passed.
            let fragment = self.light[slot.index()].fragment;
            is_sample |= fragment.is_some_and(|f| ray.plane >= u32::from(f.plane));
        }
        let mut steps = word.max(1);
        if word == 0
            && let Some(radius) = &self.frame.radius
        {
            // The last sample is always read.
            steps = u32::from(radius.steps(cell))
                .min(ray.remaining.saturating_sub(1))
                .max(1);
            self.counters.skipped_by_adaptive_sampling += u64::from(steps - 1);
        } else {
            self.counters.skipped_by_leaping += u64::from(steps.min(ray.remaining) - 1);
        }
        self.counters.reads += 1;
        if word == 0 {
            self.counters.sample_reads += 1;
        } else {
            self.counters.distance_only_reads += 1;
        }
        let read = Read {
            slot,
            position,
            steps: self.gaps[slot.index()],
            plane: ray.plane as u16,
        };
        self.gaps[slot.index()] = if word == 0 { steps as u8 } else { 1 };
        let steps = steps.min(ray.remaining);
        let ray = &mut self.rays[slot.index()];
        ray.position = AddressGenerator::advance(ray.position, ray.step, steps);
        ray.remaining -= steps;
        ray.plane += steps;
        let key = (ray.remaining > 0).then(|| {
            let ray = self.rays[slot.index()];
            self.key(&ray)
        });
        self.returning += usize::from(key.is_some());
        if is_sample {
            let half = self.half_of(slot);
            self.halves[half].samples += 1;
        }
        (Some(read), is_sample, Some(Return { slot, key }), access)
    }

    /// The first of the next `window` rays whose rows are open; the rows of the first are opened meanwhile.
    fn ready_ray(
        &mut self,
        memory: &mut Memory,
        now: u64,
        window: u32,
    ) -> (Option<Waiting>, Access) {
        if self.queue.is_empty() {
            // A refresh that is due waits for the next ray, so that its clocks are counted once.
            return (None, Access::default());
        }
        let Some((dram, layout)) = memory.dram() else {
            return (self.queue.pop(), Access::default());
        };
        let after = dram.refresh(now as i64);
        if after > now as i64 {
            let refresh_clocks = (after - now as i64) as u32;
            self.counters.frozen_for_refresh += u64::from(refresh_clocks);
            let access = Access {
                refresh_clocks,
                ..Access::default()
            };
            return (None, access);
        }
        for place in 0..(window as usize).min(self.queue.len()) {
            let Some(waiting) = self.queue.get(place) else {
                break;
            };
            let cell = self
                .generator
                .cell(self.rays[waiting.slot.index()].position);
            if self.ended[waiting.slot.index()] || dram.is_ready(now, cell, layout) {
                return (self.queue.remove(place), Access::default());
            }
            if place == 0 {
                let opened = dram.prepare(now, cell, layout);
                self.counters.row_changes += u64::from(opened);
                self.counters.row_stalls += u64::from(opened > 0);
            }
        }
        (None, Access::default())
    }

    /// The position of a ray's sample, bent if rays are.
    #[inline(always)]
    fn bent(&self, ray: &Ray) -> [i32; 3] {
        let Some(deformation) = &self.frame.deformation else {
            return ray.position;
        };
        let plane = ray.plane.min(deformation.planes.saturating_sub(1));
        let index = ray.pixel as usize * deformation.planes as usize + plane as usize;
        let Some([right, up]) = deformation.offsets.get(index).copied() else {
            return ray.position;
        };
        let axes = &self.frame.setup.axes;
        let offset = (axes.right * f64::from(right) + axes.up * f64::from(up)) / 256.0;
        let one = f64::from(1u32 << self.frame.spec.widths.position_fraction);
        let offset = (offset * one).round().to_array();
        std::array::from_fn(|i| ray.position[i].wrapping_add(offset[i] as i32))
    }

    #[inline(always)]
    fn count_access(&mut self, access: &Access, pixel: u32) {
        if *access == Access::default() {
            return;
        }
        let counters = &mut self.counters;
        counters.frozen_for_rows += u64::from(access.row_clocks);
        counters.frozen_for_refresh += u64::from(access.refresh_clocks);
        counters.frozen_for_words += u64::from(access.serial_clocks);
        counters.row_changes += u64::from(access.module_misses);
        counters.row_stalls += u64::from(access.module_misses > 0);
        counters.thesis_row_changes += u64::from(access.thesis_changes);
        self.results.stalls_of_pixel[pixel as usize] += u32::from(access.module_misses > 0);
        self.results.thesis_changes_of_pixel[pixel as usize] += access.thesis_changes;
    }

    // ----- data path -----

    #[inline(always)]
    fn interpolate(&self, read: Read) -> Sample {
        let address = self.generator.split(read.position);
        let modules = self.frame.voxels.modules(address.cell, address.lowest);
        let fraction = match self.frame.spec.look.reconstruction {
            Reconstruction::Trilinear => address.fraction,
            Reconstruction::Nearest => {
                let one = 1 << self.interpolator.fraction;
                address.fraction.map(|x| if 2 * x >= one { one } else { 0 })
            }
        };
        let (value, gradient) = self
            .interpolator
            .interpolate(modules, fraction, address.lowest);
        Sample {
            slot: read.slot,
            value,
            gradient,
            steps: read.steps,
            plane: read.plane,
        }
    }

    #[inline(always)]
    fn classify(&mut self, sample: Sample) -> Classified {
        let mut before = sample.value;
        if self.frame.spec.look.classification == Classification::PreIntegrated {
            let light = &mut self.light[sample.slot.index()];
            before = std::mem::replace(&mut light.before, sample.value);
        }
        Classified {
            slot: sample.slot,
            opacity: self.frame.tables.opacity(before, sample.value),
            gradient: sample.gradient,
            steps: sample.steps,
            plane: sample.plane,
            word: sample.value as u16,
        }
    }

    #[inline(always)]
    fn absorb(&mut self, word: Classified) -> (Option<Visible>, Option<Terminate>) {
        let light = &mut self.light[word.slot.index()];
        if light.has_ended {
            self.counters.wasted_samples += 1;
            let half = self.half_of(word.slot);
            self.halves[half].samples -= 1;
            self.finish_tile(half);
            return (None, None);
        }
        if light.fragment.is_some_and(|f| word.plane >= f.plane) {
            light.has_ended = merge_fragment(&self.absorber, &self.compositor, light);
            if light.has_ended {
                let half = self.half_of(word.slot);
                self.halves[half].samples -= 1;
                self.finish_tile(half);
                return (None, Some(Terminate(word.slot)));
            }
        }
        let (mut weight, mut passing, mut ends) = (0, light.passing, false);
        if word.steps > 1 {
            // Samples that were not read lie on a line between the one before and this one.
            for step in 1..u32::from(word.steps) {
                let gap = u32::from(word.steps);
                let opacity = ((gap - step) * light.before + step * word.opacity + gap / 2) / gap;
                let (added, behind, is_last) = self.absorber.absorb(opacity, passing);
                (weight, passing, ends) = (weight + added, behind, is_last);
                if ends {
                    break;
                }
            }
        }
        if !ends {
            let (added, behind, is_last) = self.absorber.absorb(word.opacity, passing);
            (weight, passing, ends) = (weight + added, behind, is_last);
        }
        if self.frame.radius.is_some() {
            light.before = word.opacity;
        }
        light.passing = passing;
        light.has_ended = ends;
        let visible = Visible {
            slot: word.slot,
            weight,
            gradient: word.gradient,
            word: word.word,
        };
        (Some(visible), ends.then_some(Terminate(word.slot)))
    }

    #[inline(always)]
    fn shade(&self, visible: Visible) -> Lit {
        let look = &self.frame.spec.look;
        let widths = &self.frame.spec.widths;
        let mut weight = visible.weight;
        if look.gradient_weighting {
            let length = length(
                visible.gradient,
                widths.lerp_guard,
                widths.data,
                look.gradient_gain,
            );
            weight = crate::fixed_point::scaled(
                weight,
                crate::fixed_point::whole(length, widths.data),
                widths.data,
            );
        }
        let intensity = match (&self.frame.materials, &self.frame.map) {
            (Some(materials), _) => materials.reflect(visible.word, visible.gradient),
            (None, Some(map)) => [map.reflect(visible.gradient); 3],
            (None, None) => [(1 << widths.intensity) - 1; 3],
        };
        Lit {
            slot: visible.slot,
            weight,
            intensity,
        }
    }

    #[inline(always)]
    fn composite(&mut self, lit: Lit) {
        let light = &mut self.light[lit.slot.index()];
        for (accumulator, intensity) in light.accumulator.iter_mut().zip(lit.intensity) {
            *accumulator = self.compositor.add(*accumulator, lit.weight, intensity);
        }
        let half = self.half_of(lit.slot);
        self.halves[half].samples -= 1;
        self.finish_tile(half);
    }

    fn finish(
        self,
        others: Vec<(Counters, Results)>,
        memory: &mut Memory,
        is_complete: bool,
    ) -> Run {
        let mut counters = self.counters;
        let mut results = self.results;
        for (pipeline, (counted, theirs)) in others.into_iter().enumerate() {
            counters.add(&counted);
            let owns = |pixel: usize| self.frame.setup.tile_of(pixel) % self.stride == pipeline + 1;
            for pixel in (0..results.picture.len()).filter(|pixel| owns(*pixel)) {
                results.picture[pixel] = theirs.picture[pixel];
                results.passing[pixel] = theirs.passing[pixel];
                results.stalls_of_pixel[pixel] = theirs.stalls_of_pixel[pixel];
                results.thesis_changes_of_pixel[pixel] = theirs.thesis_changes_of_pixel[pixel];
                results.ended_early[pixel] = theirs.ended_early[pixel];
            }
        }
        counters.clocks = self.clock;
        if let Some((dram, _)) = memory.dram() {
            counters.cache_hits = dram.cache_hits;
            counters.cache_misses = dram.cache_misses;
        }
        let [width, height] = self.frame.setup.size;
        let color = top_down(results.picture, width);
        let is_color = self.frame.materials.is_some();
        let grey = |p: &[f32; 3]| match is_color {
            true => (p[0] + p[1] + p[2]) / 3.0,
            false => p[0],
        };
        Run {
            size: [width, height],
            picture: color.iter().map(grey).collect(),
            color: is_color.then_some(color),
            passing: top_down(results.passing, width),
            stalls_of_pixel: top_down(results.stalls_of_pixel, width),
            thesis_changes_of_pixel: top_down(results.thesis_changes_of_pixel, width),
            ended_early: top_down(results.ended_early, width),
            counters,
            is_complete,
        }
    }
}

/// Lays a polygon over what is in front of it; whether the ray ends there.
fn merge_fragment(absorber: &Absorber, compositor: &Compositor, light: &mut Light) -> bool {
    let Some(fragment) = light.fragment.take() else {
        return false;
    };
    let (weight, passing, ends) = absorber.absorb(fragment.opacity, light.passing);
    for (accumulator, intensity) in light.accumulator.iter_mut().zip(fragment.intensity) {
        *accumulator = compositor.add(*accumulator, weight, intensity);
    }
    light.passing = passing;
    // Nothing is seen behind an opaque one, whatever the threshold.
    ends || passing == 0
}

/// Rows in the other order.
fn top_down<T: Clone>(pixels: Vec<T>, width: u32) -> Vec<T> {
    pixels
        .rchunks_exact(width as usize)
        .flatten()
        .cloned()
        .collect()
}
