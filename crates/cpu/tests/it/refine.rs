//! Pictures in stages.

use super::ending_after;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use strahl_cpu::{Error, Options, Renderer, Stage};
use strahl_scene::plan::{Compositing, Plan, Sampling};
use strahl_scene::{Image, Scene, resolve};
use strahl_volume::{Control, Phantom, Volume, Work};

fn stages(renderer: &Renderer, plan: &Plan, options: &Options) -> (Vec<(Image, Stage)>, Image) {
    let mut shown = Vec::new();
    let drawn = renderer
        .refine(plan, options, &Control::NONE, &mut |picture, stage| {
            shown.push((picture.clone(), stage));
            ControlFlow::Continue(())
        })
        .unwrap();
    (shown, drawn.image)
}

fn plan(volume: &Volume, scene: &str) -> Plan {
    let scene = Scene::parse("scene", scene).unwrap();
    resolve(&scene, &volume.header(), None).unwrap()
}

fn distance(a: &Image, b: &Image) -> f64 {
    let pairs = a.pixels().iter().flatten().zip(b.pixels().iter().flatten());
    pairs
        .map(|(a, b)| f64::from(a - b).powi(2))
        .sum::<f64>()
        .sqrt()
}

#[test]
fn the_last_stage_has_the_bytes_of_the_picture() {
    let volume = Phantom::Shells.volume([40; 3]).unwrap();
    let renderer = Renderer::new(&volume);
    let sizes = [[1, 1], [1, 9], [2, 3], [5, 1], [37, 23], [64, 48]];
    let rest = [
        r#""jitter": { "seed": 5 }"#,
        r#""method": "mip""#,
        r#""method": "first-hit""#,
        r#""frames": 3, "jitter": { "blue-tile": 2 }"#,
        r#""compositing": "display""#,
        r#""sampling": { "rule": "split" }"#,
        r#""sampling": { "rule": "integrated" }"#,
        r#""shading": { "model": "unlit" }, "sampling": { "error": 0.05 }"#,
    ];
    for (i, rest) in rest.iter().enumerate() {
        for [width, height] in sizes {
            let scene = format!(r#"{{ "size": [{width}, {height}], {rest} }}"#);
            let mut plan = plan(&volume, &scene);
            plan.with_depth = i % 2 == 0;
            let options = Options {
                threads: [1, 2, 7][i % 3],
                tile: [7, 32][i % 2],
                skip: i % 4 != 3,
                ..Options::default()
            };
            let expected = renderer.render(&plan, &options, &Control::NONE).unwrap();
            let mut last = None;
            let drawn = renderer
                .refine(&plan, &options, &Control::NONE, &mut |picture, stage| {
                    last = Some((picture.clone(), stage));
                    ControlFlow::Continue(())
                })
                .unwrap();
            let (last, stage) = last.unwrap();
            assert_eq!((stage.stride, stage.steps, stage.number), (1, 1, stage.of));
            let bits = |image: &Image| -> Vec<[u32; 4]> {
                image.pixels().iter().map(|p| p.map(f32::to_bits)).collect()
            };
            assert_eq!(bits(&drawn.image), bits(&expected.image), "{scene}");
            assert_eq!(bits(&last), bits(&expected.image), "{scene}");
            assert_eq!(drawn.depth_mm, expected.depth_mm, "{scene}");
            let counts = |stats: strahl_cpu::Stats| {
                // Which samples change a maximum depends on which rays go together.
                let counts = stats.counts.unwrap();
                let visible = (!rest.contains("mip")).then_some(counts.samples_visible);
                (counts.rays, counts.lattice_points, visible)
            };
            assert_eq!(counts(drawn.stats), counts(expected.stats), "{scene}");
        }
    }
}

#[test]
fn each_stage_is_nearer_to_the_picture() {
    for phantom in [Phantom::Shells, Phantom::Tree] {
        let volume = phantom.volume([48; 3]).unwrap();
        let renderer = Renderer::new(&volume);
        for method in ["emission-absorption", "mip", "first-hit"] {
            let plan = plan(
                &volume,
                &format!(r#"{{ "size": [96, 80], "method": "{method}" }}"#),
            );
            let (shown, last) = stages(&renderer, &plan, &Options::default());
            let distances: Vec<f64> = shown
                .iter()
                .map(|(picture, _)| distance(picture, &last))
                .collect();
            let numbers: Vec<_> = shown
                .iter()
                .map(|(_, s)| (s.number, s.stride, s.steps))
                .collect();
            assert_eq!(numbers, [(1, 4, 4), (2, 2, 1), (3, 1, 1)]);
            println!("{phantom:?}, {method}: {distances:?}");
            assert!(distances[1] < distances[0], "{distances:?}");
            assert_eq!(distances[2], 0.0);
        }
    }
}

#[test]
fn it_ends_where_it_is_told_to() {
    let volume = Phantom::Shells.volume([40; 3]).unwrap();
    let renderer = Renderer::new(&volume);
    let plan = plan(&volume, r#"{ "size": [64, 48] }"#);
    let options = Options {
        tile: 4,
        threads: 2,
        ..Options::default()
    };
    for stop in 1..=3 {
        let mut shown = 0;
        let result = renderer.refine(&plan, &options, &Control::NONE, &mut |_, _| {
            shown += 1;
            if shown == stop {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        assert!(matches!(result, Err(Error::Cancelled)));
        assert_eq!(shown, stop);
    }
    // In the middle of a stage; tiles are counted over all of them.
    let shares = Arc::new(Mutex::new(Vec::new()));
    let of_control = shares.clone();
    let all = Control::listening(move |work, share| {
        if work == Work::Drawing {
            of_control.lock().unwrap().push(share);
        }
        ControlFlow::Continue(())
    });
    renderer
        .refine(&plan, &options, &all, &mut |_, _| ControlFlow::Continue(()))
        .unwrap();
    let mut shares = shares.lock().unwrap();
    shares.sort_unstable_by(f64::total_cmp);
    let total = shares.len() as f64;
    let expected: Vec<_> = (1..=shares.len()).map(|n| n as f64 / total).collect();
    assert_eq!(*shares, expected);
    for after in [1, 20, 60] {
        let calls = Arc::new(AtomicUsize::new(0));
        let control = ending_after(after - 1, &calls);
        let mut shown = 0;
        let result = renderer.refine(&plan, &options, &control, &mut |_, _| {
            shown += 1;
            ControlFlow::Continue(())
        });
        assert!(matches!(result, Err(Error::Cancelled)));
        assert!(shown < 3 && calls.load(Ordering::Relaxed) <= after + 2);
    }
}

#[test]
fn a_coarser_plan_shows_the_same() {
    let volume = Phantom::Shells.volume([48; 3]).unwrap();
    let renderer = Renderer::new(&volume);
    let plan = plan(&volume, r#"{ "size": [80, 60], "early_termination": 0 }"#);
    let draw = |plan: &Plan| {
        renderer
            .render(plan, &Options::default(), &Control::NONE)
            .unwrap()
    };
    let (full, coarse) = (draw(&plan), draw(&plan.coarser(2)));
    assert_eq!([coarse.image.width(), coarse.image.height()], [40, 30]);
    let share = coarse.stats.counts.unwrap().lattice_points as f64
        / full.stats.counts.unwrap().lattice_points as f64;
    assert!((share - 0.125).abs() < 0.004, "{share} of the samples");
    // Means of blocks of 2 × 2 are about what the coarse picture shows.
    let mut off = 0.0;
    for y in 0..30 {
        for x in 0..40 {
            for c in 0..3 {
                let at = |i: u32, j: u32| full.image.pixel(2 * x + i, 2 * y + j)[c];
                let mean = (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)) / 4.0;
                off += f64::from((mean - coarse.image.pixel(x, y)[c]).abs()) / 3600.0;
            }
        }
    }
    assert!(off < 0.02, "{off}");
    // No picture is smaller than a pixel, and a rule of sampling stays.
    let mut tiny = plan.coarser(1000);
    assert_eq!((tiny.width, tiny.height), (1, 1));
    tiny.sampling = Sampling::Refine { parts: 2 };
    tiny.compositing = Compositing::Display;
    assert_eq!(tiny.coarser(2).sampling, tiny.sampling);
}
