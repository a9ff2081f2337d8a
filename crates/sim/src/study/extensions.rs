//! What the document designs in its chapter 8: what each of it costs, and what it looks like.

use super::lab::{Case, Lab, digits, document_spec, small_jaw};
use crate::Error;
use crate::report::{Report, Table};
use crate::spec::{
    Axis, Bend, DistanceMemory, Engine, Leaping, Light, Merge, Optimisation, Polygons, Projection,
    Shadow, Shape, Spec,
};

pub fn extensions(lab: &Lab) -> Result<Report, Error> {
    let volume = small_jaw()?;
    let with = |change: &dyn Fn(&mut Spec)| {
        let mut spec = document_spec();
        spec.look.opacity = vec![[1200.0, 0.0], [1600.0, 0.5], [4095.0, 1.0]];
        spec.view.rotate_z_deg = 30.0;
        spec.view.rotate_x_deg = 25.0;
        change(&mut spec);
        spec
    };
    let from_the_left = vec![Light {
        direction: [-1.0, -0.3, 0.0],
        intensity: 1.0,
    }];
    let wide = Projection::Perspective { angle_deg: 90.0 };
    let engine = |margin| Engine {
        columns: 32,
        rows: 32,
        margin,
        load_ms: 0,
    };
    let variants: Vec<(&str, Spec)> = vec![
        ("plain", with(&|_| ())),
        (
            "brute force",
            with(&|s| s.optimisation = Optimisation::none()),
        ),
        (
            "shadow from the left",
            with(&|s| {
                s.shadow = Shadow::FromLeft;
                s.look.lights = from_the_left.clone();
            }),
        ),
        (
            "shadow from the left, brute force",
            with(&|s| {
                s.optimisation = Optimisation::none();
                s.shadow = Shadow::FromLeft;
                s.look.lights = from_the_left.clone();
            }),
        ),
        (
            "two boards, cut across y",
            with(&|s| {
                s.merge = Merge {
                    boards: 2,
                    ..Merge::default()
                }
            }),
        ),
        (
            "four boards, cut across z",
            with(&|s| {
                s.merge = Merge {
                    boards: 4,
                    cut: Axis::Z,
                    ..Merge::default()
                };
            }),
        ),
        ("perspective 90°", with(&|s| s.view.projection = wide)),
        (
            "perspective 90°, four slabs",
            with(&|s| {
                s.view.projection = wide;
                s.view.slabs = 4;
            }),
        ),
        (
            "a ball",
            with(&|s| {
                s.polygons = Polygons {
                    shape: Shape::Sphere {
                        centre: [50.0, 40.0, 20.0],
                        radius: 22.0,
                    },
                    ..Polygons::default()
                };
            }),
        ),
        (
            "straight rays without leaping",
            with(&|s| s.optimisation.leaping = Leaping::Off),
        ),
        (
            "twisted rays",
            with(&|s| {
                s.optimisation.leaping = Leaping::Off;
                s.bend = Bend::Twist { deg_per_plane: 0.3 };
            }),
        ),
        (
            "rays through a lens",
            with(&|s| {
                s.optimisation.leaping = Leaping::Off;
                s.bend = Bend::Lens {
                    strength: 0.5,
                    radius: 40.0,
                };
            }),
        ),
        (
            "distances by the engine, margin 8",
            with(&|s| s.optimisation.distance_engine = Some(engine(8))),
        ),
        (
            "distances by the engine, margin 2",
            with(&|s| s.optimisation.distance_engine = Some(engine(2))),
        ),
        (
            "distance store of SDRAM",
            with(&|s| s.memory.distance_store = DistanceMemory::Sdram),
        ),
        (
            "distance store of SDRAM, 2³ cells",
            with(&|s| {
                s.memory.distance_store = DistanceMemory::Sdram;
                s.optimisation.distance_block = 2;
            }),
        ),
    ];
    let cases: Vec<Case> = variants
        .iter()
        .map(|(name, spec)| ((*name).to_owned(), spec.clone(), &volume))
        .collect();
    let runs = lab.run(cases)?;
    let mut table = Table::new(
        "variants",
        &[
            "variant",
            "clocks",
            "of plain %",
            "reads",
            "light reads",
            "row stalls",
            "rows of distances",
            "host bytes",
            "coding clocks",
            "clocks of parts",
        ],
    );
    let plain = runs[0].1.counters.clocks as f64;
    let mut pictures = Vec::new();
    for ((name, _), (run, s)) in variants.iter().zip(&runs) {
        let c = &s.counters;
        let parts: Vec<String> = run.clocks_of_part.iter().map(u64::to_string).collect();
        table.rows.push(vec![
            (*name).to_owned(),
            c.clocks.to_string(),
            digits(100.0 * c.clocks as f64 / plain),
            c.reads.to_string(),
            c.light_reads.to_string(),
            c.row_stalls.to_string(),
            c.distance_row_changes.to_string(),
            c.host_bytes.to_string(),
            c.coding_clocks.to_string(),
            parts.join(" "),
        ]);
        let is_shown = !(name.contains("brute") || name.contains("distance"));
        if is_shown {
            let file = name.replace([',', '°'], "").replace(' ', "-");
            pictures.push((file, (*name).to_owned(), run.png(8)?));
        }
    }
    Ok(Report {
        title: "What extensions cost".to_owned(),
        text: vec![
            "Jaw 128×128×64, 30° about z, 25° about x. Boards work at the same time, slabs one after the other. Bent rays do not \
             leap, so they stand beside straight ones that do not. Coding clocks come once per classification, beside the others."
                .to_owned(),
        ],
        tables: vec![table],
        pictures,
        ..Report::default()
    })
}
