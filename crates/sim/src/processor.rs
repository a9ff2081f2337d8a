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
use crate::access::Access;
use crate::counters::Counters;
use crate::data_path::{DataPath, Light, RayValue, Step};
use crate::frame::Frame;
use crate::latch::Delay;
use crate::memory::Memory;
use crate::messages::{
    Classified, LitSample, Read, Return, Sample, Slot, Terminate, VisibleSample,
};
use crate::observer::{NoObserver, Observer, Wires};
use crate::ray_queue::{Rank, SortedQueue, WaitingRay};
use crate::rays::Ray;
use crate::shadow::ShadowUnit;
use crate::spec::{Handover, Order, Scheduling, Shadow};
use crate::stages::address::AddressGenerator;
use crate::values_ahead::ValuesAhead;
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
    /// Clocks of every slab or board, if there are several.
    pub clocks_of_part: Vec<u64>,
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
    let in_background = frame.spec.queue.scheduling != Scheduling::Freeze;
    let mut memory = Memory::new(&frame.spec.memory, frame.layout.clone(), in_background)
        .with_distances(frame.distance_layout.clone());
    run_on(frame, &mut memory, 0, observer, progress)
}

/// Runs a frame from a clock on, with a memory that has been used before it.
pub(crate) fn run_on<O: Observer>(
    frame: &Frame,
    memory: &mut Memory,
    begin: u64,
    observer: &mut O,
    progress: Progress,
) -> Result<Run, Error> {
    // Light goes from ray to ray, and when a polygon is passed is seen on the way.
    let is_known = !O::LOOKS && frame.fragments.is_none() && frame.spec.shadow == Shadow::None;
    if !is_known {
        return run_as::<O, false>(frame, None, memory, begin, observer, progress);
    }
    let ahead = ValuesAhead::new(frame);
    rayon::in_place_scope(|scope| {
        // This thread is one of them.
        for _ in 1..rayon::current_num_threads() {
            scope.spawn(|_| ahead.work());
        }
        let drawn = run_as::<O, true>(frame, Some(&ahead), memory, begin, observer, progress);
        ahead.stop();
        drawn
    })
}

fn run_as<O: Observer, const KNOWN: bool>(
    frame: &Frame,
    ahead: Option<&ValuesAhead>,
    memory: &mut Memory,
    begin: u64,
    observer: &mut O,
    progress: Progress,
) -> Result<Run, Error> {
    let spec = &frame.spec;
    let pipelines = spec.queue.pipelines as usize;
    let mut nobody = vec![NoObserver; pipelines - 1];
    let mut first = Processor::<O, KNOWN>::new(frame, observer, 0);
    let mut others: Vec<Processor<NoObserver, KNOWN>> = nobody
        .iter_mut()
        .enumerate()
        .map(|(i, nobody)| Processor::new(frame, nobody, i + 1))
        .collect();
    first.clock = begin;
    first.ahead = ahead;
    for other in &mut others {
        other.clock = begin;
        other.ahead = ahead;
    }
    let mut turn = 0;
    let mut told = 0;
    let mut is_complete = true;
    while !(first.is_done() && others.iter().all(Processor::is_done)) {
        if others.is_empty() {
            let frozen = first.tick(memory, true, 0);
            first.advance(frozen);
        } else {
            // The memory takes so many reads per clock, in turn; whoever waits for a row holds all.
            let mut ports = spec.memory.ports;
            let mut frozen = 0;
            for k in 0..pipelines {
                let pipeline = (turn + k) % pipelines;
                let (held, has_read) = match pipeline.checked_sub(1) {
                    None => first.tick_counted(memory, ports > 0, frozen),
                    Some(i) => others[i].tick_counted(memory, ports > 0, frozen),
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
    let mut run = first.finish(others, memory, is_complete);
    run.counters.clocks -= begin;
    Ok(run)
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
    /// News of ended rays on their way to the queue, which would be taken for that of the next tile's.
    news: usize,
    /// When its parameters are there.
    arrives: u64,
}

/// A sample on its way, if what becomes of its ray is known: number of the ray, and whether the sample ends it.
#[derive(Clone, Copy, Debug)]
struct Token(u32);

/// A processor in the middle of a frame.
///
/// If `KNOWN`, what becomes of every ray is computed ahead, on all cores, and only its samples' places in the
/// pipeline are followed: the same picture and the same counts, as a test compares, but no words for an observer.
pub struct Processor<'f, O, const KNOWN: bool> {
    frame: &'f Frame,
    observer: &'f mut O,
    // Units.
    path: DataPath<'f>,
    // State of the ray manager.
    queue: SortedQueue,
    rays: Vec<Ray>,
    /// Rays that are known at the queue to have ended.
    ended: Vec<bool>,
    /// Steps since the sample before, as far as they are to be interpolated.
    gaps: Vec<u8>,
    /// Two for tiles, two for the light rays of a tile.
    halves: [Half; 4],
    half_size: usize,
    shadow: Option<ShadowUnit>,
    next_tile: usize,
    /// From one tile to the next: the number of pipelines.
    stride: usize,
    /// Rays in the loop that come back.
    returning: usize,
    bus_free: u64,
    // State of the data path.
    light: Vec<Light>,
    /// What is known of the rays in the parameter RAM, and of all.
    known: Vec<RayValue>,
    ahead: Option<&'f ValuesAhead<'f>>,
    // Latches.
    to_sort: Delay<Return>,
    to_interpolate: Delay<Read>,
    to_classify: Delay<Sample>,
    to_absorb: Delay<Classified>,
    to_shade: Delay<VisibleSample>,
    to_composite: Delay<LitSample>,
    to_tile: Delay<LitSample>,
    to_queue: Delay<Terminate>,
    known_to_absorb: Delay<Token>,
    known_to_tile: Delay<Slot>,
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

impl<'f, O: Observer, const KNOWN: bool> Processor<'f, O, KNOWN> {
    /// Before the first clock; `pipeline` is which of `queue.pipelines` it is.
    pub fn new(frame: &'f Frame, observer: &'f mut O, pipeline: usize) -> Self {
        let spec = &frame.spec;
        let widths = &spec.widths;
        let l = &spec.latency;
        let half_size = (spec.queue.bundle[0] * spec.queue.bundle[1]) as usize;
        let slots = if spec.shadow == Shadow::None { 2 } else { 4 } * half_size;
        let pixels = frame.setup.pixel_count();
        let background = spec.look.background.clamp(0.0, 1.0) as f32;
        let mut picture = vec![[background; 3]; pixels];
        let mut passing = vec![1.0; pixels];
        // Where no ray is sent, the host shows the polygon itself.
        for (pixel, fragment) in frame.fragments.iter().flat_map(|f| f.iter().enumerate()) {
            if let Some(fragment) = fragment {
                let share = |word: u32, bits: u32| word as f32 / ((1u32 << bits) - 1) as f32;
                let opacity = share(fragment.opacity, widths.data);
                passing[pixel] = 1.0 - opacity;
                picture[pixel] = fragment.intensity.map(|intensity| {
                    share(intensity, widths.intensity) * opacity + background * (1.0 - opacity)
                });
            }
        }
        let mut processor = Processor {
            frame,
            observer,
            path: DataPath::new(frame),
            queue: SortedQueue::new(half_size),
            rays: vec![Ray::default(); slots],
            ended: vec![false; slots],
            gaps: vec![1; slots],
            halves: Default::default(),
            half_size,
            shadow: ShadowUnit::new(frame),
            next_tile: pipeline,
            stride: spec.queue.pipelines as usize,
            returning: 0,
            bus_free: 0,
            light: vec![Light::default(); slots],
            known: vec![
                RayValue {
                    end_plane: u32::MAX,
                    light: Light::default()
                };
                if KNOWN { slots } else { 0 }
            ],
            ahead: None,
            to_sort: Delay::new(l.parameter + l.memory + l.multiply + l.add + l.sort),
            to_interpolate: Delay::new(l.parameter + l.memory),
            to_classify: Delay::new(3 * l.lerp),
            to_absorb: Delay::new(l.classify),
            to_shade: Delay::new(l.absorb),
            to_composite: Delay::new(l.shade),
            to_tile: Delay::new(l.composite),
            to_queue: Delay::new(l.absorb + l.terminate),
            known_to_absorb: Delay::new(l.parameter + l.memory + 3 * l.lerp + l.classify),
            known_to_tile: Delay::new(l.absorb + l.shade + l.composite),
            clock: 0,
            counters: Counters::default(),
            results: Results {
                picture,
                passing,
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
        self.next_tile >= self.frame.setup.tile_count() && self.is_idle()
    }

    /// Whether no tile is in the parameter RAM.
    #[inline(always)]
    fn is_idle(&self) -> bool {
        !self.halves[0].is_active
            && !self.halves[1].is_active
            && (self.shadow.is_none() || !self.halves[2].is_active && !self.halves[3].is_active)
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
        if KNOWN {
            return self.tick_known(memory, may_read, held);
        }
        let composited = self.to_tile.output();
        if let Some(lit) = composited {
            self.path.composite(&mut self.light[lit.slot.index()], lit);
            self.end_sample(lit.slot);
        }
        let lit = self.to_composite.output();
        let visible = self.to_shade.output();
        let to_composite = visible.map(|visible| self.path.shade(visible));
        let classified = self.to_absorb.output();
        let (to_shade, to_queue) = classified.map_or((None, None), |word| self.absorb(word));
        let sample = self.to_classify.output();
        let to_absorb = sample.map(|sample| {
            self.path
                .classify(&mut self.light[sample.slot.index()], sample)
        });
        let data = self.to_interpolate.output();
        let to_classify = data.map(|read| self.path.interpolate(read));
        let terminate = self.to_queue.output();
        let sort = self.to_sort.output();
        self.manage(terminate, sort);
        let waiting = self.queue.len();
        let (issue, is_sample, back, frozen) = self.issue(memory, may_read, held);
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

    /// A clock in which no word is made, only where samples are.
    #[inline(always)]
    fn tick_known(&mut self, memory: &mut Memory, may_read: bool, held: u32) -> u32 {
        if let Some(slot) = self.known_to_tile.output() {
            self.end_sample(slot);
        }
        let mut to_tile = None;
        let mut to_queue = None;
        if let Some(Token(word)) = self.known_to_absorb.output() {
            let (slot, ends) = (Slot(word as u16), word >> 16 != 0);
            let has_ended = &mut self.light[slot.index()].has_ended;
            if *has_ended {
                self.counters.wasted_samples += 1;
                self.end_sample(slot);
            } else {
                *has_ended = ends;
                to_tile = Some(slot);
                to_queue = self.terminate(slot, ends);
            }
        }
        self.manage(self.to_queue.output(), self.to_sort.output());
        let (issue, is_sample, back, frozen) = self.issue(memory, may_read, held);
        let token = issue.filter(|_| is_sample).map(|read| {
            let ends = self.known[read.slot.index()].end_plane == u32::from(read.plane);
            Token(u32::from(read.slot.0) | u32::from(ends) << 16)
        });
        // The clock edge.
        self.known_to_tile.shift(to_tile);
        self.to_queue.shift(to_queue);
        self.known_to_absorb.shift(token);
        self.to_sort.shift(back);
        frozen
    }

    /// The ray manager before it lets a ray out: who has ended, who comes back, who is new.
    #[inline(always)]
    fn manage(&mut self, terminate: Option<Terminate>, sort: Option<Return>) {
        if let Some(Terminate(slot)) = terminate {
            self.ended[slot.index()] = true;
            let half = self.half_of(slot);
            self.halves[half].news -= 1;
            self.finish_tile(half);
        }
        let is_sort_bus_free = match sort {
            Some(back) => !self.take_back(back),
            None => true,
        };
        self.feed(is_sort_bus_free);
    }

    // ----- ray manager -----

    /// A ray comes back over the sort bus; whether it does, or is at its end.
    #[inline(always)]
    fn take_back(&mut self, back: Return) -> bool {
        let half = self.half_of(back.slot());
        let Some(key) = back.key() else {
            self.end_ray(half);
            return false;
        };
        self.returning -= 1;
        if self.ended[back.slot().index()] {
            self.drop_ended(back.slot());
            return false;
        }
        self.queue.insert(WaitingRay {
            slot: back.slot(),
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
                if self.is_idle() {
                    self.begin_tile();
                    while self.feed_one() {}
                }
            }
            Handover::Serial => {
                if self.is_idle() {
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
        self.halves.iter().any(|half| !half.pending.is_empty())
    }

    /// One pending ray enters, if a stage is free.
    fn feed_one(&mut self) -> bool {
        if self.queue.len() + self.returning >= self.half_size {
            return false;
        }
        let waiting = (0..4).filter(|half| !self.halves[*half].pending.is_empty());
        let Some(half) = waiting.min_by_key(|half| self.halves[*half].tile) else {
            return false;
        };
        let tile = self.halves[half].tile;
        if let Some((slot, key)) = self.halves[half].pending.pop() {
            self.queue.insert(WaitingRay {
                slot,
                rank: Rank::new(tile, key),
            });
        }
        true
    }

    /// Takes the next tile that has rays into a free half of the parameter RAM.
    fn begin_tile(&mut self) {
        if self.shadow.is_some() {
            return self.begin_pass();
        }
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
            let rays = self.rays_of(tile);
            if rays.is_empty() {
                // Nothing is sent for it, and it has no result.
                self.counters.tiles += 1;
                continue;
            }
            return self.fill_half(half, tile, rays);
        }
    }

    /// The rays of a tile.
    fn rays_of(&self, tile: usize) -> Vec<Ray> {
        match self.ahead {
            None => self.frame.setup.tile(tile),
            Some(ahead) => ahead.tile(tile).iter().map(|(ray, _)| *ray).collect(),
        }
    }

    /// With shadows a tile is two passes: its light rays, some planes at a time, then its view rays. A pass begins when all
    /// reads of the one before are on their way.
    fn begin_pass(&mut self) {
        let Some(shadow) = &mut self.shadow else {
            return;
        };
        let is_on_its_way = |halves: &[Half]| halves.iter().all(|half| half.rays_left == 0);
        let half = self.next_tile % 2;
        loop {
            let Some((tile, next_plane, behind)) = shadow.pass else {
                if self.next_tile >= self.frame.setup.tile_count()
                    || !is_on_its_way(&self.halves[..2])
                    || self.halves[half].is_active
                    || (self.frame.spec.host.is_waited_for
                        && self.halves[half].arrives > self.clock)
                {
                    return;
                }
                let tile = shadow.tile_at(self.next_tile);
                shadow.begin(tile, &self.frame.setup.tile(tile));
                continue;
            };
            if next_plane == behind {
                if !is_on_its_way(&self.halves[2..]) {
                    return;
                }
                shadow.pass = None;
                self.next_tile += 1;
                let rays = self.frame.setup.tile(tile);
                if rays.is_empty() {
                    self.counters.tiles += 1;
                    return;
                }
                return self.fill_half(half, tile, rays);
            }
            let Some(free) = (2..4).find(|half| !self.halves[*half].is_active) else {
                return;
            };
            let (rays, samples) = shadow.next_rays();
            self.counters.light_samples += samples;
            if !rays.is_empty() {
                return self.fill_half(free, tile, rays);
            }
        }
    }

    /// The rays of a tile, or its light rays, wait for the queue.
    fn fill_half(&mut self, half: usize, tile: usize, rays: Vec<Ray>) {
        let is_view = half < 2;
        if is_view {
            self.observer.tile(self.clock, tile, half);
        }
        let first = half * self.half_size;
        let mut pending: Vec<(Slot, u32)> = Vec::with_capacity(rays.len());
        for (i, ray) in rays.iter().enumerate() {
            let slot = first + i;
            self.rays[slot] = *ray;
            self.ended[slot] = false;
            self.gaps[slot] = 1;
            self.light[slot] = self.path.light(ray);
            if let Some(ahead) = self.ahead {
                self.known[slot] = ahead.tile(tile)[i].1;
            }
            let samples = if is_view { ray.remaining } else { 0 };
            self.counters.samples += u64::from(samples);
            pending.push((Slot(slot as u16), self.key(ray)));
        }
        if is_view {
            self.counters.rays += rays.len() as u64;
        }
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
        let beyond = |halves: usize| usize::from(slot.index() >= halves * self.half_size);
        beyond(1) + beyond(2) + beyond(3)
    }

    fn drop_ended(&mut self, slot: Slot) {
        let half = self.half_of(slot);
        if half < 2 {
            self.counters.skipped_by_termination += u64::from(self.rays[slot.index()].remaining);
        }
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
        if state.rays_left > 0 || state.samples > 0 || state.news > 0 || !state.is_active {
            return;
        }
        if half >= 2 {
            self.halves[half].is_active = false;
            return;
        }
        let background = (self.frame.spec.look.background
            * f64::from((1u32 << self.frame.spec.widths.intensity) - 1))
        .round() as u32;
        let first = half * self.half_size;
        for slot in first..first + state.rays {
            let light = &mut self.light[slot];
            if KNOWN {
                *light = self.known[slot].light;
            }
            if !light.has_ended {
                // A polygon behind the last sample.
                self.path.merge_fragment(light);
            }
            let pixel = self.rays[slot].pixel as usize;
            self.results.picture[pixel] = light.accumulator.map(|accumulator| {
                let unit = &self.path.compositor;
                unit.to_f32(unit.finish(accumulator, light.passing, background))
            });
            self.results.passing[pixel] = light.passing as f32 / self.path.absorber.full() as f32;
            self.results.ended_early[pixel] = light.has_ended;
            self.counters.rays_ended_early += u64::from(light.has_ended);
        }
        self.counters.tiles += 1;
        self.halves[half].is_active = false;
        // Results go first, then the half is free for parameters.
        let results = self.frame.spec.queue.bundle[0] * self.frame.spec.queue.bundle[1];
        self.transfer(u64::from(results) * u64::from(self.frame.result_bytes));
        if self.next_tile < self.frame.setup.tile_count() {
            self.order_parameters(half);
        }
    }

    /// P, Δ and L of all rays of a tile, in whole bytes each.
    fn order_parameters(&mut self, half: usize) {
        let mut bytes = crate::host::parameter_bytes(&self.frame.spec);
        if let Some(deformation) = &self.frame.deformation {
            bytes += 4 * u64::from(deformation.planes()) * self.half_size as u64;
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
    ) -> (Option<Read>, bool, Option<Return>, u32) {
        let nothing = (None, false, None, 0);
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
                    return (None, false, None, access.clocks());
                }
                next
            }
        };
        let Some(WaitingRay { slot, .. }) = next else {
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
        if self.half_of(slot) >= 2 {
            return self.issue_light(memory, now, slot);
        }
        let ray = self.rays[slot.index()];
        let Step {
            position,
            cell,
            distance,
            steps,
            is_adaptive,
        } = self.path.step(&ray);
        let frozen = self.access(memory, now, cell, ray.pixel);
        let mut is_sample = self.path.is_sample(distance);
        if !KNOWN && self.frame.fragments.is_some() {
            // An empty sample carries the news that a polygon is passed.
            let fragment = self.light[slot.index()].fragment;
            is_sample |= fragment.is_some_and(|f| ray.plane >= u32::from(f.plane));
        }
        if is_adaptive {
            self.counters.skipped_by_adaptive_sampling += u64::from(steps - 1);
        } else {
            self.counters.skipped_by_leaping += u64::from(steps - 1);
        }
        self.counters.reads += 1;
        if distance == 0 {
            self.counters.sample_reads += 1;
        } else {
            self.counters.distance_only_reads += 1;
        }
        let read = Read {
            slot,
            position,
            steps: self.gaps[slot.index()],
            plane: ray.plane as u16,
            pixel: ray.pixel,
        };
        self.gaps[slot.index()] = if distance == 0 { steps as u8 } else { 1 };
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
        (Some(read), is_sample, Some(Return::new(slot, key)), frozen)
    }

    /// The next sample of a light ray goes to the memory.
    fn issue_light(
        &mut self,
        memory: &mut Memory,
        now: u64,
        slot: Slot,
    ) -> (Option<Read>, bool, Option<Return>, u32) {
        let ray = self.rays[slot.index()];
        let cell = self.path.generator.cell(ray.position);
        let frozen = self.access(memory, now, cell, ray.pixel);
        self.counters.light_reads += 1;
        let columns = match &self.frame.light_distance {
            Some(distance) => u32::from(distance.steps(cell)),
            None => 0,
        };
        let is_sample = columns == 0;
        let next = self
            .shadow
            .as_ref()
            .and_then(|shadow| shadow.advance(&ray, columns.max(1)));
        if let Some(next) = next {
            self.rays[slot.index()] = next;
            self.returning += 1;
        }
        if is_sample {
            let half = self.half_of(slot);
            self.halves[half].samples += 1;
        }
        let read = Read {
            slot,
            position: ray.position,
            steps: 1,
            plane: ray.plane as u16,
            pixel: ray.pixel,
        };
        let key = next.map(|next| self.key(&next));
        (Some(read), is_sample, Some(Return::new(slot, key)), frozen)
    }

    /// The first of the next `window` rays whose rows are open; the rows of the first are opened meanwhile.
    fn ready_ray(
        &mut self,
        memory: &mut Memory,
        now: u64,
        window: u32,
    ) -> (Option<WaitingRay>, Access) {
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
                .path
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

    /// Reads a cell for the ray of a pixel, and counts what the memory says; how many clocks it holds the pipeline.
    #[inline(always)]
    fn access(&mut self, memory: &mut Memory, now: u64, cell: [i32; 3], pixel: u32) -> u32 {
        if memory.is_open(cell) {
            return 0;
        }
        let access = memory.access(now, cell);
        self.count_access(&access, pixel);
        access.clocks()
    }

    #[inline(never)]
    fn count_access(&mut self, access: &Access, pixel: u32) {
        let counters = &mut self.counters;
        counters.frozen_for_rows += u64::from(access.row_clocks);
        counters.frozen_for_refresh += u64::from(access.refresh_clocks);
        counters.frozen_for_words += u64::from(access.serial_clocks);
        counters.frozen_for_distances += u64::from(access.distance_clocks);
        counters.distance_row_changes += u64::from(access.distance_misses);
        counters.row_changes += u64::from(access.module_misses);
        counters.row_stalls += u64::from(access.module_misses > 0);
        counters.thesis_row_changes += u64::from(access.thesis_changes);
        self.results.stalls_of_pixel[pixel as usize] += u32::from(access.module_misses > 0);
        self.results.thesis_changes_of_pixel[pixel as usize] += access.thesis_changes;
    }

    // ----- data path -----

    #[inline(always)]
    fn absorb(&mut self, word: Classified) -> (Option<VisibleSample>, Option<Terminate>) {
        if let Some(shadow) = &mut self.shadow
            && word.slot.index() >= 2 * self.half_size
        {
            let plane = u32::from(word.plane);
            let is_dark = shadow.absorb(word.pixel, plane, word.opacity, &self.path.absorber);
            let news = self.terminate(word.slot, is_dark);
            self.end_sample(word.slot);
            return (None, news);
        }
        let light = &mut self.light[word.slot.index()];
        if light.has_ended {
            self.counters.wasted_samples += 1;
            self.end_sample(word.slot);
            return (None, None);
        }
        let mut visible = self.path.absorb(light, word);
        let ends = light.has_ended;
        let news = self.terminate(word.slot, ends);
        match (&mut visible, &self.shadow) {
            (None, _) => self.end_sample(word.slot),
            (Some(visible), Some(shadow)) => {
                visible.weight = shadow.lit(word.pixel, u32::from(word.plane), visible.weight);
            }
            _ => {}
        }
        (visible, news)
    }

    /// News for the queue, if a ray has ended.
    #[inline(always)]
    fn terminate(&mut self, slot: Slot, ends: bool) -> Option<Terminate> {
        if ends {
            let half = self.half_of(slot);
            self.halves[half].news += 1;
        }
        ends.then_some(Terminate(slot))
    }

    /// A sample is no longer on its way.
    #[inline(always)]
    fn end_sample(&mut self, slot: Slot) {
        let half = self.half_of(slot);
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
        counters.coding_clocks = self.frame.coding_clocks();
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
            clocks_of_part: Vec::new(),
            is_complete,
        }
    }
}

/// Rows in the other order.
fn top_down<T: Clone>(pixels: Vec<T>, width: u32) -> Vec<T> {
    pixels
        .rchunks_exact(width as usize)
        .flatten()
        .cloned()
        .collect()
}
