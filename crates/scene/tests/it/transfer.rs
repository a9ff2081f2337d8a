use crate::{ct_head, header_of};
use strahl_scene::transfer::TransferTable;
use strahl_scene::{
    Color, ColorMap, PointsIn, Scene, TransferFunction, TransferPoint, linear_from_srgb, resolve,
};
use strahl_volume::{Rescale, Samples, VolumeHeader};

fn table(function: TransferFunction, header: &VolumeHeader) -> TransferTable {
    let scene = Scene {
        transfer_function: Some(function),
        ..Scene::default()
    };
    let plan = resolve(&scene, header, None).unwrap();
    plan.technique().table.clone()
}

fn points(points: &[(f64, f64, [f64; 3])]) -> TransferFunction {
    TransferFunction {
        points: Some(
            points
                .iter()
                .map(|&(value, opacity, color)| TransferPoint::new(value, opacity, Color(color)))
                .collect(),
        ),
        ..TransferFunction::default()
    }
}

fn bytes() -> VolumeHeader {
    header_of(Samples::U8((0..=255).collect()), Rescale::IDENTITY)
}

#[test]
fn stored_values_get_the_exact_color_and_opacity() {
    let table = table(
        points(&[
            (80.0, 0.0, [0.0, 0.0, 0.0]),
            (120.0, 0.05, [0.6, 0.6, 0.6]),
            (180.0, 0.1, [0.8, 0.8, 0.8]),
            (200.0, 0.5, [1.0, 0.6, 0.2]),
            (255.0, 0.9, [1.0, 0.8, 0.4]),
        ]),
        &bytes(),
    );
    assert_eq!(table.at(0.0), [0.0; 4]);
    for (value, opacity, color) in [
        (100.0, 0.025, [0.3, 0.3, 0.3]),
        (120.0, 0.05, [0.6, 0.6, 0.6]),
        // Halfway in sRGB, then made linear.
        (190.0, 0.3, [0.9, 0.7, 0.5]),
        (255.0, 0.9, [1.0, 0.8, 0.4]),
    ] {
        let found = table.at(value);
        assert!((found[3] - opacity).abs() < 1e-5, "{value}: {found:?}");
        for c in 0..3 {
            let expected = linear_from_srgb(color[c]) as f32;
            assert!((found[c] - expected).abs() < 1e-5, "{value}: {found:?}");
        }
    }
}

#[test]
fn between_stored_values_the_table_stays_close() {
    let table = table(
        points(&[(0.0, 0.0, [0.0; 3]), (255.0, 1.0, [1.0, 0.5, 0.0])]),
        &bytes(),
    );
    for i in 0..2550 {
        let value = 0.1 * f64::from(i);
        let found = table.at(value as f32);
        assert!((f64::from(found[3]) - value / 255.0).abs() < 1e-5);
        let red = linear_from_srgb(value / 255.0);
        assert!((f64::from(found[0]) - red).abs() < 1e-5, "{value}");
    }
}

#[test]
fn a_peak_one_stored_value_wide_survives() {
    let twelve_bits = Samples::U16((0..4096).collect());
    let wide = Samples::U16((0..=65_534).collect());
    for (samples, rescale) in [
        (Samples::U8((0..=255).collect()), Rescale::IDENTITY),
        (twelve_bits.clone(), Rescale::IDENTITY),
        (wide, Rescale::IDENTITY),
        (
            twelve_bits,
            Rescale {
                slope: 0.37,
                intercept: -1024.0,
            },
        ),
    ] {
        let header = header_of(samples, rescale);
        let value = |stored: f64| rescale.value(stored);
        for peak in [1.0, 100.0, 254.0] {
            let table = table(
                points(&[
                    (value(0.0), 0.0, [1.0; 3]),
                    (value(peak - 1.0), 0.0, [1.0; 3]),
                    (value(peak), 1.0, [1.0; 3]),
                    (value(peak + 1.0), 0.0, [1.0; 3]),
                    (value(60_000.0), 0.0, [1.0; 3]),
                ]),
                &header,
            );
            let opacity = |stored: f64| table.at(value(stored) as f32)[3];
            assert!(opacity(peak) > 0.99, "{peak}: {}", opacity(peak));
            assert!(opacity(peak - 1.0) < 0.01 && opacity(peak + 1.0) < 0.01);
            assert!((opacity(peak + 0.5) - 0.5).abs() < 0.01);
        }
    }
}

#[test]
fn two_points_of_one_value_are_a_step() {
    let table = table(
        points(&[
            (100.0, 0.0, [0.0; 3]),
            (100.0, 0.8, [1.0; 3]),
            (200.0, 0.8, [1.0; 3]),
            (200.0, 0.0, [1.0; 3]),
        ]),
        &bytes(),
    );
    assert_eq!(table.at(0.0)[3], 0.0);
    assert_eq!(table.at(99.0)[3], 0.0);
    assert_eq!(table.at(100.0), [1.0, 1.0, 1.0, 0.8]);
    assert_eq!(table.at(199.0)[3], 0.8);
    assert_eq!(table.at(200.0)[3], 0.0);
    assert_eq!(table.at(255.0)[3], 0.0);
}

#[test]
fn a_narrow_piece_of_a_float_volume_is_not_lost() {
    let header = header_of(Samples::F32(vec![0.0, 1.0]), Rescale::IDENTITY);
    let table = table(
        points(&[
            (0.0, 0.0, [1.0; 3]),
            (0.5, 0.0, [1.0; 3]),
            (0.5002, 1.0, [1.0; 3]),
            (0.5004, 0.0, [1.0; 3]),
            (1.0, 0.0, [1.0; 3]),
        ]),
        &header,
    );
    assert!(table.at(0.5002)[3] > 0.85, "{}", table.at(0.5002)[3]);
    assert!(table.at(0.4999)[3] < 0.01 && table.at(0.5006)[3] < 0.01);
}

#[test]
fn a_window_is_a_ramp() {
    let table = table(
        TransferFunction {
            points: None,
            window: Some(400.0),
            level: Some(40.0),
            color_map: Some(ColorMap::Grey),
            opacity: Some([0.1, 0.5]),
            ..TransferFunction::default()
        },
        &ct_head(),
    );
    for (value, grey, opacity) in [
        (-1000.0, 0.0, 0.1),
        (-160.0, 0.0, 0.1),
        (40.0, 0.5, 0.3),
        (140.0, 0.75, 0.4),
        (240.0, 1.0, 0.5),
        (3000.0, 1.0, 0.5),
    ] {
        let found = table.at(value);
        assert!(
            (found[0] - linear_from_srgb(grey) as f32).abs() < 1e-5,
            "{value}: {found:?}"
        );
        assert!((found[3] - opacity).abs() < 1e-5, "{value}: {found:?}");
    }
}

/// Found by fuzzing: where the distance to the next number is larger than the window.
#[test]
fn a_window_far_from_all_values_is_still_a_table() {
    for (level, window) in [(4e16, 1.0), (-4e16, 1.0), (4.4e26, 401.0), (1e30, 1e-30)] {
        for header in [bytes(), ct_head()] {
            let table = table(
                TransferFunction {
                    window: Some(window),
                    level: Some(level),
                    opacity: Some([0.25, 0.75]),
                    ..TransferFunction::default()
                },
                &header,
            );
            let expected = if level > 0.0 { 0.25 } else { 0.75 };
            assert_eq!(table.at(100.0)[3], expected, "level {level}");
        }
    }
}

#[test]
fn a_window_without_width_is_a_step() {
    let table = table(
        TransferFunction {
            window: Some(1e-300),
            level: Some(100.0),
            color_map: Some(ColorMap::Grey),
            opacity: Some([0.0, 1.0]),
            ..TransferFunction::default()
        },
        &bytes(),
    );
    assert_eq!(table.at(99.0), [0.0; 4]);
    assert_eq!(table.at(100.0), [1.0; 4]);
}

#[test]
fn points_can_count_in_the_window() {
    let function = TransferFunction {
        points_in: Some(PointsIn::Window),
        window: Some(100.0),
        level: Some(150.0),
        ..points(&[(0.0, 0.0, [0.0; 3]), (1.0, 1.0, [1.0; 3])])
    };
    let table = table(function, &bytes());
    assert_eq!(table.at(100.0)[3], 0.0);
    assert!((table.at(125.0)[3] - 0.25).abs() < 1e-6);
    assert!((table.at(200.0)[3] - 1.0).abs() < 1e-6);
}

#[test]
fn color_and_opacity_may_have_points_of_their_own() {
    let point = |value, opacity, color| TransferPoint {
        value,
        opacity,
        color,
    };
    let function = TransferFunction {
        points: Some(vec![
            point(0.0, Some(0.0), Some(Color::BLACK)),
            point(50.0, Some(1.0), None),
            point(100.0, None, Some(Color::WHITE)),
            point(150.0, Some(0.5), None),
        ]),
        ..TransferFunction::default()
    };
    let table = table(function, &bytes());
    assert!((table.at(50.0)[0] - linear_from_srgb(0.5) as f32).abs() < 1e-5);
    assert!((table.at(100.0)[3] - 0.75).abs() < 1e-5);
    assert_eq!(table.at(120.0)[0], 1.0);
}

#[test]
fn the_reference_is_the_mean_spacing_or_what_is_said() {
    let reference = |function| table(function, &ct_head()).reference_mm();
    let plain = points(&[(0.0, 0.5, [1.0; 3])]);
    assert!((reference(plain.clone()) - 2.0 / 3.0).abs() < 1e-6);
    let in_mm = TransferFunction {
        reference_mm: Some(2.5),
        ..plain.clone()
    };
    assert_eq!(reference(in_mm), 2.5);
    let in_voxels = TransferFunction {
        reference_voxels: Some(3.0),
        ..plain
    };
    assert!((reference(in_voxels) - 2.0).abs() < 1e-6);
}
