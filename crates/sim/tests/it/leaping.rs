//! Leaping may not change a picture, and the document's rule does.

use crate::{draw, jaw_spec, small_jaw, volume_of};
use proptest::prelude::*;
use strahl_sim::Spec;
use strahl_sim::spec::{Classification, DistanceMemory, Engine, Leaping, Optimisation, Projection};

fn spec(leaping: Leaping, block: u32) -> Spec {
    let mut spec = Spec {
        optimisation: Optimisation {
            leaping,
            distance_block: block,
            ..Optimisation::none()
        },
        ..Spec::default()
    };
    spec.look.opacity = vec![[0.0, 0.0], [200.0, 0.4]];
    spec.look.gradient_weighting = false;
    spec
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Any sparse volume from anywhere, by either size of cells, parallel and perspective, both places of
    /// classification: the same bytes as without.
    #[test]
    fn safe_leaping_changes_no_pixel(
        dims in prop::array::uniform3(3usize..24),
        seed in prop::collection::vec(0u16..400, 97),
        angle in -180.0f64..180.0, tilt in -60.0f64..60.0, step in 0.3f64..1.7,
        block in 1u32..3, perspective in any::<bool>(), post in any::<bool>(),
    ) {
        let count = dims.iter().product();
        let voxels = (0..count).map(|i| seed[(i * 31 + i / 7) % seed.len()].saturating_sub(380) as u8 * 12).collect();
        let volume = volume_of(dims, voxels);
        let mut pictures = Vec::new();
        for leaping in [Leaping::Off, Leaping::Safe] {
            let mut spec = spec(leaping, block);
            spec.view.rotate_z_deg = angle;
            spec.view.rotate_x_deg = tilt;
            spec.view.step = step;
            if perspective {
                spec.view.projection = Projection::Perspective { angle_deg: 60.0 };
            }
            if post {
                spec.look.classification = Classification::Post;
            }
            pictures.push(draw(&spec, &volume).picture);
        }
        prop_assert!(pictures[0] == pictures[1]);
    }
}

/// A wall one voxel thick at y = 9. Three voxels before it, the document's distance is 3, and a ray that leaps them from
/// y = 6.5 lands at 9.5: it never samples between 8 and 9, where the wall already shows.
#[test]
fn the_documents_rule_leaps_over_the_near_side_of_a_wall() {
    let dims = [8, 24, 8];
    let voxels = (0..8 * 24 * 8)
        .map(|i| if i / 8 % 24 == 9 { 200 } else { 0 })
        .collect();
    let volume = volume_of(dims, voxels);
    let at = |leaping| {
        let mut spec = spec(leaping, 1);
        spec.look.opacity = vec![[0.0, 0.0], [200.0, 1.0]];
        spec.view.rotate_z_deg = 20.0;
        draw(&spec, &volume)
    };
    let (off, safe, document) = (at(Leaping::Off), at(Leaping::Safe), at(Leaping::Document));
    assert_eq!(off.picture, safe.picture);
    assert_ne!(off.picture, document.picture);
    assert!(safe.counters.reads < off.counters.reads);
}

#[test]
fn early_termination_is_wrong_by_at_most_the_threshold() {
    let volume = small_jaw();
    let mut spec = jaw_spec();
    spec.optimisation = Optimisation::none();
    let exact = draw(&spec, &volume);
    for threshold in [0.01, 0.05, 0.2] {
        spec.optimisation.termination_threshold = threshold;
        let ended = draw(&spec, &volume);
        assert!(ended.counters.reads < exact.counters.reads);
        for (a, b) in ended.picture.iter().zip(&exact.picture) {
            // What is behind the end of a ray is not brighter than white.
            assert!(f64::from((a - b).abs()) <= threshold + 0.001);
        }
    }
}

#[test]
fn adaptive_sampling_reads_less_and_is_near() {
    let volume = small_jaw();
    let mut spec = jaw_spec();
    spec.optimisation = Optimisation {
        leaping: Leaping::Safe,
        ..Optimisation::none()
    };
    let exact = draw(&spec, &volume);
    spec.optimisation.adaptive_error = 2;
    let adaptive = draw(&spec, &volume);
    assert!(adaptive.counters.sample_reads < exact.counters.sample_reads);
    assert!(adaptive.counters.skipped_by_adaptive_sampling > 0);
    let psnr = strahl_sim::study::psnr_db(&adaptive.picture, &exact.picture);
    assert!(psnr > 40.0, "{psnr} dB");
}

/// Distances of the circuit are cut at its margin: shorter leaps, the same picture. The clocks of coding are those of its
/// columns.
#[test]
fn the_engine_of_columns_changes_no_pixel() {
    let volume = small_jaw();
    let mut spec = jaw_spec();
    let software = draw(&spec, &volume);
    assert_eq!(software.counters.coding_clocks, 0);
    let mut reads = vec![software.counters.reads];
    for margin in [8, 2] {
        spec.optimisation.distance_engine = Some(Engine {
            columns: 32,
            rows: 32,
            margin,
            load_ms: 0,
        });
        let drawn = draw(&spec, &volume);
        assert_eq!(drawn.picture, software.picture);
        reads.push(drawn.counters.reads);
        // The map has a layer of cells at −1.
        let columns = 129u64.div_ceil(32 - 2 * u64::from(margin)).pow(2);
        assert_eq!(drawn.counters.coding_clocks, 2 * columns * 32 * 32 * 65);
    }
    assert!(reads.is_sorted() && reads[0] < reads[2], "{reads:?}");
    // One chip for coder and caster: it is loaded before and behind, and nothing of it happens in a frame.
    let mut engine = spec.optimisation.distance_engine.unwrap();
    let resident = draw(&spec, &volume).counters;
    engine.load_ms = 2000;
    spec.optimisation.distance_engine = Some(engine);
    let loaded = draw(&spec, &volume).counters;
    assert_eq!(
        loaded.coding_clocks - resident.coding_clocks,
        2 * 200_000_000
    );
    assert_eq!(loaded.clocks, resident.clocks);
    spec.optimisation.distance_engine = Some(Engine {
        columns: 32,
        rows: 16,
        margin: 8,
        load_ms: 0,
    });
    let message = strahl_sim::Frame::new(&spec, &volume)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("margin is 8") && message.contains("at most 7"),
        "{message}"
    );
}

/// Rows of the distance store: only their clocks are added, and a word for 2³ cells has fewer of them.
#[test]
fn rows_of_the_distance_store_hold_the_pipeline() {
    let volume = small_jaw();
    let mut spec = jaw_spec();
    let ideal = draw(&spec, &volume);
    assert_eq!(ideal.counters.distance_row_changes, 0);
    let mut changes = Vec::new();
    for block in [1, 2] {
        spec.optimisation.distance_block = block;
        spec.memory.distance_store = DistanceMemory::Ideal;
        let ideal = draw(&spec, &volume).counters;
        spec.memory.distance_store = DistanceMemory::Sdram;
        let drawn = draw(&spec, &volume);
        let c = drawn.counters;
        assert_eq!(drawn.picture, draw(&spec, &volume).picture);
        assert_eq!((c.reads, c.row_changes), (ideal.reads, ideal.row_changes));
        assert_eq!(c.clocks - ideal.clocks, c.frozen_for_distances);
        assert!(c.frozen_for_distances <= 9 * c.distance_row_changes);
        changes.push(c.distance_row_changes);
    }
    assert!(changes[0] > changes[1] && changes[1] > 100, "{changes:?}");
}
