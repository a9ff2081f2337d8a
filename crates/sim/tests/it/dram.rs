//! The memory controller against a scoreboard that knows nothing but the rules of the data sheet.

use proptest::prelude::*;
use std::collections::HashMap;
use strahl_sim::dram::{Command, CommandKind, Dram};
use strahl_sim::memory::Memory;
use strahl_sim::spec::{Cache, Memory as MemorySpec, MemoryModel, Timing};
use strahl_sim::voxel_layout::VoxelLayout;

/// What one module may do, command after command in the order of time.
fn check(commands: &[Command], t: &Timing, banks_per_chip: u32) {
    #[derive(Clone, Copy)]
    struct Bank {
        open: Option<u32>,
        activated: i64,
        precharged: i64,
        read: i64,
    }
    const LONG_AGO: i64 = -1_000_000;
    let fresh = Bank {
        open: None,
        activated: LONG_AGO,
        precharged: LONG_AGO,
        read: LONG_AGO,
    };
    let mut banks: HashMap<u32, Bank> = HashMap::new();
    let mut activations: HashMap<u32, Vec<i64>> = HashMap::new();
    let mut last_read: Option<(i64, u32)> = None;
    let mut refreshed = LONG_AGO;
    let group = |bank: u32| (bank / banks_per_chip, bank % t.bank_groups);
    for command in commands {
        let at = command.at;
        let bank = banks.entry(command.bank).or_insert(fresh);
        match command.kind {
            CommandKind::Precharge => {
                assert!(
                    bank.open.is_some(),
                    "precharge of a closed bank: {command:?}"
                );
                assert!(
                    at >= bank.activated + i64::from(t.row_active),
                    "tRAS: {command:?}"
                );
                assert!(
                    at >= bank.read + i64::from(t.read_to_precharge),
                    "tRTP: {command:?}"
                );
                bank.open = None;
                bank.precharged = at;
            }
            CommandKind::Activate(row) => {
                assert!(bank.open.is_none(), "activate of an open bank: {command:?}");
                assert!(
                    at >= bank.precharged + i64::from(t.precharge),
                    "tRP: {command:?}"
                );
                assert!(at >= refreshed + i64::from(t.refresh), "tRFC: {command:?}");
                let before = activations
                    .entry(command.bank / banks_per_chip)
                    .or_default();
                if let Some(last) = before.last() {
                    assert!(
                        at >= last + i64::from(t.activate_to_activate),
                        "tRRD: {command:?}"
                    );
                }
                if before.len() >= 4 {
                    assert!(
                        at >= before[before.len() - 4] + i64::from(t.four_activates),
                        "tFAW: {command:?}"
                    );
                }
                before.push(at);
                bank.open = Some(row);
                bank.activated = at;
            }
            CommandKind::Read(row) => {
                assert_eq!(bank.open, Some(row), "read of another row: {command:?}");
                assert!(
                    at >= bank.activated + i64::from(t.activate),
                    "tRCD: {command:?}"
                );
                if let Some((last, other)) = last_read {
                    let gap = if group(other) == group(command.bank) {
                        t.read_same_group
                    } else {
                        t.read
                    };
                    assert!(
                        at >= last + i64::from(gap),
                        "tCCD: {command:?} after {last}"
                    );
                }
                bank.read = at;
                last_read = Some((at, command.bank));
            }
            CommandKind::Refresh => {
                for (number, bank) in &banks {
                    assert!(bank.open.is_none(), "refresh with bank {number} open");
                    assert!(
                        at >= bank.precharged + i64::from(t.precharge),
                        "tRP before refresh"
                    );
                }
                refreshed = at;
            }
        }
    }
}

fn timings() -> impl Strategy<Value = Timing> {
    (
        1u32..9,
        1u32..9,
        0u32..20,
        0u32..6,
        1u32..3,
        0u32..3,
        0u32..5,
        0u32..20,
        0u32..3,
        prop::option::of(60u32..300),
    )
        .prop_map(
            |(
                precharge,
                activate,
                row_active,
                read_to_precharge,
                read,
                extra,
                rrd,
                faw,
                groups,
                refresh,
            )| Timing {
                precharge,
                activate,
                row_active,
                read_to_precharge,
                read,
                read_same_group: read + extra,
                activate_to_activate: rrd,
                four_activates: faw,
                bank_groups: 1 << groups,
                burst: 1,
                refresh_interval: refresh.unwrap_or(0),
                refresh: 20,
                longest_open: 0,
            },
        )
}

/// A walk of rays through a volume: nearby cells with leaps between.
fn walks() -> impl Strategy<Value = Vec<[i32; 3]>> {
    prop::collection::vec(prop::array::uniform3(-1i32..70), 1..40).prop_map(|points| {
        points
            .iter()
            .flat_map(|p| (0..6).map(move |k| [p[0], p[1] + k, p[2] + k / 3]))
            .collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn no_command_breaks_a_rule(
        timing in timings(), walk in walks(), one_module in any::<bool>(), in_background in any::<bool>(),
        cache in prop::option::of((0u32..4, 1u32..4, 0u32..4)),
    ) {
        let spec = MemorySpec {
            model: if one_module { MemoryModel::M1Interleaved } else { MemoryModel::M8 },
            timing,
            cache: cache.map(|(sets, ways, line)| Cache { sets: 1 << sets, ways, line: 1 << line }),
            ..MemorySpec::default()
        };
        let layout = VoxelLayout::new(&spec, [72, 80, 72]).unwrap();
        let mut dram = Dram::new(&spec, &layout);
        dram.record();
        let mut now = 0u64;
        for cell in walk {
            if in_background {
                now = dram.refresh(now as i64) as u64;
                dram.prepare(now, cell, &layout);
                while !dram.is_ready(now, cell, &layout) {
                    now += 1;
                }
            }
            let access = dram.access(now, cell, &layout);
            if in_background && !one_module && access.refresh_clocks == 0 && cache.is_none() {
                prop_assert_eq!(access.row_clocks + access.serial_clocks, 0, "a ready read waited");
            }
            now += 1 + u64::from(access.row_clocks + access.refresh_clocks + access.serial_clocks);
        }
        for module in 0..layout.modules {
            let mut commands: Vec<Command> = dram.commands().iter().copied().filter(|c| c.module == module).collect();
            // Modules have their own buses; commands of one are noted in the order of their making.
            commands.sort_by_key(|c| c.at);
            check(&commands, &timing, spec.banks);
        }
    }

    /// With plain timing, the quick memory and the one that knows all rules find the same rows and wait as long.
    #[test]
    fn both_memories_agree_on_plain_sdram(walk in walks(), one_module in any::<bool>()) {
        let spec = MemorySpec {
            model: if one_module { MemoryModel::M1Interleaved } else { MemoryModel::M8 },
            ..MemorySpec::default()
        };
        let layout = VoxelLayout::new(&spec, [72, 80, 72]).unwrap();
        let mut quick = Memory::new(&spec, layout.clone(), false);
        let mut thorough = Memory::new(&spec, layout, true);
        let mut now = 0u64;
        for cell in walk {
            let (a, b) = (quick.access(now, cell), thorough.access(now, cell));
            prop_assert_eq!((a.module_misses, a.thesis_changes), (b.module_misses, b.thesis_changes));
            prop_assert_eq!(a.row_clocks + a.serial_clocks, b.row_clocks + b.serial_clocks, "{:?} {:?}", a, b);
            now += 1 + u64::from(a.row_clocks + a.serial_clocks);
        }
    }
}
