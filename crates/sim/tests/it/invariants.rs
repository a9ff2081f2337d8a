//! What must hold for every machine: clocks and samples add up, pictures do not depend on order.

use crate::{draw, jaw_spec, small_jaw, volume_of};
use proptest::prelude::*;
use std::ops::ControlFlow;
use strahl_sim::observer::{Observer, Wires};
use strahl_sim::spec::{
    DistanceMemory, Handover, Leaping, Optimisation, Order, Scheduling, Timing,
};
use strahl_sim::{Frame, NoObserver, Run, Spec, run};

fn adds_up(drawn: &Run, pipelines: u32) {
    let c = &drawn.counters;
    let n = u64::from(pipelines);
    assert_eq!(
        n * c.clocks,
        c.reads + c.bubbles() + n * c.frozen(),
        "{c:?}"
    );
    assert_eq!(c.reads, c.sample_reads + c.distance_only_reads);
    assert_eq!(
        c.samples,
        c.reads + c.skipped_by_leaping + c.skipped_by_termination + c.skipped_by_adaptive_sampling,
        "{c:?}"
    );
    assert!(drawn.is_complete);
}

fn orders() -> impl Strategy<Value = Order> {
    prop_oneof![
        Just(Order::PlaneDistance),
        Just(Order::RemainingLength),
        Just(Order::RoundRobin)
    ]
}

fn handovers() -> impl Strategy<Value = Handover> {
    prop_oneof![
        Just(Handover::WhenEmpty),
        Just(Handover::WhenDone),
        Just(Handover::Serial),
        Just(Handover::Refill),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Any machine draws the picture that the plainest one draws, and its counts add up.
    #[test]
    fn the_picture_does_not_depend_on_the_machine(
        dims in prop::array::uniform3(2usize..28),
        seed in prop::collection::vec(any::<u8>(), 101),
        bundle in prop::array::uniform2(1u32..12),
        order in orders(), handover in handovers(),
        window in prop::option::of(1u32..20),
        angle in 0.0f64..360.0, waits in any::<bool>(), memory in 1u32..9, refresh in any::<bool>(),
        adaptive in 0u32..3, pipelines in 1u32..4, ports in 1u32..3,
    ) {
        let count = dims.iter().product();
        let voxels = (0..count).map(|i| seed[(i * 7 + i / 5) % seed.len()].saturating_sub(150)).collect();
        let volume = volume_of(dims, voxels);
        let mut spec = Spec::default();
        spec.look.opacity = vec![[0.0, 0.0], [100.0, 0.5]];
        spec.view.rotate_z_deg = angle;
        spec.optimisation.adaptive_error = adaptive;
        let mut plain = spec.clone();
        plain.queue.bundle = [1, 1];
        let expected = draw(&plain, &volume);
        adds_up(&expected, 1);
        spec.queue.bundle = bundle;
        spec.queue.pipelines = pipelines;
        spec.memory.ports = ports;
        spec.queue.order = order;
        spec.queue.handover = handover;
        if let Some(window) = window {
            spec.queue.scheduling = Scheduling::ReadyRowFirst { window };
        }
        spec.host.is_waited_for = waits;
        spec.latency.memory = memory;
        if memory % 3 == 0 {
            // News of ended rays that come when their tile is long done.
            spec.latency.terminate = 60;
        }
        if memory % 2 == 1 {
            spec.memory.distance_store = DistanceMemory::Sdram;
        }
        if refresh {
            spec.memory.timing = Timing { refresh_interval: 100, refresh: 7, longest_open: 500, ..Timing::default() };
        }
        let drawn = draw(&spec, &volume);
        adds_up(&drawn, pipelines);
        // With somebody looking on, every word is made in its clock by one thread; without, what rays look like is computed
        // ahead by all: nothing that is counted differs.
        let watched = run(&Frame::new(&spec, &volume).unwrap(), &mut Watch::default(), &strahl_sim::no_progress).unwrap();
        prop_assert_eq!(watched.counters, drawn.counters);
        prop_assert!(watched.picture == drawn.picture && watched.passing == drawn.passing);
        prop_assert!(watched.ended_early == drawn.ended_early);
        prop_assert_eq!(watched.stalls_of_pixel, &drawn.stalls_of_pixel[..]);
        prop_assert_eq!(watched.thesis_changes_of_pixel, &drawn.thesis_changes_of_pixel[..]);
        prop_assert!(drawn.picture == expected.picture);
        prop_assert!(drawn.ended_early == expected.ended_early);
        prop_assert_eq!(drawn.counters.samples, expected.counters.samples);
    }
}

/// All looks, directions and kinds of leaping: words made in their clock by one thread, or values computed ahead by one, two
/// and five threads, are the same pictures and counts.
#[test]
fn counts_do_not_depend_on_threads() {
    use strahl_sim::spec::{Bend, Classification, Projection, Reconstruction};
    let volume = small_jaw();
    type Change = fn(&mut Spec);
    let changes: [Change; 8] = [
        |_| (),
        |s| s.optimisation = Optimisation::none(),
        |s| s.view.projection = Projection::Perspective { angle_deg: 53.0 },
        |s| s.optimisation.leaping = Leaping::Document,
        |s| s.optimisation.adaptive_error = 4,
        |s| {
            s.look.classification = Classification::PreIntegrated;
            s.optimisation.leaping = Leaping::Off;
        },
        |s| {
            s.bend = Bend::Twist { deg_per_plane: 0.5 };
            s.optimisation.leaping = Leaping::Off;
            s.look.reconstruction = Reconstruction::Nearest;
        },
        |s| {
            s.queue.pipelines = 3;
            s.queue.handover = Handover::Refill;
        },
    ];
    for (i, change) in changes.into_iter().enumerate() {
        let mut spec = jaw_spec();
        spec.view.rotate_z_deg = 20.0;
        change(&mut spec);
        let frame = Frame::new(&spec, &volume).unwrap();
        let watched = run(&frame, &mut Watch::default(), &strahl_sim::no_progress).unwrap();
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let drawn = pool
                .build()
                .unwrap()
                .install(|| run(&frame, &mut NoObserver, &strahl_sim::no_progress).unwrap());
            assert_eq!(drawn.counters, watched.counters, "{i}, {threads} threads");
            assert!(drawn.picture == watched.picture, "{i}, {threads} threads");
            assert!(drawn.stalls_of_pixel == watched.stalls_of_pixel);
        }
    }
}

/// One ray alone: 5 clocks from read to read, plus parameter RAM and sort register.
#[test]
fn a_single_ray_uses_every_seventh_clock() {
    let volume = volume_of([2, 101, 2], vec![0; 404]);
    let mut spec = Spec::default();
    spec.queue.bundle = [1, 1];
    spec.optimisation = Optimisation::none();
    spec.queue.handover = Handover::WhenDone;
    let c = draw(&spec, &volume).counters;
    assert_eq!(c.reads, 4 * 101);
    let utilisation = c.reads as f64 / (c.clocks - c.frozen()) as f64;
    assert!((0.13..1.0 / 7.0).contains(&utilisation), "{utilisation}");
    spec.latency.parameter = 0;
    spec.latency.sort = 0;
    let c = draw(&spec, &volume).counters;
    let utilisation = c.reads as f64 / (c.clocks - c.frozen()) as f64;
    assert!((0.18..1.0 / 5.0).contains(&utilisation), "{utilisation}");
}

/// Keeps when every ray is read and where its words are.
#[derive(Default)]
struct Watch {
    issued: Vec<(u64, u16)>,
    data: Vec<(u64, u16)>,
    sample: Vec<(u64, u16)>,
    lit: Vec<(u64, u16)>,
    unfrozen: u64,
}

impl Observer for Watch {
    fn clock(&mut self, w: &Wires) {
        let at = self.unfrozen;
        self.issued.extend(w.issue.map(|r| (at, r.slot.0)));
        self.data.extend(w.data.map(|r| (at, r.slot.0)));
        self.sample.extend(w.sample.map(|s| (at, s.slot.0)));
        self.lit.extend(w.lit.map(|l| (at, l.slot.0)));
        self.unfrozen += 1;
    }
}

#[test]
fn words_take_the_clocks_of_the_spec() {
    let volume = small_jaw();
    let mut spec = jaw_spec();
    spec.optimisation = Optimisation::none();
    let mut watch = Watch::default();
    run(
        &Frame::new(&spec, &volume).unwrap(),
        &mut watch,
        &|drawn, _| {
            if drawn > 2 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        },
    )
    .unwrap();
    let l = spec.latency;
    let later = |words: &[(u64, u16)], clocks: u32| {
        assert!(words.len() > 1000);
        for (issued, word) in watch.issued.iter().zip(words) {
            assert_eq!((issued.0 + u64::from(clocks), issued.1), *word);
        }
    };
    let read = l.parameter + l.memory;
    later(&watch.data, read);
    later(&watch.sample, read + 3 * l.lerp);
    later(
        &watch.lit,
        read + 3 * l.lerp + l.classify + l.absorb + l.shade,
    );
}

#[test]
fn a_stopped_run_has_what_was_drawn() {
    let volume = small_jaw();
    let frame = Frame::new(&jaw_spec(), &volume).unwrap();
    let stop = |drawn, _| {
        if drawn == 10 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let part = run(&frame, &mut NoObserver, &stop).unwrap();
    assert!(!part.is_complete);
    assert_eq!(part.counters.tiles, 10);
    let whole = draw(&jaw_spec(), &volume);
    let lowest_rows = 128 * 56..;
    let same = part.picture[lowest_rows.clone()]
        .iter()
        .zip(&whole.picture[lowest_rows]);
    assert!(same.filter(|(a, b)| a == b).count() > 600);
}

/// More rays than tiles need, a picture that is no multiple of a tile, a volume that fills the memory's corner.
#[test]
fn volumes_and_tiles_of_odd_sizes() {
    let volume = volume_of([5, 3, 7], (0..105).map(|i| i as u8 * 2).collect());
    for bundle in [[8, 8], [3, 2], [64, 64]] {
        let mut spec = Spec::default();
        spec.queue.bundle = bundle;
        spec.optimisation.leaping = Leaping::Off;
        spec.optimisation.termination_threshold = 0.0;
        let drawn = draw(&spec, &volume);
        assert_eq!(drawn.size, [5, 7]);
        assert_eq!(drawn.counters.reads, 105);
        adds_up(&drawn, 1);
    }
}

#[test]
fn a_moving_picture_has_an_eighth_of_the_samples() {
    let volume = small_jaw();
    let mut spec = jaw_spec();
    spec.optimisation = Optimisation::none();
    let still = draw(&spec, &volume).counters.samples;
    spec.view.is_moving = true;
    let moving = draw(&spec, &volume);
    assert_eq!(moving.size, [64, 32]);
    // The lattice of every second plane and pixel.
    assert_eq!(8 * moving.counters.samples, still);
}

#[test]
fn nearest_shows_the_voxel_and_not_what_is_between() {
    // Two voxels per axis, one of them opaque; rays a quarter of a voxel apart.
    let volume = volume_of([2, 2, 2], vec![0, 255, 0, 255, 0, 255, 0, 255]);
    let mut spec = Spec::default();
    spec.look.opacity = vec![[0.0, 0.0], [255.0, 1.0]];
    spec.look.shading = strahl_sim::spec::Shading::Unlit;
    spec.look.gradient_weighting = false;
    spec.view.pixel = 0.25;
    spec.look.reconstruction = strahl_sim::spec::Reconstruction::Nearest;
    let nearest = draw(&spec, &volume);
    assert!(
        nearest.picture.iter().all(|p| *p == 0.0 || *p > 0.99),
        "{:?}",
        nearest.picture
    );
    spec.look.reconstruction = strahl_sim::spec::Reconstruction::Trilinear;
    let trilinear = draw(&spec, &volume);
    assert!(trilinear.picture.iter().any(|p| (0.1..0.9).contains(p)));
}

#[test]
fn leaping_over_homogeneous_places_reads_less_and_loses_absorption_only() {
    // A uniform slab before a wall: with weighting by the gradient only the wall is seen, through the slab or not.
    let voxels = (0..8 * 40 * 8).map(|i| match i / 8 % 40 {
        2..30 => 40,
        34.. => 200,
        _ => 0,
    });
    let volume = volume_of([8, 40, 8], voxels.collect());
    let mut spec = Spec::default();
    spec.look.opacity = vec![[0.0, 0.0], [255.0, 0.5]];
    spec.optimisation.termination_threshold = 0.0;
    let exact = draw(&spec, &volume);
    spec.optimisation.leap_homogeneous = true;
    let leapt = draw(&spec, &volume);
    assert!(leapt.counters.reads < exact.counters.reads);
    let sum = |run: &Run| run.picture.iter().sum::<f32>();
    assert!(sum(&leapt) > sum(&exact), "less is absorbed");
}

#[test]
fn one_white_material_is_the_grey_picture_and_colours_are_in_their_channels() {
    use strahl_sim::spec::{Classification, Material};
    let volume = small_jaw();
    let mut spec = jaw_spec();
    spec.look.classification = Classification::Post;
    spec.look.phong = [0.0, 1.0, 0.0];
    let grey = draw(&spec, &volume);
    let material = |color| Material {
        value: 0.0,
        color,
        ambient: 0.0,
        diffuse: 1.0,
        specular: 0.0,
    };
    spec.look.materials = vec![material([1.0, 1.0, 1.0])];
    let white = draw(&spec, &volume);
    assert_eq!(white.counters, grey.counters);
    for (a, b) in white.color.as_ref().unwrap().iter().zip(&grey.picture) {
        assert!(a.iter().all(|c| (c - b).abs() < 0.004), "{a:?} {b}");
    }
    spec.look.materials = vec![material([1.0, 0.5, 0.0])];
    let orange = draw(&spec, &volume);
    for (a, b) in orange.color.unwrap().iter().zip(&grey.picture) {
        assert!(
            (a[0] - b).abs() < 0.004 && (a[1] - 0.5 * b).abs() < 0.01 && a[2] == 0.0,
            "{a:?} {b}"
        );
    }
}
