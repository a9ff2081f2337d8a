//! Figures of the document: geometric ones exactly, those of its unpublished jaw as trends.

use crate::{draw, jaw_spec, small_jaw};
use strahl_sim::spec::{MemoryModel, Optimisation, Order, Projection, RowRule, Spec};
use strahl_sim::{VolumeStore, jaw};

fn brute_force(rule: RowRule) -> Spec {
    let mut spec = jaw_spec();
    spec.optimisation = Optimisation::none();
    spec.memory.row_rule = rule;
    spec
}

fn thesis(mut spec: Spec) -> Spec {
    spec.memory.row_rule = RowRule::Thesis;
    spec
}

#[test]
fn brute_force_from_the_front_as_printed() {
    let drawn = draw(&brute_force(RowRule::Thesis), &small_jaw());
    let c = drawn.counters;
    assert_eq!(drawn.size, [128, 64]);
    assert_eq!(
        (c.samples, c.reads, c.thesis_row_changes),
        (1 << 20, 1 << 20, 1024)
    );
    let rate = c.frames_per_second(100.0);
    assert_eq!(format!("{rate:.2}"), "94.54");
    assert_eq!(rate.round(), 95.0);
    // All at the first pixel of each tile (the lowest row of the picture begins the raster).
    for (i, changes) in drawn.thesis_changes_of_pixel.iter().enumerate() {
        let (x, y) = (i % 128, 63 - i / 128);
        assert_eq!(*changes, if x % 8 == 0 && y % 8 == 0 { 8 } else { 0 });
    }
}

#[test]
fn brute_force_of_the_large_jaw_as_printed() {
    let volume = VolumeStore::new(&jaw([256, 256, 128]).unwrap()).unwrap();
    let c = draw(&brute_force(RowRule::Thesis), &volume).counters;
    assert_eq!((c.reads, c.thesis_row_changes), (1 << 23, 8192));
    assert_eq!(format!("{:.1}", c.frames_per_second(100.0)), "11.8");
}

#[test]
fn with_all_eight_neighbours_other_rows_count() {
    let c = draw(&brute_force(RowRule::Exact), &small_jaw()).counters;
    assert_eq!((c.row_stalls, c.row_changes), (3795, 11_856));
    assert_eq!(format!("{:.1}", c.frames_per_second(100.0)), "92.4");
    // Utilisation of 8×8 and 16×16 rays: 97 and 99 %.
    assert_eq!((100.0 * c.utilisation()).round(), 97.0);
    let mut spec = brute_force(RowRule::Exact);
    spec.queue.bundle = [16, 16];
    let c = draw(&spec, &small_jaw()).counters;
    assert_eq!((100.0 * c.utilisation()).round(), 99.0);
    spec.queue.bundle = [4, 4];
    assert!(draw(&spec, &small_jaw()).counters.utilisation() < 0.95);
    spec.queue.bundle = [32, 32];
    assert!(draw(&spec, &small_jaw()).counters.utilisation() < 0.95);
}

#[test]
fn sorting_brings_row_changes_back_to_those_of_brute_force() {
    let volume = small_jaw();
    let sorted = draw(&thesis(jaw_spec()), &volume).counters;
    let mut spec = thesis(jaw_spec());
    spec.queue.order = Order::RoundRobin;
    let unsorted = draw(&spec, &volume).counters;
    let factor = sorted.thesis_row_changes as f64 / 1024.0;
    assert!((0.9..1.1).contains(&factor), "{factor}");
    assert!(unsorted.thesis_row_changes >= 5 * sorted.thesis_row_changes);
    assert!(sorted.frames_per_second(100.0) > 1.1 * unsorted.frames_per_second(100.0));
}

#[test]
fn row_changes_stay_rare_at_every_angle() {
    let volume = small_jaw();
    for angle in (0..=90).step_by(10) {
        let mut spec = thesis(jaw_spec());
        spec.view.rotate_z_deg = f64::from(angle);
        let c = draw(&spec, &volume).counters;
        assert!(
            c.thesis_changes_per_read() < 0.004,
            "{angle}°: {}",
            c.thesis_changes_per_read()
        );
    }
}

#[test]
fn a_linear_memory_opens_a_row_for_every_other_word() {
    let mut spec = brute_force(RowRule::Exact);
    spec.memory.model = MemoryModel::M1Linear;
    // From the side, where the document's bound is met by brute force.
    spec.view.rotate_z_deg = 90.0;
    let c = draw(&spec, &small_jaw()).counters;
    let words = c.reads + c.frozen_for_words;
    let share = c.row_changes as f64 / words as f64;
    assert!((0.5..0.52).contains(&share), "{share}");
    spec.memory.model = MemoryModel::M1Interleaved;
    let c = draw(&spec, &small_jaw()).counters;
    assert!((c.row_changes as f64) < 0.004 * (c.reads + c.frozen_for_words) as f64);
}

#[test]
fn twice_the_size_costs_less_than_eight_times() {
    let large = VolumeStore::new(&jaw([256, 256, 128]).unwrap()).unwrap();
    let rate = |volume| {
        draw(&thesis(jaw_spec()), volume)
            .counters
            .frames_per_second(100.0)
    };
    let factor = rate(&small_jaw()) / rate(&large);
    assert!((4.8..6.5).contains(&factor), "{factor}");
}

#[test]
fn perspective_sends_four_times_the_rays_and_reads_less_than_twice() {
    let volume = small_jaw();
    let parallel = draw(&thesis(jaw_spec()), &volume);
    let mut spec = thesis(jaw_spec());
    spec.view.projection = Projection::Perspective {
        angle_deg: 53.130_102_354_155_98,
    };
    let perspective = draw(&spec, &volume);
    assert_eq!(perspective.size, [256, 128]);
    let (p, q) = (parallel.counters, perspective.counters);
    assert!(q.rays as f64 > 3.8 * p.rays as f64);
    assert!(q.reads < 2 * p.reads, "{} against {}", q.reads, p.reads);
}

#[test]
fn too_few_bits_of_length_are_refused() {
    let volume = crate::volume_of([1024, 2, 2], vec![0; 4096]);
    let mut spec = Spec::default();
    spec.view.rotate_z_deg = 90.0;
    let message = strahl_sim::Frame::new(&spec, &volume)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("widths.length is 10")
            && message.contains("1024")
            && message.contains("11 bits"),
        "{message}"
    );
    spec.widths.length = 11;
    let message = strahl_sim::Frame::new(&spec, &volume)
        .unwrap_err()
        .to_string();
    assert!(message.contains("widths.key is 10"), "{message}");
    spec.widths.key = 11;
    assert_eq!(draw(&spec, &volume).counters.samples, 4096);
}
