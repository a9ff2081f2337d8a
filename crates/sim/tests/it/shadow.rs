//! Shadows: against sums of real numbers, and against themselves on other machines.

use crate::{draw, jaw_spec, small_jaw, volume_of};
use proptest::prelude::*;
use strahl_sim::spec::{
    Bend, Handover, Leaping, Optimisation, Order, Projection, Scheduling, Shading, Shadow, Spec,
};
use strahl_sim::{Frame, VolumeStore};

fn unlit(shadow: Shadow) -> Spec {
    let mut spec = Spec {
        shadow,
        optimisation: Optimisation::none(),
        ..Spec::default()
    };
    spec.look.opacity = vec![[0.0, 0.0], [255.0, 1.0]];
    spec.look.shading = Shading::Unlit;
    spec.look.gradient_weighting = false;
    spec
}

fn random_volume(dims: [usize; 3], seed: &[u8], least: u8) -> VolumeStore {
    let count = dims.iter().product();
    let voxels = (0..count).map(|i| {
        let value = seed[(i * 31 + i / 7) % seed.len()];
        value.saturating_sub(least)
    });
    volume_of(dims, voxels.collect())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// From the front samples are voxels: light along every row, then every ray through what is lit.
    #[test]
    fn light_is_what_passes_through_the_row(
        seed in prop::collection::vec(any::<u8>(), 101), width in 2usize..40, is_right in any::<bool>(),
    ) {
        let dims = [width, 9, 11];
        let volume = random_volume(dims, &seed, 190);
        let spec = unlit(if is_right { Shadow::FromRight } else { Shadow::FromLeft });
        let drawn = draw(&spec, &volume);
        let opacity = |x: usize, y: usize, z: usize| f64::from(volume.words[x + width * (y + 9 * z)]) / 255.0;
        for z in 0..11 {
            for x in 0..width {
                let (mut light, mut passing) = (0.0, 1.0);
                for y in 0..9 {
                    let before = if is_right { x + 1..width } else { 0..x };
                    let arriving: f64 = before.map(|x| 1.0 - opacity(x, y, z)).product();
                    light += passing * opacity(x, y, z) * arriving;
                    passing *= 1.0 - opacity(x, y, z);
                }
                let got = f64::from(drawn.picture[(10 - z) * width + x]);
                // A word of 8 bits for the light, cut off.
                prop_assert!((got - light).abs() < 2.5 / 255.0, "{} for {} at {} {}", got, light, x, z);
            }
        }
        let c = drawn.counters;
        prop_assert_eq!((c.light_reads, c.light_samples, c.reads), (c.samples, c.samples, c.samples));
        prop_assert_eq!(c.clocks, c.reads + c.light_reads + c.bubbles() + c.frozen());
    }

    /// The same bytes on any machine and with leaping, parallel and perspective, from any angle.
    #[test]
    fn shadows_do_not_depend_on_the_machine(
        seed in prop::collection::vec(any::<u8>(), 101), dims in prop::array::uniform3(2usize..24),
        bundle in prop::array::uniform2(1u32..12), turn in -180.0f64..180.0, tilt in -60.0f64..60.0,
        is_perspective in any::<bool>(), is_right in any::<bool>(), handover in 0usize..3, order in 0usize..3,
        window in prop::option::of(1u32..20), threshold in prop::option::of(0.01f64..0.3), post in any::<bool>(),
    ) {
        let volume = random_volume(dims, &seed, 200);
        let mut spec = unlit(if is_right { Shadow::FromRight } else { Shadow::FromLeft });
        spec.view.rotate_z_deg = turn;
        spec.view.rotate_x_deg = tilt;
        if is_perspective {
            spec.view.projection = Projection::Perspective { angle_deg: 60.0 };
        }
        if post {
            spec.look.classification = strahl_sim::spec::Classification::Post;
        }
        spec.optimisation.termination_threshold = threshold.unwrap_or(0.0);
        let plain = draw(&spec, &volume);
        spec.optimisation.leaping = Leaping::Safe;
        spec.queue.bundle = bundle;
        spec.queue.handover = [Handover::WhenEmpty, Handover::WhenDone, Handover::Serial][handover];
        spec.queue.order = [Order::PlaneDistance, Order::RemainingLength, Order::RoundRobin][order];
        if let Some(window) = window {
            spec.queue.scheduling = Scheduling::ReadyRowFirst { window };
        }
        let other = draw(&spec, &volume);
        prop_assert!(other.picture == plain.picture);
        let (a, b) = (plain.counters, other.counters);
        prop_assert_eq!((a.samples, a.light_samples), (b.samples, b.light_samples));
        if threshold.is_none() {
            // With it, how many come too late depends on the machine.
            prop_assert!(b.light_reads <= a.light_reads);
        }
        prop_assert_eq!(b.clocks, b.reads + b.light_reads + b.bubbles() + b.frozen());
    }
}

#[test]
fn shadows_halve_the_rate_of_brute_force() {
    let volume = small_jaw();
    let mut spec = jaw_spec();
    spec.optimisation = Optimisation::none();
    let without = draw(&spec, &volume).counters;
    spec.shadow = Shadow::FromLeft;
    let with = draw(&spec, &volume).counters;
    assert_eq!(with.light_reads, with.reads);
    let factor = with.clocks as f64 / without.clocks as f64;
    assert!((1.95..2.2).contains(&factor), "{factor}");
    // Leaping and early ends are worth as much in the light pass.
    spec.optimisation = Optimisation::default();
    let leapt = draw(&spec, &volume).counters;
    assert!(leapt.light_reads < with.light_reads * 2 / 3);
}

#[test]
fn what_light_cannot_cross_is_refused() {
    let volume = small_jaw();
    type Change = fn(&mut Spec);
    let cases: [(Change, &str); 6] = [
        (|s| s.queue.pipelines = 2, "queue.pipelines is 2"),
        (|s| s.queue.handover = Handover::Refill, "queue.handover"),
        (
            |s| s.optimisation.leaping = Leaping::Document,
            "optimisation.leaping is document",
        ),
        (
            |s| s.optimisation.adaptive_error = 1,
            "optimisation.adaptive_error is 1",
        ),
        (|s| s.merge.boards = 2, "merge is set"),
        (
            |s| {
                s.bend = Bend::Twist { deg_per_plane: 1.0 };
                s.optimisation.leaping = Leaping::Off;
            },
            "bend is set",
        ),
    ];
    for (change, words) in cases {
        let mut spec = unlit(Shadow::FromLeft);
        change(&mut spec);
        let message = Frame::new(&spec, &volume).unwrap_err().to_string();
        assert!(message.contains(words), "{words}: {message}");
    }
}
