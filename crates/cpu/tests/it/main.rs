//! What a caller of the renderer sees beside the picture: progress, cancelling, refusals, statistics.

mod refine;
mod sampling;

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use strahl_cpu::{Error, Options, Renderer};
use strahl_scene::{Scene, plan::Plan, resolve};
use strahl_volume::{Control, Volume, Work, phantom::Phantom};

fn shells() -> (Volume, Plan) {
    let volume = Phantom::Shells.volume([64; 3]).unwrap();
    let scene = Scene {
        size: Some([40, 30]),
        ..Scene::default()
    };
    let plan = resolve(&scene, &volume.header(), None).unwrap();
    (volume, plan)
}

fn options(threads: usize, tile: u32) -> Options {
    Options {
        threads,
        tile,
        ..Options::default()
    }
}

#[test]
fn progress_counts_every_tile_once() {
    let (volume, plan) = shells();
    for (threads, tile, tiles) in [(1, 8, 20), (7, 8, 20), (2, 7, 30), (1, 100, 1)] {
        let calls = Arc::new(Mutex::new(Vec::new()));
        let of_control = calls.clone();
        let control = Control::listening(move |work, share| {
            if work == Work::Drawing {
                of_control.lock().unwrap().push(share);
            }
            ControlFlow::Continue(())
        });
        let rendered = Renderer::new(&volume)
            .render(&plan, &options(threads, tile), &control)
            .unwrap();
        assert_eq!(rendered.stats.threads, threads);
        let mut calls = calls.lock().unwrap();
        // Threads may call out of order.
        calls.sort_unstable_by(f64::total_cmp);
        let share = |drawn| f64::from(drawn) / f64::from(tiles);
        let expected: Vec<_> = (1..=tiles).map(share).collect();
        assert_eq!(*calls, expected, "{threads} threads, tiles of {tile}");
    }
}

#[test]
fn a_break_ends_the_picture_soon() {
    let (volume, plan) = shells();
    let calls = Arc::new(AtomicUsize::new(0));
    let control = ending_after(3, &calls);
    let threads = 2;
    let error = Renderer::new(&volume)
        .render(&plan, &options(threads, 1), &control)
        .unwrap_err();
    assert!(matches!(error, Error::Cancelled), "{error}");
    // Each thread may be in the middle of a tile; of the 1200 no other is begun.
    assert!(calls.load(Ordering::Relaxed) <= 3 + threads);
}

/// Control that ends drawing once more than `most` parts are drawn, which it counts in `calls`.
fn ending_after(most: usize, calls: &Arc<AtomicUsize>) -> Control {
    let calls = calls.clone();
    Control::listening(move |work, _| match work {
        Work::Drawing if calls.fetch_add(1, Ordering::Relaxed) >= most => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    })
}

#[test]
fn a_plan_of_another_volume_is_refused() {
    let (volume, plan) = shells();
    let other = Phantom::Shells.volume([65; 3]).unwrap();
    let error = Renderer::new(&other)
        .render(&plan, &Options::default(), &Control::NONE)
        .unwrap_err();
    let message = error.to_string();
    assert!(
        message.contains("[64, 64, 64]") && message.contains("[65, 65, 65]"),
        "{message}"
    );
    Renderer::new(&volume)
        .render(&plan, &Options::default(), &Control::NONE)
        .unwrap();
}

#[test]
fn steps_that_cannot_be_counted_and_tiles_of_nothing_are_refused() {
    let (volume, mut plan) = shells();
    let error = Renderer::new(&volume)
        .render(&plan, &options(0, 0), &Control::NONE)
        .unwrap_err();
    assert!(matches!(error, Error::NoTile));
    plan.lattice.step_mm = 1e-6;
    let error = Renderer::new(&volume)
        .render(&plan, &Options::default(), &Control::NONE)
        .unwrap_err();
    let Error::StepTooShort { least_mm, .. } = error else {
        panic!("{error}");
    };
    // What the message says is enough.
    assert!(least_mm > 1e-6 && least_mm < 1e-4);
}

#[test]
fn statistics_add_up() {
    let (volume, plan) = shells();
    let draw = |skip| {
        let options = Options {
            skip,
            ..Options::default()
        };
        let rendered = Renderer::new(&volume).render(&plan, &options, &Control::NONE);
        rendered.unwrap().stats.counts.unwrap()
    };
    let (all, some) = (draw(false), draw(true));
    assert_eq!(all.rays, 40 * 30);
    assert!(all.rays_in_volume > 0 && all.rays_in_volume <= all.rays);
    assert!(all.samples <= all.lattice_points && all.samples_visible <= all.samples);
    assert_eq!(all.points_skipped, 0);
    assert!(some.points_skipped > 0 && some.samples < all.samples);
    let same = |counts: &strahl_cpu::Counts| {
        (
            counts.rays_in_volume,
            counts.rays_ended_early,
            counts.lattice_points,
            counts.samples_visible,
        )
    };
    assert_eq!(same(&all), same(&some));
    let skipped_mm = some.points_skipped as f64 * plan.lattice.step_mm;
    assert!((some.skipped_mm - skipped_mm).abs() < 1e-9 * skipped_mm);
}

#[test]
fn every_rule_that_may_leaves_points_out() {
    let volume = Phantom::Tree.volume([64; 3]).unwrap();
    for method in ["emission-absorption", "mip", "minip", "first-hit"] {
        let scene = format!(r#"{{ "size": [40, 30], "method": "{method}" }}"#);
        let scene = Scene::parse("scene", &scene).unwrap();
        let plan = resolve(&scene, &volume.header(), None).unwrap();
        let stats = Renderer::new(&volume)
            .render(&plan, &Options::default(), &Control::NONE)
            .unwrap()
            .stats;
        let counts = stats.counts.unwrap();
        let share = counts.points_skipped as f64 / counts.lattice_points as f64;
        assert!(share > 0.25, "{method}: {share}");
    }
}
