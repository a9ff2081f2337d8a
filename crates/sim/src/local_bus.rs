//! The processor as its host sees it: registers and memories on the local bus, and what an access costs (document §7.6).
//!
//! | address (words) | what | |
//! |---|---|---|
//! | 0x0 | CONTROL: 1 starts the tile in the parameter RAM | write |
//! | 0x1 | STATUS: 1 while a tile is drawn | read |
//! | 0x2 | THRESHOLD: a ray ends when T is below | read, write |
//! | 0x3 | BACKGROUND, `widths.intensity` bits | read, write |
//! | 0x4 … 0x6 | voxels along x, y, z | read, write |
//! | 0x7 | clocks of the last tile | read |
//! | 0x100 … | rays of the last tile that ended early, 32 a word | read |
//! | 0x1_0000 … | parameter RAM, 8 words per ray: P x, y, z; Δ x, y, z; L; plane | write |
//! | 0x2_0000 … | results, one word per ray | read |
//! | 0x10_0000 … | pre-classification table, 64 K words | write |
//! | 0x20_0000 … | reflectance map, four supports of 8 bits a word | write |
//! | 0x100_0000 … | voxels, x fastest | write |
//! | 0x200_0000 … | distances, cells x fastest: steps to go, 0 for none | write |
//!
//! Parameters and results have two halves each: while a tile is drawn, the next one's parameters can be written. Starting a
//! tile or reading results while one is drawn waits for it, by wait states. All memories begin with zeros, the threshold with
//! that of the Spec.

use crate::distance::DistanceStore;
use crate::frame::Frame;
use crate::memory::Memory;
use crate::processor::{no_progress, run_on};
use crate::rays::{Ray, RaySetup};
use crate::spec::{Classification, DistanceMemory, Handover, Scheduling, Shading, Spec};
use crate::stages::classify::Tables;
use crate::stages::fetch::Voxels;
use crate::stages::shade::ReflectanceMap;
use crate::voxel_layout::VoxelLayout;
use crate::{Counters, Error, NoObserver};

/// Writing 1 starts a tile.
pub const CONTROL: u32 = 0x0;
/// 1 while a tile is drawn.
pub const STATUS: u32 = 0x1;
/// A ray ends when T is below this.
pub const THRESHOLD: u32 = 0x2;
/// What is behind everything.
pub const BACKGROUND: u32 = 0x3;
/// Voxels along x; y and z follow.
pub const DIMS: u32 = 0x4;
/// Clocks of the last tile.
pub const CLOCKS: u32 = 0x7;
/// Rays that ended early, 32 a word.
pub const ENDED: u32 = 0x100;
/// Parameter RAM.
pub const PARAMETERS: u32 = 0x1_0000;
/// Results.
pub const RESULTS: u32 = 0x2_0000;
/// Pre-classification table.
pub const PRE_TABLE: u32 = 0x10_0000;
/// Reflectance map.
pub const REFLECTANCE: u32 = 0x20_0000;
/// Voxels.
pub const VOLUME: u32 = 0x100_0000;
/// Distances.
pub const DISTANCES: u32 = 0x200_0000;

/// Voxels that a volume on the bus may have.
const MOST_VOXELS: u64 = 1 << 24;
/// Words of a ray in the parameter RAM.
const RAY_WORDS: u32 = 8;

/// A processor behind its local bus.
pub struct LocalBus {
    spec: Spec,
    /// Nanoseconds since the beginning.
    time_ns: f64,
    clock_ns: f64,
    dims: [u32; 3],
    threshold: u32,
    background: u32,
    pre_table: Vec<u16>,
    reflectance: Vec<u32>,
    volume: Vec<u16>,
    distances: Vec<u8>,
    parameters: Vec<u32>,
    /// When the tile under way is done.
    busy_until_ns: f64,
    results: Vec<u32>,
    ended: Vec<u32>,
    memory: Option<(VoxelLayout, Memory)>,
    /// Counts of all tiles so far.
    pub counters: Counters,
    clocks: u32,
    /// Bus clocks so far.
    pub bus_clocks: u64,
}

impl LocalBus {
    /// After power-up.
    ///
    /// # Errors
    /// If the Spec contradicts itself, or asks for something that is not behind this bus.
    pub fn new(spec: &Spec) -> Result<LocalBus, Error> {
        spec.check()?;
        let is_plain = spec.look.classification == Classification::Pre
            && spec.look.shading == Shading::ReflectanceMap
            && spec.widths.intensity == 8
            && spec.optimisation.distance_block == 1
            && spec.optimisation.adaptive_error == 0
            && spec.memory.distance_store == DistanceMemory::Ideal
            && spec.queue.pipelines == 1
            && spec.extensions_are_off();
        if !is_plain {
            let problem = "behind the bus there is pre-classification, a reflectance map of 8 bits, a distance per cell, one pipeline, \
                           and no extension";
            return Err(Error::field("look, optimisation, queue", "else", problem));
        }
        let rays = spec.queue.bundle[0] * spec.queue.bundle[1];
        let one = f64::from(1u32 << spec.widths.transmittance);
        Ok(LocalBus {
            spec: spec.clone(),
            time_ns: 0.0,
            clock_ns: 1000.0 / 33.0,
            dims: [0; 3],
            threshold: (spec.optimisation.termination_threshold * one).round() as u32,
            background: 0,
            pre_table: vec![0; 1 << 16],
            reflectance: vec![0; 6 << (2 * spec.widths.reflectance_index)],
            volume: Vec::new(),
            distances: Vec::new(),
            parameters: vec![0; (rays * RAY_WORDS) as usize],
            busy_until_ns: 0.0,
            results: vec![0; rays as usize],
            ended: vec![0; rays.div_ceil(32) as usize],
            memory: None,
            counters: Counters::default(),
            clocks: 0,
            bus_clocks: 0,
        })
    }

    /// Nanoseconds since the beginning.
    pub fn time_ns(&self) -> f64 {
        self.time_ns
    }

    /// Sets the period of the bus clock.
    pub fn set_clock_ns(&mut self, clock_ns: f64) {
        self.clock_ns = clock_ns;
    }

    /// Lets bus clocks pass.
    pub fn wait(&mut self, clocks: u64) {
        self.bus_clocks += clocks;
        self.time_ns += clocks as f64 * self.clock_ns;
    }

    /// Waits until no tile is drawn, in whole bus clocks.
    fn wait_until_idle(&mut self) {
        let rest = (self.busy_until_ns - self.time_ns).max(0.0);
        self.wait((rest / self.clock_ns).ceil() as u64);
    }

    /// Writes words one after the other; one word is a single access, more are a burst.
    ///
    /// # Errors
    /// An address that cannot be written, a word too wide, or a tile that cannot be drawn: what is wrong, in words.
    pub fn write(&mut self, address: u32, words: &[u32]) -> Result<(), String> {
        self.wait(u64::from(self.spec.host.single_clocks) + words.len() as u64 - 1);
        for (i, word) in words.iter().enumerate() {
            let at = u32::try_from(i)
                .ok()
                .and_then(|i| address.checked_add(i))
                .ok_or("the burst runs out of the addresses")?;
            self.write_word(at, *word)?;
        }
        Ok(())
    }

    fn write_word(&mut self, address: u32, word: u32) -> Result<(), String> {
        let widths = self.spec.widths;
        let fits = |bits: u32| match word >> bits {
            0 => Ok(word),
            _ => Err(format!("{word:#x} has more than {bits} bits")),
        };
        match address {
            CONTROL if word == 1 => return self.start(),
            CONTROL => return Err(format!("{word:#x} is no command; 1 starts a tile")),
            THRESHOLD => self.threshold = fits(widths.transmittance)?,
            BACKGROUND => self.background = fits(widths.intensity)?,
            DIMS..CLOCKS => self.dims[(address - DIMS) as usize] = fits(16)?,
            PRE_TABLE..REFLECTANCE if address - PRE_TABLE < 1 << 16 => {
                self.pre_table[(address - PRE_TABLE) as usize] = fits(widths.data)? as u16;
            }
            REFLECTANCE..VOLUME if ((address - REFLECTANCE) as usize) < self.reflectance.len() => {
                self.reflectance[(address - REFLECTANCE) as usize] = word;
            }
            PARAMETERS..RESULTS if ((address - PARAMETERS) as usize) < self.parameters.len() => {
                self.parameters[(address - PARAMETERS) as usize] = word;
            }
            VOLUME..DISTANCES => put(&mut self.volume, address - VOLUME, fits(16)? as u16),
            DISTANCES.. if u64::from(address - DISTANCES) < MOST_VOXELS => {
                put(
                    &mut self.distances,
                    address - DISTANCES,
                    fits(widths.distance)? as u8,
                );
            }
            _ => return Err(format!("nothing can be written at {address:#x}")),
        }
        Ok(())
    }

    /// Reads words one after the other.
    ///
    /// # Errors
    /// An address that cannot be read.
    pub fn read(&mut self, address: u32, count: u32) -> Result<Vec<u32>, String> {
        let words = 0..count;
        self.wait(u64::from(self.spec.host.single_clocks) + u64::from(count) - 1);
        words
            .map(|i| {
                let at = address.checked_add(i);
                self.read_word(at.ok_or("the burst runs out of the addresses")?)
            })
            .collect()
    }

    fn read_word(&mut self, address: u32) -> Result<u32, String> {
        if address == CLOCKS || address >= ENDED {
            self.wait_until_idle();
        }
        let word = match address {
            STATUS => Some(u32::from(self.time_ns < self.busy_until_ns)),
            THRESHOLD => Some(self.threshold),
            BACKGROUND => Some(self.background),
            DIMS..CLOCKS => Some(self.dims[(address - DIMS) as usize]),
            CLOCKS => Some(self.clocks),
            ENDED..PARAMETERS => self.ended.get((address - ENDED) as usize).copied(),
            RESULTS..PRE_TABLE => self.results.get((address - RESULTS) as usize).copied(),
            _ => None,
        };
        word.ok_or_else(|| format!("nothing can be read at {address:#x}"))
    }

    /// Draws the tile in the parameter RAM.
    fn start(&mut self) -> Result<(), String> {
        self.wait_until_idle();
        let frame = self.frame()?;
        let layout = frame.layout.clone();
        let is_same_volume = |(old, _): &(VoxelLayout, Memory)| old.dims == layout.dims;
        if !self.memory.as_ref().is_some_and(is_same_volume) {
            let in_background = self.spec.queue.scheduling != Scheduling::Freeze;
            let memory = Memory::new(&frame.spec.memory, layout.clone(), in_background);
            self.memory = Some((layout, memory));
        }
        let begin = (self.time_ns / 1000.0 * self.spec.clock_mhz).ceil() as u64;
        let Some((_, memory)) = &mut self.memory else {
            return Ok(());
        };
        let drawn = run_on(&frame, memory, begin, &mut NoObserver, &no_progress);
        let drawn = drawn.map_err(|error| error.to_string())?;
        self.clocks = drawn.counters.clocks as u32;
        self.counters.add(&drawn.counters);
        self.busy_until_ns = (begin + drawn.counters.clocks) as f64 * 1000.0 / self.spec.clock_mhz;
        let [width, height] = self.spec.queue.bundle.map(|n| n as usize);
        let top = f64::from((1u32 << self.spec.widths.intensity) - 1);
        self.ended.fill(0);
        for ray in 0..width * height {
            // Pictures have their first row at the top, results at the bottom.
            let pixel = (height - 1 - ray / width) * width + ray % width;
            self.results[ray] = (f64::from(drawn.picture[pixel]) * top).round() as u32;
            self.ended[ray / 32] |= u32::from(drawn.ended_early[pixel]) << (ray % 32);
        }
        self.parameters.fill(0);
        Ok(())
    }

    /// A frame of one tile, of what was written.
    fn frame(&self) -> Result<Frame, String> {
        let dims = self.dims.map(|n| n as usize);
        let voxels = self.dims.iter().map(|n| u64::from(*n)).product::<u64>();
        if self.dims.iter().any(|n| *n < 2) || voxels > MOST_VOXELS {
            return Err(format!(
                "the registers of the volume are set to {:?} voxels; each must be at least 2, together at most {MOST_VOXELS}",
                self.dims
            ));
        }
        let mut spec = self.spec.clone();
        let widths = spec.widths;
        spec.optimisation.termination_threshold =
            f64::from(self.threshold) / f64::from(1u32 << widths.transmittance);
        spec.look.background =
            f64::from(self.background) / f64::from((1u32 << widths.intensity) - 1);
        // One tile is all there is: it ends when it is done.
        spec.queue.handover = match spec.queue.handover {
            Handover::Serial => Handover::Serial,
            _ => Handover::WhenDone,
        };
        let bits = |integer: u32, fraction: u32| 1 + integer + fraction;
        let position_bits = bits(widths.position_integer, widths.position_fraction);
        let step_bits = bits(widths.step_integer, widths.step_fraction);
        let shift = widths.position_fraction - widths.step_fraction;
        let mut rays = Vec::new();
        for (i, words) in self.parameters.chunks_exact(RAY_WORDS as usize).enumerate() {
            let signed = |word: u32, bits: u32| {
                let value = word as i32;
                let bound = 1i32 << (bits - 1);
                match (-bound..bound).contains(&value) {
                    true => Ok(value),
                    false => Err(format!("ray {i}: {value} has more than {bits} bits")),
                }
            };
            let unsigned = |word: u32, bits: u32| match word >> bits {
                0 => Ok(word),
                _ => Err(format!("ray {i}: {word} has more than {bits} bits")),
            };
            let mut ray = Ray {
                remaining: unsigned(words[6], widths.length)?,
                plane: unsigned(words[7], widths.key)?,
                pixel: i as u32,
                ..Ray::default()
            };
            for axis in 0..3 {
                ray.position[axis] = signed(words[axis], position_bits)?;
                ray.step[axis] = signed(words[3 + axis], step_bits)? << shift;
            }
            // A ray of length 0 is not sent.
            rays.push((ray.remaining > 0).then_some(ray));
        }
        let setup = RaySetup::of_rays(&spec, dims, rays);
        let filled = |words: &[u16]| {
            let mut words = words.to_vec();
            words.resize(voxels as usize, 0);
            words
        };
        let tables = Tables::of_pre(self.pre_table.clone(), widths.data);
        let words = filled(&self.volume);
        let words = words.iter().map(|word| tables.bus_word(*word)).collect();
        let layout = VoxelLayout::new(&spec.memory, dims).map_err(|error| error.to_string())?;
        let map = ReflectanceMap::of_words(&widths, &self.reflectance);
        Ok(Frame::of_parts(
            spec,
            setup,
            Voxels::new(dims, words),
            tables,
            map,
            DistanceStore::of_words(dims, &self.distances),
            layout,
        ))
    }
}

/// Puts a word into a memory that grows with what is written.
fn put<T: Copy + Default>(memory: &mut Vec<T>, at: u32, word: T) {
    let at = at as usize;
    if at >= memory.len() {
        memory.resize(at + 1, T::default());
    }
    memory[at] = word;
}

/// What `spec` puts on the bus for a frame: every write before the parameters of a tile.
pub(crate) fn frame_writes(
    frame: &Frame,
    volume: &[u16],
    pre_table: &[u16],
) -> Vec<(u32, Vec<u32>)> {
    let wide = |words: &[u16]| words.iter().map(|word| u32::from(*word)).collect();
    let widths = &frame.spec.widths;
    let top = f64::from((1u32 << widths.intensity) - 1);
    let mut writes = vec![
        (DIMS, frame.voxels.dims().map(|n| n as u32).to_vec()),
        (
            BACKGROUND,
            vec![(frame.spec.look.background * top).round() as u32],
        ),
        (VOLUME, wide(volume)),
        (PRE_TABLE, wide(pre_table)),
    ];
    if let Some(map) = &frame.map {
        writes.push((REFLECTANCE, map.to_words()));
    }
    if let Some(distance) = &frame.distance {
        let words = distance.cells(frame.voxels.dims());
        writes.push((DISTANCES, words.iter().map(|d| u32::from(*d)).collect()));
    }
    writes
}

/// The parameter words of the rays of a tile, by their place in the bundle.
pub(crate) fn parameter_words(frame: &Frame, tile: usize) -> Vec<u32> {
    let widths = &frame.spec.widths;
    let [columns, rows] = frame.spec.queue.bundle;
    let shift = widths.position_fraction - widths.step_fraction;
    let mut words = vec![0u32; (columns * rows * RAY_WORDS) as usize];
    for ray in frame.setup.tile(tile) {
        let (x, y) = (
            ray.pixel % frame.setup.size[0],
            ray.pixel / frame.setup.size[0],
        );
        let at = ((y % rows * columns + x % columns) * RAY_WORDS) as usize;
        for axis in 0..3 {
            words[at + axis] = ray.position[axis] as u32;
            words[at + 3 + axis] = (ray.step[axis] >> shift) as u32;
        }
        words[at + 6] = ray.remaining;
        words[at + 7] = ray.plane;
    }
    words
}
