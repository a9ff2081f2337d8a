//! The document's own experiments (chapter 9; sections 6.1 to 6.8 of the extraction).

use super::lab::{
    Case, LINEAR_0, LINEAR_1000, Lab, THRESHOLD_1300, digits, document_spec, small_jaw,
};
use crate::chart::Chart;
use crate::gray_png;
use crate::host::transfers;
use crate::report::{Report, Table};
use crate::spec::{MemoryModel, Optimisation, Order, Projection, RowRule, Spec};
use crate::statistics::percent_of_samples;
use crate::{Error, VolumeStore, jaw};

const ANGLES: [f64; 10] = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0];

fn perspective() -> Projection {
    Projection::Perspective {
        angle_deg: 53.130_102_354_155_98,
    }
}

fn thesis(mut spec: Spec) -> Spec {
    spec.memory.row_rule = RowRule::Thesis;
    spec
}

pub fn bundle(lab: &Lab) -> Result<Report, Error> {
    let volume = small_jaw()?;
    let edges = [2u32, 4, 8, 12, 16, 24, 32, 48];
    let mut cases = Vec::new();
    for (rule, spec) in [
        ("thesis", thesis(document_spec())),
        ("exact", document_spec()),
    ] {
        for (kind, optimisation) in [
            ("all", Optimisation::none()),
            ("leaping and termination", Optimisation::default()),
        ] {
            for edge in edges {
                let mut spec = Spec {
                    optimisation,
                    ..spec.clone()
                };
                spec.queue.bundle = [edge, edge];
                cases.push((format!("{rule}, {kind}"), spec, &volume));
            }
        }
    }
    let names: Vec<String> = cases.iter().map(|c| c.0.clone()).collect();
    let runs = lab.run(cases)?;
    let mut table = Table::new(
        "utilisation",
        &[
            "counter, samples",
            "rays per side",
            "utilisation %",
            "frozen for rows %",
            "bubbles %",
            "row changes (thesis)",
            "row stalls (exact)",
            "Hz",
        ],
    );
    let mut chart = Chart {
        title: "Bundle size against utilisation, jaw 128×128×64 from the front".to_owned(),
        x: "rays along each side of a tile".to_owned(),
        y: "utilisation in %".to_owned(),
        ..Chart::default()
    };
    for (name, (_, s)) in names.iter().zip(&runs) {
        let edge = s.spec.queue.bundle[0];
        let c = &s.counters;
        let percent = |n: u64| digits(100.0 * n as f64 / c.clocks as f64);
        table.rows.push(vec![
            name.clone(),
            edge.to_string(),
            digits(100.0 * s.utilisation),
            percent(c.frozen_for_rows),
            percent(c.bubbles()),
            c.thesis_row_changes.to_string(),
            c.row_stalls.to_string(),
            digits(s.frames_per_second),
        ]);
        let point = [f64::from(edge), 100.0 * s.utilisation];
        match chart.lines.last_mut().filter(|line| line.0 == *name) {
            Some(line) => line.1.push(point),
            None => chart.lines.push((name.clone(), vec![point])),
        }
    }
    Ok(Report {
        title: "Bundle size against utilisation (document §9.1.2)".to_owned(),
        text: vec![
            "The document: 97 % at 8×8, 99 % at 16×16 (the maximum), slightly less for larger ones, less for smaller ones. \
             Small bundles open the rows of a block once per bundle; bundles wider than a block of 16 voxels touch several. \
             Brute force keeps the pipeline full whatever the bundle; with termination a small bundle also runs out of rays, \
             which shows as bubbles."
                .to_owned(),
        ],
        tables: vec![table],
        charts: vec![("utilisation".to_owned(), chart)],
        ..Report::default()
    })
}

pub fn row_changes(lab: &Lab) -> Result<Report, Error> {
    let volume = small_jaw()?;
    let base = thesis(document_spec());
    let variant = |optimisation, order| {
        let mut spec = Spec {
            optimisation,
            ..base.clone()
        };
        spec.queue.order = order;
        spec
    };
    let names = ["brute force", "round robin", "sorted by plane distance"];
    let variants = [
        variant(Optimisation::none(), Order::PlaneDistance),
        variant(Optimisation::default(), Order::RoundRobin),
        variant(Optimisation::default(), Order::PlaneDistance),
    ];
    let mut cases: Vec<Case> = Vec::new();
    for angle in ANGLES {
        for (name, spec) in names.iter().zip(&variants) {
            let mut spec = spec.clone();
            spec.view.rotate_z_deg = angle;
            cases.push(((*name).to_owned(), spec, &volume));
        }
    }
    let runs = lab.run(cases)?;
    let mut table = Table::new(
        "rotation",
        &[
            "angle °",
            "samples",
            "row changes (thesis)",
            "row stalls (exact)",
            "reads",
            "changes per read %",
            "Hz",
        ],
    );
    let mut factors = Table::new(
        "factors",
        &[
            "angle °",
            "brute force",
            "round robin",
            "sorted",
            "unsorted / sorted",
            "sorted / brute force",
            "frame rate gained by sorting %",
        ],
    );
    let mut pictures = Vec::new();
    let mut lines: Vec<(String, Vec<[f64; 2]>)> =
        names.map(|n| (n.to_owned(), Vec::new())).to_vec();
    for (i, angle) in ANGLES.iter().enumerate() {
        let three = &runs[3 * i..3 * i + 3];
        for (k, (run, s)) in three.iter().enumerate() {
            table.rows.push(vec![
                digits(*angle),
                names[k].to_owned(),
                s.counters.thesis_row_changes.to_string(),
                s.counters.row_stalls.to_string(),
                s.counters.reads.to_string(),
                digits(100.0 * s.thesis_changes_per_read),
                digits(s.frames_per_second),
            ]);
            lines[k]
                .1
                .push([*angle, s.counters.thesis_row_changes as f64]);
            if i == 0 {
                let png = gray_png::encode_counts(run.size, &run.thesis_changes_of_pixel, Some(8))?;
                let caption = format!(
                    "{}: {} row changes, by the pixel whose ray met them (white: 8 or more)",
                    names[k], s.counters.thesis_row_changes
                );
                pictures.push((format!("changes-{k}"), caption, png));
            }
        }
        let changes = |k: usize| three[k].1.counters.thesis_row_changes as f64;
        let rate = |k: usize| three[k].1.frames_per_second;
        factors.rows.push(vec![
            digits(*angle),
            digits(changes(0)),
            digits(changes(1)),
            digits(changes(2)),
            digits(changes(1) / changes(2)),
            digits(changes(2) / changes(0)),
            digits(100.0 * (rate(2) / rate(1) - 1.0)),
        ]);
    }
    let chart = Chart {
        title: "Row changes over rotation (thesis counter)".to_owned(),
        x: "rotation about z in degrees".to_owned(),
        y: "row changes".to_owned(),
        lines,
        ..Chart::default()
    };
    Ok(Report {
        title: "Row changes (document §9.1.3)".to_owned(),
        text: vec![
            "The document, at 0°: 1024 without optimisation, 5894 unsorted, 1067 sorted (a factor of 5.5, up to 7 at 10° and \
             80°); sorting gains 13 % frame rate. 1024 is geometry and comes out exactly. The others depend on the \
             document's jaw, which is not public: how many rays leap apart, and how far."
                .to_owned(),
        ],
        tables: vec![factors, table],
        charts: vec![("rotation".to_owned(), chart)],
        pictures,
        ..Report::default()
    })
}

pub fn order(lab: &Lab) -> Result<Report, Error> {
    let volume = small_jaw()?;
    let orders = [
        ("plane distance", Order::PlaneDistance),
        ("remaining length", Order::RemainingLength),
        ("round robin", Order::RoundRobin),
    ];
    let mut cases: Vec<Case> = Vec::new();
    for angle in ANGLES {
        for (name, order) in orders {
            let mut spec = thesis(document_spec());
            spec.queue.order = order;
            spec.view.rotate_z_deg = angle;
            cases.push((name.to_owned(), spec, &volume));
        }
    }
    let runs = lab.run(cases)?;
    let mut table = Table::new(
        "rotation",
        &[
            "angle °",
            "plane distance %",
            "remaining length %",
            "round robin %",
        ],
    );
    let mut lines: Vec<(String, Vec<[f64; 2]>)> =
        orders.map(|(n, _)| (n.to_owned(), Vec::new())).to_vec();
    for (i, angle) in ANGLES.iter().enumerate() {
        let mut row = vec![digits(*angle)];
        for k in 0..3 {
            let percent = 100.0 * runs[3 * i + k].1.thesis_changes_per_read;
            row.push(digits(percent));
            lines[k].1.push([*angle, percent]);
        }
        table.rows.push(row);
    }
    let chart = Chart {
        title: "Row changes per read by sort criterion".to_owned(),
        x: "rotation about z in degrees".to_owned(),
        y: "row changes per read in %".to_owned(),
        lines,
        ..Chart::default()
    };
    Ok(Report {
        title: "Sort criterion (document §9.1.4)".to_owned(),
        text: vec![
            "The document: both criteria the same at 0°, 90° and 30 to 60°; remaining length worse at 10, 20, 70 and 80°, \
             where rays of one tile enter through two faces and differ in length at the same distance; both far below unsorted."
                .to_owned(),
        ],
        tables: vec![table],
        charts: vec![("rotation".to_owned(), chart)],
        ..Report::default()
    })
}

pub fn rotation(lab: &Lab) -> Result<Report, Error> {
    let volume = small_jaw()?;
    let mut cases: Vec<Case> = Vec::new();
    for (name, projection) in [
        ("parallel", Projection::Parallel),
        ("perspective 53°", perspective()),
    ] {
        for angle in ANGLES {
            let mut spec = thesis(document_spec());
            spec.view.projection = projection;
            spec.view.rotate_z_deg = angle;
            cases.push((name.to_owned(), spec, &volume));
        }
    }
    let names: Vec<String> = cases.iter().map(|c| c.0.clone()).collect();
    let runs = lab.run(cases)?;
    let mut table = Table::new(
        "rotation",
        &[
            "projection",
            "angle °",
            "skipped by leaping %",
            "skipped by termination %",
            "distance-only reads %",
            "samples read %",
            "rays",
            "reads",
            "changes per read %",
            "stalls per read % (exact)",
            "Hz",
        ],
    );
    let mut charts = [
        ("shares", "Parts of all samples, parallel", "share in %"),
        (
            "changes",
            "Row changes per read (thesis counter)",
            "row changes per read in %",
        ),
        ("reads", "Reads", "thousand reads"),
        ("frame-rate", "Frame rate at 100 MHz", "Hz"),
    ]
    .map(|(name, title, y)| {
        let chart = Chart {
            title: title.to_owned(),
            x: "rotation about z in degrees".to_owned(),
            y: y.to_owned(),
            ..Chart::default()
        };
        (name.to_owned(), chart)
    });
    let parts = ["leaping", "termination", "distance only", "samples"];
    charts[0].1.lines = parts.map(|n| (n.to_owned(), Vec::new())).to_vec();
    for chart in &mut charts[1..] {
        chart.1.lines = ["parallel", "perspective 53°"]
            .map(|n| (n.to_owned(), Vec::new()))
            .to_vec();
    }
    let mut pictures = Vec::new();
    for (name, (run, s)) in names.iter().zip(&runs) {
        let angle = s.spec.view.rotate_z_deg;
        let is_parallel = s.spec.view.projection == Projection::Parallel;
        let shares = s.percent_of_samples;
        let mut row = vec![name.clone(), digits(angle)];
        row.extend(shares.map(digits));
        row.extend([
            s.counters.rays.to_string(),
            s.counters.reads.to_string(),
            digits(100.0 * s.thesis_changes_per_read),
            digits(100.0 * s.stalls_per_read),
            digits(s.frames_per_second),
        ]);
        table.rows.push(row);
        if is_parallel {
            for (k, share) in shares.iter().enumerate() {
                charts[0].1.lines[k].1.push([angle, *share]);
            }
        }
        let line = usize::from(!is_parallel);
        charts[1].1.lines[line]
            .1
            .push([angle, 100.0 * s.thesis_changes_per_read]);
        charts[2].1.lines[line]
            .1
            .push([angle, s.counters.reads as f64 / 1000.0]);
        charts[3].1.lines[line].1.push([angle, s.frames_per_second]);
        if angle == 20.0 {
            pictures.push((
                name.replace([' ', '°'], "-"),
                format!("{name}, 20°"),
                run.png(8)?,
            ));
        }
    }
    Ok(Report {
        title: "Rotation, parallel and perspective (document §9.1.5)".to_owned(),
        text: vec![
            "The document, over 0 to 90° and both projections: skipped by leaping 17–31 %, by termination 34–41 %, \
             distance-only reads 7–10 %, samples read 21–40 %; row changes below 0.37 % of the reads; perspective sends four \
             times the rays and reads less than twice as much, at 20–45 % lower frame rates. The phantom is made to have \
             comparable shares of empty and opaque voxels at 0°; elsewhere its shape decides. Samples that a dying ray had \
             already read when it died are counted as read."
                .to_owned(),
        ],
        tables: vec![table],
        charts: charts.to_vec(),
        pictures,
        ..Report::default()
    })
}

pub fn memory_model(lab: &Lab) -> Result<Report, Error> {
    let volume = small_jaw()?;
    let models = [
        ("M8", MemoryModel::M8),
        ("M1 interleaved", MemoryModel::M1Interleaved),
        ("M1 linear", MemoryModel::M1Linear),
    ];
    let mut cases: Vec<Case> = Vec::new();
    for (name, model) in models {
        for optimisation in [Optimisation::default(), Optimisation::none()] {
            for angle in ANGLES {
                let mut spec = Spec {
                    optimisation,
                    ..thesis(document_spec())
                };
                spec.memory.model = model;
                spec.view.rotate_z_deg = angle;
                cases.push((name.to_owned(), spec, &volume));
            }
        }
    }
    let runs = lab.run(cases)?;
    let mut table = Table::new(
        "rotation",
        &[
            "model",
            "samples",
            "angle °",
            "row changes",
            "words read",
            "changes per word %",
            "changes per sample",
            "Hz",
        ],
    );
    let mut lines: Vec<(String, Vec<[f64; 2]>)> = Vec::new();
    for (k, (name, model)) in models.iter().enumerate() {
        for (i, (_, s)) in runs[2 * k * ANGLES.len()..2 * (k + 1) * ANGLES.len()]
            .iter()
            .enumerate()
        {
            let angle = s.spec.view.rotate_z_deg;
            let samples = if i < ANGLES.len() {
                "leaping and termination"
            } else {
                "all"
            };
            if angle == 0.0 {
                lines.push((format!("{name}, {samples}"), Vec::new()));
            }
            let c = &s.counters;
            // Eight modules read at the same time: the document counts one access.
            let (changes, words) = match model {
                MemoryModel::M8 => (c.thesis_row_changes, c.reads),
                _ => (c.row_changes, c.reads + c.frozen_for_words),
            };
            let percent = 100.0 * changes as f64 / words as f64;
            table.rows.push(vec![
                (*name).to_owned(),
                samples.to_owned(),
                digits(angle),
                changes.to_string(),
                words.to_string(),
                digits(percent),
                digits(changes as f64 / c.reads as f64),
                digits(s.frames_per_second),
            ]);
            if let Some(line) = lines.last_mut() {
                line.1.push([angle, percent]);
            }
        }
    }
    let chart = Chart {
        title: "Row changes per word read".to_owned(),
        x: "rotation about z in degrees".to_owned(),
        y: "row changes per word in %".to_owned(),
        lines,
        is_logarithmic: true,
    };
    Ok(Report {
        title: "Memory models (document §9.1.6)".to_owned(),
        text: vec![
            "The document: eight modules below 0.37 %; one interleaved module more (its number is lost); one linear module \
             above 50 %, at least four changes per sample. In a linear order only two of the eight voxels of a cell share a \
             row, and the others lie in other rows of the same bank."
                .to_owned(),
        ],
        tables: vec![table],
        charts: vec![("rotation".to_owned(), chart)],
        ..Report::default()
    })
}

pub fn frame_rate(lab: &Lab) -> Result<Report, Error> {
    let mut dims = vec![[128, 128, 64], [256, 256, 128]];
    if lab.with_large {
        dims.extend([[512, 512, 256], [512, 512, 512]]);
    }
    let columns = [
        (
            "threshold 1300",
            THRESHOLD_1300.to_vec(),
            Optimisation::default(),
        ),
        (
            "linear from 1000",
            LINEAR_1000.to_vec(),
            Optimisation::default(),
        ),
        ("linear from 0", LINEAR_0.to_vec(), Optimisation::default()),
        ("brute force", LINEAR_1000.to_vec(), Optimisation::none()),
    ];
    let document = [["883", "189", "278", "95"], ["184", "36", "43", "11.8"]];
    let mut table = Table::new(
        "frame-rates",
        &[
            "voxels",
            "classification",
            "Hz (thesis counter)",
            "document Hz",
            "Hz (exact counter)",
            "factor to the size before",
            "reads % of voxels",
            "leapt %",
            "ended %",
        ],
    );
    let mut before: Vec<f64> = Vec::new();
    for (i, dims) in dims.iter().enumerate() {
        let volume = VolumeStore::new(&jaw(*dims)?)?;
        let mut cases: Vec<Case> = Vec::new();
        for (name, curve, optimisation) in &columns {
            let mut spec = Spec {
                optimisation: *optimisation,
                ..document_spec()
            };
            spec.look.opacity.clone_from(curve);
            cases.push(((*name).to_owned(), thesis(spec.clone()), &volume));
            cases.push(((*name).to_owned(), spec, &volume));
        }
        let runs = lab.run(cases)?;
        let mut rates = Vec::new();
        for (k, (name, ..)) in columns.iter().enumerate() {
            let (thesis, exact) = (&runs[2 * k].1, &runs[2 * k + 1].1);
            let shares = percent_of_samples(&thesis.counters);
            rates.push(thesis.frames_per_second);
            let factor = before
                .get(k)
                .map_or("–".to_owned(), |b| digits(b / thesis.frames_per_second));
            table.rows.push(vec![
                format!("{}×{}×{}", dims[0], dims[1], dims[2]),
                (*name).to_owned(),
                digits(thesis.frames_per_second),
                document.get(i).map_or("–", |row| row[k]).to_owned(),
                digits(exact.frames_per_second),
                factor,
                digits(100.0 * thesis.counters.reads as f64 / thesis.counters.samples as f64),
                digits(shares[0]),
                digits(shares[1]),
            ]);
        }
        before = rates;
    }
    let mut text = vec![
        "Table 9.1 of the document, at 100 MHz. Brute force is geometry and comes out as printed (95 and 11.8 Hz). The other \
         columns depend on the jaw: the phantom has comparable shares of empty and opaque voxels, not the same anatomy. \
         The document's factors per doubling are 4.8, 5.25, 6.47 and 8."
            .to_owned(),
    ];
    if lab.with_large {
        text.push("512×512×256 is the next doubling; 512³ is twice as deep. The document's extrapolations for 512³ (19.2, 3.8, 4.5, 1.25 Hz) follow no single rule; 100 MHz / 512³ is 0.745 Hz.".to_owned());
    }
    Ok(Report {
        title: "Frame rates by classification and size (document §9.1.7)".to_owned(),
        text,
        tables: vec![table],
        ..Report::default()
    })
}

pub fn motivation(_: &Lab) -> Result<Report, Error> {
    let mut table = Table::new(
        "reading",
        &[
            "voxels",
            "seconds at 150 M words/s",
            "GB at 16 bit",
            "GB/s at 30 Hz",
            "G instructions/s at 30 Hz, 10 per voxel",
        ],
    );
    for edge in [256u64, 512, 1024] {
        let voxels = (edge * edge * edge) as f64;
        table.rows.push(vec![
            format!("{edge}³"),
            digits(voxels / 150e6),
            digits(2.0 * voxels / 1e9),
            digits(60.0 * voxels / 1e9),
            digits(300.0 * voxels / 1e9),
        ]);
    }
    Ok(Report {
        title: "What reading a volume costs (document §1, 2.3.6)".to_owned(),
        text: vec!["The document: 0.11, 0.89 and 7 s; 1024³ of 16 bit is 2 GB, 60 GB/s and 300 G instructions/s at 30 Hz.".to_owned()],
        tables: vec![table],
        ..Report::default()
    })
}

pub fn transfer(_: &Lab) -> Result<Report, Error> {
    let spec = Spec::default();
    let mut table = Table::new("words", &["memory", "bits", "words", "bytes", "µs", "per"]);
    for t in transfers(
        &spec,
        1 << 30,
        1 << 18,
        6 << (2 * spec.widths.reflectance_index),
    ) {
        table.rows.push(vec![
            t.what.to_owned(),
            t.bits.to_string(),
            t.words.to_string(),
            t.bytes.to_string(),
            digits(t.microseconds(&spec)),
            t.per.to_owned(),
        ]);
    }
    let per_tile = crate::host::parameter_bytes(&spec) + crate::host::result_bytes(&spec);
    let mut images = Table::new(
        "images",
        &[
            "picture",
            "tiles",
            "ms",
            "rate without overlap at 1, 6, 36 Hz: share %",
        ],
    );
    for (edge, rate) in [(1024u64, 1.0), (512, 6.0), (256, 36.0)] {
        let tiles = edge * edge / 64;
        let ms = (tiles * per_tile) as f64 / spec.host.bus_mb_per_s / 1000.0;
        images.rows.push(vec![
            format!("{edge}²"),
            tiles.to_string(),
            digits(ms),
            digits(ms * rate / 10.0),
        ]);
    }
    Ok(Report {
        title: "What goes over the bus (document tables 7.2 and 7.3)".to_owned(),
        text: vec!["At 533 MB/s. The document: 35, 8.9 and 2.2 ms; 3.5, 5.3 and 8.0 %. The study `scheduling` shows tiles that wait for the bus.".to_owned()],
        tables: vec![table, images],
        ..Report::default()
    })
}
