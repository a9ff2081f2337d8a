//! Beyond the document: pictures compared, widths, schedulers, memories of today.

use super::lab::{Case, Lab, digits, document_spec, psnr_db, small_jaw};
use crate::chart::Chart;
use crate::report::{Report, Table};
use crate::spec::{
    Cache, Handover, Leaping, Memory, MemoryModel, Optimisation, Order, Scheduling, Spec, Timing,
    Widths,
};
use crate::{Error, VolumeStore};

pub fn leaping(lab: &Lab) -> Result<Report, Error> {
    let volume = small_jaw()?;
    let with = |change: &dyn Fn(&mut Optimisation)| {
        let mut spec = document_spec();
        spec.optimisation = Optimisation::none();
        spec.view.rotate_z_deg = 20.0;
        spec.view.rotate_x_deg = 10.0;
        change(&mut spec.optimisation);
        spec
    };
    let variants: Vec<(&str, Spec)> = vec![
        ("brute force", with(&|_| ())),
        ("leaping, safe", with(&|o| o.leaping = Leaping::Safe)),
        (
            "leaping, safe, 2³ cells",
            with(&|o| (o.leaping, o.distance_block) = (Leaping::Safe, 2)),
        ),
        (
            "leaping, document",
            with(&|o| o.leaping = Leaping::Document),
        ),
        (
            "leaping, document, 2³ voxels",
            with(&|o| (o.leaping, o.distance_block) = (Leaping::Document, 2)),
        ),
        (
            "leaping, safe, and homogeneous",
            with(&|o| (o.leaping, o.leap_homogeneous) = (Leaping::Safe, true)),
        ),
        ("termination 1 %", with(&|o| o.termination_threshold = 0.01)),
        ("termination 5 %", with(&|o| o.termination_threshold = 0.05)),
        (
            "termination 10 %",
            with(&|o| o.termination_threshold = 0.10),
        ),
        (
            "leaping, safe, termination 5 %",
            with(&|o| (o.leaping, o.termination_threshold) = (Leaping::Safe, 0.05)),
        ),
        (
            "adaptive, error 1",
            with(&|o| (o.leaping, o.adaptive_error) = (Leaping::Safe, 1)),
        ),
        (
            "adaptive, error 4",
            with(&|o| (o.leaping, o.adaptive_error) = (Leaping::Safe, 4)),
        ),
        (
            "adaptive, error 16",
            with(&|o| (o.leaping, o.adaptive_error) = (Leaping::Safe, 16)),
        ),
    ];
    let cases: Vec<Case> = variants
        .iter()
        .map(|(n, s)| ((*n).to_owned(), s.clone(), &volume))
        .collect();
    let runs = lab.run(cases)?;
    let mut table = Table::new(
        "variants",
        &[
            "variant",
            "clocks",
            "reads",
            "of brute force %",
            "distance-only",
            "leapt",
            "ended early",
            "interpolated",
            "wasted",
            "PSNR dB",
            "pixels that differ",
        ],
    );
    let reference = &runs[0].0;
    for ((name, _), (run, s)) in variants.iter().zip(&runs) {
        let c = &s.counters;
        let differ = run
            .picture
            .iter()
            .zip(&reference.picture)
            .filter(|(a, b)| a != b)
            .count();
        table.rows.push(vec![
            (*name).to_owned(),
            c.clocks.to_string(),
            c.reads.to_string(),
            digits(100.0 * c.reads as f64 / c.samples as f64),
            c.distance_only_reads.to_string(),
            c.skipped_by_leaping.to_string(),
            c.skipped_by_termination.to_string(),
            c.skipped_by_adaptive_sampling.to_string(),
            c.wasted_samples.to_string(),
            digits(psnr_db(&run.picture, &reference.picture)),
            differ.to_string(),
        ]);
    }
    let pictures = vec![
        (
            "brute-force".to_owned(),
            "brute force, 20° about z, 10° about x".to_owned(),
            reference.png(8)?,
        ),
        (
            "document-rule".to_owned(),
            "leaping by the document's rule".to_owned(),
            runs[3].0.png(8)?,
        ),
        (
            "homogeneous".to_owned(),
            "leaping over homogeneous places: their absorption is lost".to_owned(),
            runs[5].0.png(8)?,
        ),
    ];
    Ok(Report {
        title: "What leaping, termination and adaptive sampling cost and save".to_owned(),
        text: vec![
            "Jaw 128×128×64. Safe leaping changes no pixel. The document's rule measures from voxel to voxel and may leap over \
             a sample whose far neighbours are visible. Leaping over homogeneous places (S4-23) keeps their light (none, with \
             gradient weighting) but loses their absorption. Termination is wrong by at most the threshold."
                .to_owned(),
        ],
        tables: vec![table],
        pictures,
        ..Report::default()
    })
}

pub fn widths(lab: &Lab) -> Result<Report, Error> {
    let volume = small_jaw()?;
    let view = |widths: Widths, step: f64| {
        let mut spec = document_spec();
        spec.widths = widths;
        spec.optimisation = Optimisation::none();
        spec.view.rotate_z_deg = 20.0;
        spec.view.rotate_x_deg = 10.0;
        spec.view.step = step;
        spec
    };
    let wide = Widths::wide();
    type Change = fn(&mut Widths, u32);
    let sweeps: [(&str, Change, std::ops::RangeInclusive<u32>); 7] = [
        ("data", |w, n| w.data = n, 4..=12),
        ("fraction", |w, n| w.fraction = n, 2..=12),
        ("lerp guard", |w, n| w.lerp_guard = n, 0..=5),
        (
            "transmittance",
            |w, n| (w.transmittance, w.accumulator_fraction) = (n, w.accumulator_fraction.min(n)),
            6..=20,
        ),
        (
            "position fraction",
            |w, n| (w.position_fraction, w.step_fraction, w.fraction) = (n, n, w.fraction.min(n)),
            4..=18,
        ),
        ("reflectance index", |w, n| w.reflectance_index = n, 1..=6),
        ("intensity", |w, n| w.intensity = n, 4..=12),
    ];
    let mut cases: Vec<Case> = vec![
        ("wide".to_owned(), view(wide, 1.0), &volume),
        ("document".to_owned(), view(Widths::default(), 1.0), &volume),
    ];
    for (name, change, bits) in &sweeps {
        for bits in bits.clone() {
            let mut widths = wide;
            change(&mut widths, bits);
            cases.push((format!("{name} {bits}"), view(widths, 1.0), &volume));
        }
    }
    let names: Vec<String> = cases.iter().map(|c| c.0.clone()).collect();
    let runs = lab.run(cases)?;
    let reference = &runs[0].0.picture;
    let mut table = Table::new("widths", &["width", "bits", "PSNR dB against wide words"]);
    let mut chart = Chart {
        title: "PSNR against wide words, one width at a time".to_owned(),
        x: "bits".to_owned(),
        y: "PSNR in dB".to_owned(),
        ..Chart::default()
    };
    let document = psnr_db(&runs[1].0.picture, reference);
    table.rows.push(vec![
        "all as in the document".to_owned(),
        "–".to_owned(),
        digits(document),
    ]);
    for (name, (run, _)) in names.iter().zip(&runs).skip(2) {
        let Some((width, bits)) = name.rsplit_once(' ') else {
            continue;
        };
        let psnr = psnr_db(&run.picture, reference);
        table
            .rows
            .push(vec![width.to_owned(), bits.to_owned(), digits(psnr)]);
        if !psnr.is_finite() {
            continue;
        }
        let point = [bits.parse().unwrap_or(0.0), psnr];
        match chart.lines.last_mut().filter(|line| line.0 == width) {
            Some(line) => line.1.push(point),
            None => chart.lines.push((width.to_owned(), vec![point])),
        }
    }
    Ok(Report {
        title: "Word widths".to_owned(),
        text: vec![format!(
            "Jaw 128×128×64 at 20° and 10°, lit, weighted by the gradient. Reference: {} bits of data, {} of fraction, {} \
             guard bits, {} of transmittance. All widths of the document together: {document:.1} dB. The lines show which of \
             them the loss comes from: the line that is lowest at the document's width is the one to widen first.",
            wide.data, wide.fraction, wide.lerp_guard, wide.transmittance
        )],
        tables: vec![table],
        charts: vec![("psnr".to_owned(), chart)],
        pictures: vec![
            (
                "wide".to_owned(),
                "wide words".to_owned(),
                runs[0].0.png(8)?,
            ),
            (
                "document".to_owned(),
                "words of the document".to_owned(),
                runs[1].0.png(8)?,
            ),
        ],
        ..Report::default()
    })
}

pub fn scheduling(lab: &Lab) -> Result<Report, Error> {
    let volume = small_jaw()?;
    let with = |change: &dyn Fn(&mut Spec)| {
        let mut spec = document_spec();
        change(&mut spec);
        spec
    };
    let ready = |window| Scheduling::ReadyRowFirst { window };
    let variants: Vec<(&str, Spec)> = vec![
        ("as the document: next tile when empty", with(&|_| ())),
        (
            "next tile when done",
            with(&|s| s.queue.handover = Handover::WhenDone),
        ),
        (
            "serial filling",
            with(&|s| s.queue.handover = Handover::Serial),
        ),
        ("refill", with(&|s| s.queue.handover = Handover::Refill)),
        ("not sorted", with(&|s| s.queue.order = Order::RoundRobin)),
        (
            "not sorted, refill",
            with(&|s| (s.queue.order, s.queue.handover) = (Order::RoundRobin, Handover::Refill)),
        ),
        (
            "ready row first, window 4",
            with(&|s| s.queue.scheduling = ready(4)),
        ),
        (
            "ready row first, window 16",
            with(&|s| s.queue.scheduling = ready(16)),
        ),
        (
            "ready row first, window 64",
            with(&|s| s.queue.scheduling = ready(64)),
        ),
        (
            "ready row first, window 64, refill",
            with(&|s| (s.queue.scheduling, s.queue.handover) = (ready(64), Handover::Refill)),
        ),
        (
            "16×16 rays, refill",
            with(&|s| (s.queue.bundle, s.queue.handover) = ([16, 16], Handover::Refill)),
        ),
        (
            "two pipelines, one read per clock",
            with(&|s| s.queue.pipelines = 2),
        ),
        (
            "two pipelines, two reads per clock",
            with(&|s| (s.queue.pipelines, s.memory.ports) = (2, 2)),
        ),
        (
            "four pipelines, two reads per clock",
            with(&|s| (s.queue.pipelines, s.memory.ports) = (4, 2)),
        ),
        (
            "four pipelines, four reads per clock",
            with(&|s| (s.queue.pipelines, s.memory.ports) = (4, 4)),
        ),
        (
            "host waited for, 533 MB/s",
            with(&|s| s.host.is_waited_for = true),
        ),
        (
            "host waited for, 133 MB/s",
            with(&|s| (s.host.is_waited_for, s.host.bus_mb_per_s) = (true, 133.0)),
        ),
        (
            "host waited for, 30 MB/s",
            with(&|s| (s.host.is_waited_for, s.host.bus_mb_per_s) = (true, 30.0)),
        ),
    ];
    let cases: Vec<Case> = variants
        .iter()
        .map(|(n, s)| ((*n).to_owned(), s.clone(), &volume))
        .collect();
    let runs = lab.run(cases)?;
    let mut table = Table::new(
        "variants",
        &[
            "variant",
            "clocks",
            "Hz",
            "utilisation %",
            "row stalls",
            "frozen for rows",
            "empty",
            "ended ray",
            "no row ready",
            "filling",
            "host",
            "other pipelines",
            "wasted samples",
        ],
    );
    for ((name, _), (run, s)) in variants.iter().zip(&runs) {
        let c = &s.counters;
        if run.picture != runs[0].0.picture {
            return Err(Error::field(
                "study",
                name,
                "the picture depends on the scheduling, which must not be",
            ));
        }
        table.rows.push(vec![
            (*name).to_owned(),
            c.clocks.to_string(),
            digits(s.frames_per_second),
            digits(100.0 * s.utilisation),
            c.row_stalls.to_string(),
            c.frozen_for_rows.to_string(),
            c.bubbles_empty.to_string(),
            c.bubbles_ended.to_string(),
            c.bubbles_rows.to_string(),
            c.bubbles_filling.to_string(),
            c.bubbles_host.to_string(),
            c.bubbles_shared.to_string(),
            c.wasted_samples.to_string(),
        ]);
    }
    Ok(Report {
        title: "Scheduling".to_owned(),
        text: vec![
            "Jaw 128×128×64 from the front, linear from 1000, all eight neighbours counted. Every variant draws the same picture, \
             which is checked. Refill changes nothing with one queue of 64: rays of the tile before always go first, so what enters \
             early waits. Ready-row-first opens the rows of the first ray in the background and lets others pass whose rows \
             are open; it pays with clocks in which nobody is ready."
                .to_owned(),
        ],
        tables: vec![table],
        ..Report::default()
    })
}

/// Memories of today, in clocks of a pipeline: name, clock in MHz, and the memory.
pub fn memories() -> Vec<(&'static str, f64, Memory)> {
    let plain = Memory::default();
    let refreshed = Timing {
        refresh_interval: 1560,
        refresh: 7,
        longest_open: 10_000,
        ..Timing::default()
    };
    // 3200 MT/s: 1.25 ns per half-bus clock; times of a common grade (22-22-22), at a pipeline of 400 MHz (2.5 ns).
    let ddr4 = Timing {
        precharge: 6,
        activate: 6,
        row_active: 13,
        read_to_precharge: 3,
        read: 1,
        read_same_group: 2,
        activate_to_activate: 2,
        four_activates: 9,
        bank_groups: 4,
        burst: 8,
        refresh_interval: 3120,
        refresh: 140,
        longest_open: 0,
    };
    // LPDDR4-3200 at 400 MHz: no bank groups, bursts of 16 words.
    let lpddr4 = Timing {
        precharge: 8,
        activate: 8,
        row_active: 17,
        read_to_precharge: 3,
        read: 2,
        read_same_group: 2,
        activate_to_activate: 4,
        four_activates: 16,
        bank_groups: 1,
        burst: 16,
        refresh_interval: 1560,
        refresh: 112,
        longest_open: 0,
    };
    // HBM2 pseudo channel of 64 bits at 500 MHz (2 ns): bursts of 4 · 64 bits are 16 words of 16 bits.
    let hbm2 = Timing {
        precharge: 7,
        activate: 7,
        row_active: 17,
        read_to_precharge: 3,
        read: 1,
        read_same_group: 2,
        activate_to_activate: 2,
        four_activates: 8,
        bank_groups: 4,
        burst: 16,
        refresh_interval: 1950,
        refresh: 130,
        longest_open: 0,
    };
    let cache = |sets, ways, line| Some(Cache { sets, ways, line });
    vec![
        ("SDR, document", 100.0, plain),
        (
            "SDR with refresh and open time",
            100.0,
            Memory {
                timing: refreshed,
                ..plain
            },
        ),
        (
            "SDR with refresh, cache 2 KiB",
            100.0,
            Memory {
                timing: refreshed,
                cache: cache(64, 4, 4),
                ..plain
            },
        ),
        (
            "DDR4-3200",
            400.0,
            Memory {
                timing: ddr4,
                banks: 16,
                chips: 1,
                columns: 1024,
                rows: 1 << 16,
                ..plain
            },
        ),
        (
            "DDR4-3200, cache 2 KiB",
            400.0,
            Memory {
                timing: ddr4,
                banks: 16,
                chips: 1,
                columns: 1024,
                rows: 1 << 16,
                cache: cache(32, 4, 8),
                ..plain
            },
        ),
        (
            "LPDDR4-3200",
            400.0,
            Memory {
                timing: lpddr4,
                banks: 8,
                chips: 1,
                columns: 1024,
                rows: 1 << 16,
                ..plain
            },
        ),
        (
            "LPDDR4-3200, cache 4 KiB",
            400.0,
            Memory {
                timing: lpddr4,
                banks: 8,
                chips: 1,
                columns: 1024,
                rows: 1 << 16,
                cache: cache(32, 4, 16),
                ..plain
            },
        ),
        (
            "HBM2",
            500.0,
            Memory {
                timing: hbm2,
                banks: 16,
                chips: 1,
                columns: 512,
                rows: 1 << 15,
                ..plain
            },
        ),
        (
            "HBM2, cache 4 KiB",
            500.0,
            Memory {
                timing: hbm2,
                banks: 16,
                chips: 1,
                columns: 512,
                rows: 1 << 15,
                cache: cache(32, 4, 16),
                ..plain
            },
        ),
    ]
}

pub fn dram(lab: &Lab) -> Result<Report, Error> {
    let volume = small_jaw()?;
    let mut variants: Vec<(String, Spec)> = Vec::new();
    for (name, clock_mhz, memory) in memories() {
        for order in [Order::PlaneDistance, Order::RoundRobin] {
            let mut spec = Spec {
                clock_mhz,
                memory,
                ..document_spec()
            };
            spec.queue.order = order;
            let sorted = if order == Order::RoundRobin {
                "not sorted"
            } else {
                "sorted"
            };
            variants.push((format!("{name}, {sorted}"), spec.clone()));
            if order == Order::PlaneDistance {
                spec.queue.scheduling = Scheduling::ReadyRowFirst { window: 64 };
                variants.push((format!("{name}, ready row first"), spec));
            }
        }
    }
    let cases: Vec<Case> = variants
        .iter()
        .map(|(n, s)| (n.clone(), s.clone(), &volume))
        .collect();
    let runs = lab.run(cases)?;
    let mut table = Table::new(
        "memories",
        &[
            "memory",
            "MHz",
            "clocks",
            "Hz",
            "utilisation %",
            "row stalls",
            "for rows %",
            "for words %",
            "for refresh %",
            "bubbles %",
            "cache hits %",
        ],
    );
    for ((name, spec), (_, s)) in variants.iter().zip(&runs) {
        let c = &s.counters;
        let percent = |n: u64| digits(100.0 * n as f64 / c.clocks as f64);
        let looked = c.cache_hits + c.cache_misses;
        table.rows.push(vec![
            name.clone(),
            digits(spec.clock_mhz),
            c.clocks.to_string(),
            digits(s.frames_per_second),
            digits(100.0 * s.utilisation),
            c.row_stalls.to_string(),
            percent(c.frozen_for_rows),
            percent(c.frozen_for_words),
            percent(c.frozen_for_refresh),
            percent(c.bubbles()),
            if looked == 0 {
                "–".to_owned()
            } else {
                digits(100.0 * c.cache_hits as f64 / looked as f64)
            },
        ]);
    }
    Ok(Report {
        title: "Memories of today".to_owned(),
        text: vec![
            "Jaw 128×128×64 from the front. Eight modules each, with times of common speed grades rounded up to clocks of the \
             pipeline (Spec: memory.timing). A burst brings 8 or 16 words of which one sample needs one; without a cache the \
             others are lost. Consecutive reads of one bank group cost two clocks, which is what sorting does to DDR4 and HBM2: \
             rays of one tile stay in one bank."
                .to_owned(),
        ],
        tables: vec![table],
        ..Report::default()
    })
}

pub fn volumes(lab: &Lab) -> Result<Report, Error> {
    let jaw = small_jaw()?;
    let mut volumes: Vec<(&VolumeStore, Vec<[f64; 2]>)> =
        vec![(&jaw, super::lab::LINEAR_1000.to_vec())];
    volumes.extend(lab.volumes.iter().map(|(v, curve)| (v, curve.clone())));
    let variants: [(&str, Optimisation, Order, MemoryModel); 5] = [
        (
            "brute force",
            Optimisation::none(),
            Order::PlaneDistance,
            MemoryModel::M8,
        ),
        (
            "not sorted",
            Optimisation::default(),
            Order::RoundRobin,
            MemoryModel::M8,
        ),
        (
            "sorted by length",
            Optimisation::default(),
            Order::RemainingLength,
            MemoryModel::M8,
        ),
        (
            "sorted by distance",
            Optimisation::default(),
            Order::PlaneDistance,
            MemoryModel::M8,
        ),
        (
            "one linear module",
            Optimisation::default(),
            Order::PlaneDistance,
            MemoryModel::M1Linear,
        ),
    ];
    let mut table = Table::new(
        "volumes",
        &[
            "volume",
            "variant",
            "angle °",
            "Hz",
            "utilisation %",
            "reads % of samples",
            "leapt %",
            "ended %",
            "row changes (thesis)",
            "row stalls (exact)",
            "changes per read %",
        ],
    );
    let mut pictures = Vec::new();
    for (volume, curve) in &volumes {
        let mut cases: Vec<Case> = Vec::new();
        for angle in [0.0, 30.0] {
            for (name, optimisation, order, model) in variants {
                let mut spec = Spec {
                    optimisation,
                    ..document_spec()
                };
                spec.look.opacity.clone_from(curve);
                spec.queue.order = order;
                spec.memory.model = model;
                if model == MemoryModel::M1Linear {
                    // Four banks of eight planes per chip.
                    spec.memory.chips = (volume.dims[2] as u32).div_ceil(32).next_power_of_two();
                }
                spec.view.rotate_z_deg = angle;
                let longest = volume.dims.iter().map(|n| n * n).sum::<usize>();
                if longest > 1000 * 1000 {
                    (spec.widths.length, spec.widths.key) = (12, 12);
                }
                cases.push((name.to_owned(), spec, *volume));
            }
        }
        let runs = lab.run(cases)?;
        for (k, (run, s)) in runs.iter().enumerate() {
            let c = &s.counters;
            let shares = s.percent_of_samples;
            let (name, .., model) = variants[k % variants.len()];
            let words = if model == MemoryModel::M8 {
                c.reads
            } else {
                c.reads + c.frozen_for_words
            };
            table.rows.push(vec![
                volume.name.clone(),
                name.to_owned(),
                digits(s.spec.view.rotate_z_deg),
                digits(s.frames_per_second),
                digits(100.0 * s.utilisation),
                digits(100.0 * c.reads as f64 / c.samples as f64),
                digits(shares[0]),
                digits(shares[1]),
                c.thesis_row_changes.to_string(),
                c.row_stalls.to_string(),
                digits(100.0 * c.thesis_row_changes as f64 / words as f64),
            ]);
            if k == 8 {
                let file = volume
                    .name
                    .replace(|c: char| !c.is_ascii_alphanumeric(), "-");
                pictures.push((file, format!("{}, 30°", volume.name), run.png(8)?));
            }
        }
    }
    Ok(Report {
        title: "Several volumes".to_owned(),
        text: vec![
            "The same machine on other data: sorting and layout are not a matter of one jaw."
                .to_owned(),
        ],
        tables: vec![table],
        pictures,
        ..Report::default()
    })
}
