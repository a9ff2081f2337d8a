//! The volume memory under a freezing controller: rows that are open, what opening costs, and the two counters.

use crate::access::Access;
use crate::dram::Dram;
use crate::spec::{Memory as MemorySpec, MemoryModel, RowRule};
use crate::voxel_layout::VoxelLayout;

const CLOSED: u32 = u32::MAX;

/// The memory of one processor.
#[derive(Clone, Debug)]
pub struct Memory {
    layout: VoxelLayout,
    precharge: u32,
    activate: u32,
    rule: RowRule,
    /// Open row of each bank, all modules being alike, by the document's counter.
    open_block: Vec<u32>,
    rows: Rows,
    distances: Option<DistanceRows>,
    /// Whether a read whose rows are open cannot wait for anything.
    is_quick: bool,
}

/// The module of the distance store.
#[derive(Clone, Debug)]
struct DistanceRows {
    layout: VoxelLayout,
    /// Bits of a cell's coordinates that share a word.
    shift: u32,
    /// Open row of each bank.
    open: Vec<u32>,
}

#[derive(Clone, Debug)]
enum Rows {
    Sdr(Sdr),
    Dram(Box<Dram>),
}

/// Plain SDR SDRAM: a read each clock, banks independent but for their rows.
#[derive(Clone, Debug)]
struct Sdr {
    /// Open row of [bank][module].
    open: Vec<[u32; 8]>,
    /// The row that all modules of a bank have open, if they agree.
    agreed: Vec<u32>,
    /// When a row was opened, [bank][module].
    since: Vec<[u64; 8]>,
    longest_open: u64,
    refresh_interval: u64,
    refresh: u32,
    next_refresh: u64,
}

impl Memory {
    /// With every row closed. `in_background`: rows are opened while others are read.
    pub fn new(spec: &MemorySpec, layout: VoxelLayout, in_background: bool) -> Memory {
        let t = &spec.timing;
        let is_plain = !in_background
            && t.read == 1
            && t.read_same_group <= 1
            && t.burst == 1
            && t.row_active == 0
            && t.read_to_precharge == 0
            && t.activate_to_activate == 0
            && t.four_activates == 0
            && spec.cache.is_none();
        let rows = if is_plain {
            Rows::Sdr(Sdr {
                open: vec![[CLOSED; 8]; layout.banks],
                agreed: vec![CLOSED; layout.banks],
                since: vec![[0; 8]; layout.banks],
                longest_open: u64::from(t.longest_open),
                refresh_interval: u64::from(t.refresh_interval),
                refresh: t.refresh,
                next_refresh: u64::from(t.refresh_interval),
            })
        } else {
            Rows::Dram(Box::new(Dram::new(spec, &layout)))
        };
        Memory {
            open_block: vec![CLOSED; layout.banks],
            layout,
            precharge: t.precharge,
            activate: t.activate,
            rule: match spec.model {
                MemoryModel::M8 => spec.row_rule,
                // The document's figures for one module count every read.
                _ => RowRule::Exact,
            },
            is_quick: is_plain
                && t.refresh_interval == 0
                && t.longest_open == 0
                && spec.model == MemoryModel::M8,
            rows,
            distances: None,
        }
    }

    /// With a distance store whose rows are to be opened too: its layout, and the bits of a cell's coordinates that share a
    /// word.
    pub fn with_distances(mut self, store: Option<(VoxelLayout, u32)>) -> Memory {
        self.is_quick &= store.is_none();
        self.distances = store.map(|(layout, shift)| DistanceRows {
            open: vec![CLOSED; layout.banks],
            layout,
            shift,
        });
        self
    }

    /// The layout of the voxels.
    pub fn layout(&self) -> &VoxelLayout {
        &self.layout
    }

    /// Whether all rows that a read of this cell needs are open by both counters and it cannot wait for anything, which is so
    /// of nearly every read: then it changes nothing and need not be made.
    #[inline(always)]
    pub fn is_open(&self, cell: [i32; 3]) -> bool {
        if let Rows::Sdr(sdr) = &self.rows
            && self.is_quick
            && self.layout.is_one_row(cell)
        {
            let place = self.layout.place(cell);
            let bank = place.bank as usize;
            return sdr.agreed[bank] == place.row && self.open_block[bank] == place.row;
        }
        false
    }

    /// Reads the neighbours of a cell and its distance, beginning at clock `now`.
    #[inline(never)]
    pub fn access(&mut self, now: u64, cell: [i32; 3]) -> Access {
        let mut access = self.access_voxels(now, cell);
        if let Some(distances) = &mut self.distances {
            if access.refresh_clocks > 0 {
                distances.open.fill(CLOSED);
            }
            let word = cell.map(|c| c >> distances.shift);
            if distances.layout.is_valid(word) {
                let place = distances.layout.place(word);
                let open = &mut distances.open[place.bank as usize];
                if *open != place.row {
                    let clocks = open_clocks(*open, self.precharge, self.activate);
                    access.distance_misses = 1;
                    access.distance_clocks =
                        clocks.saturating_sub(access.row_clocks + access.serial_clocks);
                    *open = place.row;
                }
            }
        }
        access
    }

    /// Reads the neighbours of a cell.
    fn access_voxels(&mut self, now: u64, cell: [i32; 3]) -> Access {
        let mut access = match &mut self.rows {
            Rows::Sdr(sdr) => sdr.access(now, cell, &self.layout, self.precharge, self.activate),
            Rows::Dram(dram) => dram.access(now, cell, &self.layout),
        };
        if self.layout.modules == 8 {
            let valid = cell.map(|c| c.max(0));
            if self.layout.is_valid(valid) {
                let place = self.layout.place(valid);
                let open = &mut self.open_block[place.bank as usize];
                let is_change = *open != place.row;
                access.thesis_changes = u32::from(is_change);
                if self.rule == RowRule::Thesis {
                    access.row_clocks = match is_change {
                        true => open_clocks(*open, self.precharge, self.activate),
                        false => 0,
                    };
                }
                *open = place.row;
            }
        } else {
            access.thesis_changes = access.module_misses;
        }
        access
    }

    /// Whether a read of this cell would not wait at clock `now`; always, unless the memory works in the background.
    pub fn dram(&mut self) -> Option<(&mut Dram, &VoxelLayout)> {
        match &mut self.rows {
            Rows::Dram(dram) => Some((dram, &self.layout)),
            Rows::Sdr(_) => None,
        }
    }
}

/// Clocks that a row costs beyond those of the read itself: precharge and activate, or activate alone.
fn open_clocks(open: u32, precharge: u32, activate: u32) -> u32 {
    if open == CLOSED {
        activate
    } else {
        precharge + activate
    }
}

impl Sdr {
    fn access(
        &mut self,
        now: u64,
        cell: [i32; 3],
        layout: &VoxelLayout,
        precharge: u32,
        activate: u32,
    ) -> Access {
        let mut access = Access::default();
        if self.refresh_interval > 0 && now >= self.next_refresh {
            // All banks are precharged and refreshed together; every row is closed behind it.
            access.refresh_clocks = precharge + self.refresh;
            self.next_refresh +=
                self.refresh_interval * (1 + (now - self.next_refresh) / self.refresh_interval);
            self.open.fill([CLOSED; 8]);
            self.agreed.fill(CLOSED);
        }
        let mut begin = now + u64::from(access.refresh_clocks);
        let mut touched = [usize::MAX; 8];
        let mut reads = 0;
        for (corner, touched) in touched.iter_mut().enumerate() {
            let at = [
                cell[0] + (corner & 1) as i32,
                cell[1] + (corner >> 1 & 1) as i32,
                cell[2] + (corner >> 2) as i32,
            ];
            if !layout.is_valid(at) {
                continue;
            }
            let place = layout.place(at);
            let (bank, module) = (place.bank as usize, layout.module(at));
            let open = &mut self.open[bank][module];
            let since = &mut self.since[bank][module];
            let is_too_old =
                self.longest_open > 0 && *open == place.row && begin - *since > self.longest_open;
            let mut clocks = 0;
            if *open != place.row || is_too_old {
                clocks = open_clocks(*open, precharge, activate);
                access.module_misses += 1;
                *open = place.row;
                *since = begin;
                *touched = bank;
            }
            if layout.modules == 8 {
                // Modules work at the same time.
                access.row_clocks = access.row_clocks.max(clocks);
            } else {
                access.row_clocks += clocks;
                begin += u64::from(clocks) + 1;
            }
            reads += 1;
        }
        if layout.modules == 8 {
            for bank in touched {
                if bank != usize::MAX {
                    let rows = &self.open[bank];
                    let is_agreed = rows.iter().all(|row| *row == rows[0]);
                    self.agreed[bank] = if is_agreed { rows[0] } else { CLOSED };
                }
            }
        } else {
            access.serial_clocks = (reads as u32).saturating_sub(1);
        }
        access
    }
}
