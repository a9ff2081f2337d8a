//! The volume memory under a freezing controller: rows that are open, what opening costs, and the two counters.

use crate::dram::Dram;
use crate::spec::{Memory as MemorySpec, MemoryModel, RowRule};
use crate::voxel_layout::VoxelLayout;

const CLOSED: u32 = u32::MAX;

/// What an access found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Access {
    /// Clocks that the pipeline is held for rows.
    pub row_clocks: u32,
    /// Clocks that it is held for a refresh.
    pub refresh_clocks: u32,
    /// Clocks that it is held because one module cannot deliver eight words at once, or because of bursts.
    pub serial_clocks: u32,
    /// Rows opened, over all modules.
    pub module_misses: u32,
    /// Whether the document's counter sees a change.
    pub thesis_changes: u32,
}

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
            rows,
        }
    }

    /// The layout of the voxels.
    pub fn layout(&self) -> &VoxelLayout {
        &self.layout
    }

    /// Reads the neighbours of a cell, beginning at clock `now`.
    #[inline]
    pub fn access(&mut self, now: u64, cell: [i32; 3]) -> Access {
        let mut access = match &mut self.rows {
            Rows::Sdr(sdr) => {
                if sdr.refresh_interval == 0
                    && sdr.longest_open == 0
                    && self.layout.is_one_row(cell)
                    && self.layout.modules == 8
                {
                    let place = self.layout.place(cell);
                    let bank = place.bank as usize;
                    if sdr.agreed[bank] == place.row {
                        let mut access = Access::default();
                        if self.open_block[bank] != place.row {
                            access.thesis_changes = 1;
                            if self.rule == RowRule::Thesis {
                                access.row_clocks = open_clocks(
                                    self.open_block[bank],
                                    self.precharge,
                                    self.activate,
                                );
                            }
                            self.open_block[bank] = place.row;
                        }
                        return access;
                    }
                }
                sdr.access(now, cell, &self.layout, self.precharge, self.activate)
            }
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
