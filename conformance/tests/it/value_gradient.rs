//! Transfer functions of value and gradient magnitude.

use crate::simple::{draw, one_sample_at, parallel, plan, volume};
use crate::variants;
use glam::{DMat3, DVec3};
use strahl_conformance::truth;
use strahl_scene::plan::*;
use strahl_scene::transfer::TransferTable;
use strahl_scene::{Scene, resolve};

const COLUMNS: usize = 5;
const ROWS: usize = 4;

/// Any colors and opacities, and an entry that is transparent.
fn table() -> TransferTable {
    table_over([-20.0, 20.0])
}

/// The classification by such a table.
pub fn classify(full_per_mm: f32) -> Classify {
    Classify::ValueGradient {
        full_per_mm,
        columns: COLUMNS as u32,
        rows: ROWS as u32,
    }
}

/// The same over other values.
pub fn table_over(domain: [f32; 2]) -> TransferTable {
    let entry = |i: usize| {
        let number = |factor: usize| (i * factor % 17) as f32 / 16.0;
        [number(3), number(5), number(7), number(11)]
    };
    let mut rows: Vec<_> = (0..COLUMNS * ROWS).map(entry).collect();
    rows[COLUMNS + 2] = [1.0, 0.0, 1.0, 0.0];
    TransferTable::of_rows(domain, 1.0, COLUMNS, rows)
}

/// The color, premultiplied, and the opacity between entries that count by their opacity.
fn expected(table: &TransferTable, value: f64, share: f64) -> [f64; 4] {
    let column = ((value + 20.0) / 40.0).clamp(0.0, 1.0) * (COLUMNS - 1) as f64;
    let row = share.clamp(0.0, 1.0) * (ROWS - 1) as f64;
    let (x, y) = (
        column.floor().min((COLUMNS - 2) as f64),
        row.floor().min((ROWS - 2) as f64),
    );
    let mut sum = [0.0; 4];
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let weight = |part: f64, side: usize| if side == 1 { part } else { 1.0 - part };
        let weight = weight(column - x, dx) * weight(row - y, dy);
        let [r, g, b, a] =
            table.rows()[(y as usize + dy) * COLUMNS + x as usize + dx].map(f64::from);
        for (sum, own) in sum.iter_mut().zip([r * a, g * a, b * a, a]) {
            *sum += weight * own;
        }
    }
    sum
}

#[test]
fn a_sample_has_the_color_of_its_value_and_its_gradient_magnitude() {
    let grid = crate::simple::centered(
        [14, 13, 12],
        DMat3::from_diagonal(DVec3::new(0.9, 1.1, 1.3)),
    );
    for slope in [0.2, 1.4, 2.9] {
        let direction = DVec3::new(0.6, 0.5, -0.62).normalize();
        let volume = volume(grid, |place| slope * place.dot(direction));
        let mut plan = plan(
            &volume,
            parallel(DVec3::new(0.2, 1.0, 0.3), 40.0, 3.0),
            table(),
        );
        plan.techniques[0].classify = classify(2.4);
        plan.lattice.step_mm = 1.0;
        one_sample_at(&mut plan, 1.0);
        for (renderer, x, y, pixel) in draw(&volume, &plan) {
            let (origin, ray) = truth::ray(&plan, x, y);
            let forward = plan.camera.forward;
            let place = origin + (1.0 - origin.dot(forward)) * ray;
            let right = expected(&table(), slope * place.dot(direction), slope / 2.4);
            for (found, right) in pixel.into_iter().zip(right) {
                let off = (f64::from(found) - right).abs();
                assert!(
                    off < 2e-3,
                    "{renderer:?} {slope} {x} {y}: {pixel:?} {right}"
                );
            }
        }
    }
}

#[test]
fn what_regions_leave_out_is_skipped_without_changing_a_byte() {
    let volume = variants::blobs(
        crate::simple::centered([40, 36, 44], DMat3::IDENTITY),
        &[DVec3::new(8.0, 1.0, -9.0)],
        6.0,
    );
    let text = r##"{ "size": [40, 36], "transfer_function": { "regions": [
        { "corners": [[0.3, 0], [0.8, 0], [0.5, 0.3]], "opacity": 0.4, "color": "#f80" },
        { "corners": [[0.8, 0], [1, 0], [1, 0.2]] }] } }"##;
    let scene = Scene::parse("scene", text).unwrap();
    let plan = resolve(&scene, &volume.header(), None).unwrap();
    let technique = plan.technique();
    assert!(matches!(technique.classify, Classify::ValueGradient { .. }));
    let with = |skip: bool| {
        let options = strahl_cpu::Options {
            skip,
            ..Default::default()
        };
        variants::draw_with(&volume, &plan, &options)
    };
    let [skipping, all] = [true, false].map(with);
    assert!(skipping.image.pixels() == all.image.pixels());
    assert!(skipping.stats.counts.unwrap().points_skipped > 1000);
    assert!(all.image.pixels().iter().any(|pixel| pixel[0] > 0.1));
}
