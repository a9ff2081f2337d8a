//! DRAM command by command: banks, bank groups, bursts, refresh, activation windows, and a cache in front of each module.
//!
//! Rules as in the data sheets of DDR4, LPDDR4 and HBM2, in clocks of the pipeline: tRP, tRCD, tRAS, tRTP, tCCD_S/L, tRRD,
//! tFAW, tRFC, tREFI. Every module has its own command bus. With plain SDR timing it counts what [`memory`](crate::memory)
//! counts (a test compares them).

use crate::access::Access;
use crate::spec::{Cache, Memory as MemorySpec, Timing};
use crate::voxel_layout::{Place, VoxelLayout};

const CLOSED: u32 = u32::MAX;
const LONG_AGO: i64 = i64::MIN / 4;

/// A command on the bus of a module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Command {
    /// Clock.
    pub at: i64,
    /// Which module.
    pub module: usize,
    /// Which bank.
    pub bank: u32,
    /// What.
    pub kind: CommandKind,
}

/// Kinds of commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CommandKind {
    /// Closes the row of a bank.
    Precharge,
    /// Opens a row.
    Activate(u32),
    /// Reads a burst of a row.
    Read(u32),
    /// Refreshes all banks of the module, which are closed.
    Refresh,
}

#[derive(Clone, Copy, Debug)]
struct Bank {
    open: u32,
    activated: i64,
    /// Earliest next ACTIVE.
    may_activate: i64,
    read: i64,
}

#[derive(Clone, Debug)]
struct Module {
    banks: Vec<Bank>,
    /// Last READ, and its bank group.
    read: (i64, u32),
    /// Last four ACTIVEs of each chip, oldest first.
    activations: Vec<[i64; 4]>,
    lines: Option<Lines>,
}

/// Which bursts are cached: per set, most recent first.
#[derive(Clone, Debug)]
struct Lines {
    sets: Vec<Vec<u64>>,
    ways: usize,
}

impl Lines {
    fn new(cache: Cache) -> Lines {
        Lines {
            sets: vec![Vec::with_capacity(cache.ways as usize); cache.sets as usize],
            ways: cache.ways as usize,
        }
    }

    /// Whether the line is there; it is, afterwards.
    fn touch(&mut self, line: u64) -> bool {
        // Neighbouring lines of a row differ in their low bits, rows and banks in the high ones: fold them in.
        let hash = line ^ line >> 7 ^ line >> 15;
        let set = hash as usize & (self.sets.len() - 1);
        let set = &mut self.sets[set];
        let found = set.iter().position(|l| *l == line);
        if let Some(place) = found {
            set.remove(place);
        } else if set.len() == self.ways {
            set.pop();
        }
        set.insert(0, line);
        found.is_some()
    }

    fn holds(&self, line: u64) -> bool {
        let hash = line ^ line >> 7 ^ line >> 15;
        self.sets[hash as usize & (self.sets.len() - 1)].contains(&line)
    }
}

/// All modules of a memory.
#[derive(Clone, Debug)]
pub struct Dram {
    timing: Timing,
    cache: Option<Cache>,
    banks_per_chip: u32,
    modules: Vec<Module>,
    next_refresh: i64,
    log: Option<Vec<Command>>,
    /// Words found in caches.
    pub cache_hits: u64,
    /// Words not found there.
    pub cache_misses: u64,
    /// Bursts read.
    pub bursts: u64,
}

impl Dram {
    /// With every row closed.
    pub fn new(spec: &MemorySpec, layout: &VoxelLayout) -> Dram {
        let bank = Bank {
            open: CLOSED,
            activated: LONG_AGO,
            may_activate: LONG_AGO,
            read: LONG_AGO,
        };
        let chips = layout.banks / spec.banks as usize;
        let module = Module {
            banks: vec![bank; layout.banks],
            read: (LONG_AGO, 0),
            activations: vec![[LONG_AGO; 4]; chips],
            lines: spec.cache.map(Lines::new),
        };
        Dram {
            timing: spec.timing,
            cache: spec.cache,
            banks_per_chip: spec.banks,
            modules: vec![module; layout.modules],
            next_refresh: i64::from(spec.timing.refresh_interval),
            log: None,
            cache_hits: 0,
            cache_misses: 0,
            bursts: 0,
        }
    }

    /// Keeps every command from now on.
    pub fn record(&mut self) {
        self.log = Some(Vec::new());
    }

    /// The commands that were kept.
    pub fn commands(&self) -> &[Command] {
        self.log.as_deref().unwrap_or_default()
    }

    /// Reads the neighbours of a cell; the pipeline is held until the last READ.
    pub fn access(&mut self, now: u64, cell: [i32; 3], layout: &VoxelLayout) -> Access {
        let now = now as i64;
        let mut access = Access::default();
        let begin = self.refresh(now);
        access.refresh_clocks = (begin - now) as u32;
        let mut end = begin;
        // What reading alone costs, with every row open.
        let mut end_of_reads = begin;
        let mut next = begin;
        for at in neighbours(cell) {
            if !layout.is_valid(at) {
                continue;
            }
            let place = layout.place(at);
            let module = layout.module(at);
            let from = if layout.modules == 8 { begin } else { next };
            let (last, misses, waited) = self.read(module, place, from);
            access.module_misses += misses;
            end = end.max(last);
            end_of_reads = end_of_reads.max(last - waited);
            next = last + 1;
        }
        let total = (end - begin) as u32;
        access.row_clocks = if access.module_misses == 0 {
            0
        } else {
            (end - end_of_reads.min(end)) as u32
        };
        access.serial_clocks = total - access.row_clocks;
        access
    }

    /// Whether a read of the cell at `now` would not wait.
    pub fn is_ready(&self, now: u64, cell: [i32; 3], layout: &VoxelLayout) -> bool {
        let now = now as i64;
        neighbours(cell)
            .filter(|at| layout.is_valid(*at))
            .all(|at| {
                let place = layout.place(at);
                let module = &self.modules[layout.module(at)];
                if let (Some(lines), Some(cache)) = (&module.lines, self.cache)
                    && lines.holds(line(place, cache.line))
                {
                    return true;
                }
                let bank = &module.banks[place.bank as usize];
                bank.open == place.row
                    && now >= bank.activated + i64::from(self.timing.activate)
                    && now >= module.read.0 + i64::from(self.read_gap(module.read.1, place.bank))
            })
    }

    /// Opens the rows of a cell in the background, beginning at `now`; how many had to be.
    pub fn prepare(&mut self, now: u64, cell: [i32; 3], layout: &VoxelLayout) -> u32 {
        let mut opened = 0;
        for at in neighbours(cell) {
            if layout.is_valid(at) {
                let place = layout.place(at);
                let module = layout.module(at);
                if self.modules[module].banks[place.bank as usize].open != place.row {
                    self.open(module, place, now as i64);
                    opened += 1;
                }
            }
        }
        opened
    }

    /// Refreshes whatever is due; the first clock after it.
    pub fn refresh(&mut self, now: i64) -> i64 {
        let interval = i64::from(self.timing.refresh_interval);
        if interval == 0 || now < self.next_refresh {
            return now;
        }
        self.next_refresh += interval * (1 + (now - self.next_refresh) / interval);
        let precharge = i64::from(self.timing.precharge);
        // All banks close as soon as the last one may.
        let mut close = now;
        for module in &self.modules {
            for bank in module.banks.iter().filter(|bank| bank.open != CLOSED) {
                close = close.max(bank.activated + i64::from(self.timing.row_active));
                close = close.max(bank.read + i64::from(self.timing.read_to_precharge));
            }
        }
        let end = close + precharge + i64::from(self.timing.refresh);
        for (m, module) in self.modules.iter_mut().enumerate() {
            for (b, bank) in module.banks.iter_mut().enumerate() {
                if bank.open != CLOSED
                    && let Some(log) = &mut self.log
                {
                    log.push(Command {
                        at: close,
                        module: m,
                        bank: b as u32,
                        kind: CommandKind::Precharge,
                    });
                }
                bank.open = CLOSED;
                bank.may_activate = end;
            }
            if let Some(log) = &mut self.log {
                log.push(Command {
                    at: close + precharge,
                    module: m,
                    bank: 0,
                    kind: CommandKind::Refresh,
                });
            }
        }
        end
    }

    /// Reads a word of a module, from the cache or with its burst: clock of the last READ, rows opened, and clocks waited
    /// for a row.
    fn read(&mut self, module: usize, place: Place, from: i64) -> (i64, u32, i64) {
        let mut bursts = 1;
        if let (Some(cache), Some(lines)) = (self.cache, &mut self.modules[module].lines) {
            if lines.touch(line(place, cache.line)) {
                self.cache_hits += 1;
                return (from, 0, 0);
            }
            self.cache_misses += 1;
            bursts = cache.line / self.timing.burst;
        }
        let bank = self.modules[module].banks[place.bank as usize];
        let is_too_old = self.timing.longest_open > 0
            && from - bank.activated > i64::from(self.timing.longest_open);
        let is_miss = bank.open != place.row || is_too_old;
        let gap = self.read_gap(self.modules[module].read.1, place.bank);
        let with_open_row = from.max(self.modules[module].read.0 + i64::from(gap));
        let mut at = with_open_row;
        if is_miss {
            self.open(module, place, from);
        }
        let activated = self.modules[module].banks[place.bank as usize].activated;
        at = at.max(activated + i64::from(self.timing.activate));
        let waited = at - with_open_row;
        for burst in 0..bursts {
            if burst > 0 {
                at += i64::from(self.timing.read_same_group.max(self.timing.read));
            }
            self.note(at, module, place.bank, CommandKind::Read(place.row));
            self.bursts += 1;
        }
        let group = self.group(place.bank);
        self.modules[module].banks[place.bank as usize].read = at;
        self.modules[module].read = (at, group);
        (at, u32::from(is_miss), waited)
    }

    /// PRECHARGE if needed, and ACTIVE, as early as the rules allow.
    fn open(&mut self, module: usize, place: Place, from: i64) {
        let t = self.timing;
        let chip = (place.bank / self.banks_per_chip) as usize;
        let bank = self.modules[module].banks[place.bank as usize];
        let mut activate = from.max(bank.may_activate);
        if bank.open != CLOSED {
            let precharge = from
                .max(bank.activated + i64::from(t.row_active))
                .max(bank.activated + i64::from(t.activate))
                .max(bank.read + i64::from(t.read_to_precharge));
            self.note(precharge, module, place.bank, CommandKind::Precharge);
            activate = activate.max(precharge + i64::from(t.precharge));
        }
        let before = &mut self.modules[module].activations[chip];
        activate = activate
            .max(before[3] + i64::from(t.activate_to_activate))
            .max(before[0] + i64::from(t.four_activates));
        before.rotate_left(1);
        before[3] = activate;
        self.note(
            activate,
            module,
            place.bank,
            CommandKind::Activate(place.row),
        );
        let bank = &mut self.modules[module].banks[place.bank as usize];
        bank.open = place.row;
        bank.activated = activate;
    }

    fn group(&self, bank: u32) -> u32 {
        bank % self.timing.bank_groups + bank / self.banks_per_chip * self.timing.bank_groups
    }

    fn read_gap(&self, group: u32, bank: u32) -> u32 {
        if group == self.group(bank) {
            self.timing.read_same_group.max(self.timing.read)
        } else {
            self.timing.read
        }
    }

    fn note(&mut self, at: i64, module: usize, bank: u32, kind: CommandKind) {
        if let Some(log) = &mut self.log {
            log.push(Command {
                at,
                module,
                bank,
                kind,
            });
        }
    }
}

fn line(place: Place, words: u32) -> u64 {
    u64::from(place.bank) << 48 | u64::from(place.row) << 20 | u64::from(place.column / words)
}

fn neighbours(cell: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
    (0..8).map(move |c| {
        [
            cell[0] + (c & 1),
            cell[1] + (c >> 1 & 1),
            cell[2] + (c >> 2),
        ]
    })
}
