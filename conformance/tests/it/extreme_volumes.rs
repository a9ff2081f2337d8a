//! Volumes at the edge of what there is: each gives a picture, and the right one.

use crate::importance::drawn;
use crate::simple::{self, centered, cut_box, draw, grey, of_samples, parallel, plan, value_shown};
use glam::{DAffine3, DMat3, DVec3};
use strahl_conformance::agreement::{Agreement, agreement};
use strahl_conformance::renderers;
use strahl_scene::plan::{ClipShape, Composite};
use strahl_scene::{Method, Scene, resolve};
use strahl_shader::registry::Function;
use strahl_volume::{Datasets, Samples, Volume};

/// Those that show the value of a volume that has one value only.
const SHOWING_VALUES: [Composite; 5] = [
    Composite::EmissionAbsorption {
        stop_at_transmittance: 0.0,
    },
    Composite::Mip,
    Composite::Minip,
    Composite::Average,
    Composite::FirstHit { threshold: 0.0 },
];

fn f64s(dims: [usize; 3], values: Vec<f64>) -> Volume {
    of_samples(centered(dims, DMat3::IDENTITY), Samples::F64(values))
}

#[test]
fn scenes_of_every_method_resolve_and_draw_finite_pixels() {
    let volumes = [
        of_samples(centered([1; 3], DMat3::IDENTITY), Samples::U8(vec![200])),
        of_samples(
            centered([1, 9, 1], DMat3::from_rotation_x(0.5)),
            Samples::I16((0..9).map(|i| i * 100 - 400).collect()),
        ),
        of_samples(
            centered([2, 2, 1], DMat3::IDENTITY),
            Samples::U32(vec![0, 1, u32::MAX - 1, u32::MAX]),
        ),
        f64s([2, 2, 2], vec![f64::NAN; 8]),
        f64s(
            [3, 1, 3],
            vec![
                1.0,
                f64::NAN,
                2.0,
                f64::INFINITY,
                3.0,
                f64::NEG_INFINITY,
                1.0,
                2.0,
                0.5,
            ],
        ),
        f64s([2, 1, 1], vec![-1e30, 1e30]),
    ];
    for (i, volume) in volumes.iter().enumerate() {
        for method in Method::ALL {
            let scene = Scene {
                method: Some(method),
                size: Some([7, 5]),
                ..Scene::default()
            };
            let plan = resolve(&scene, &volume.header(), None)
                .unwrap_or_else(|problems| panic!("volume {i}, {method:?}: {problems}"));
            for (name, x, y, pixel) in draw(volume, &plan) {
                assert!(
                    pixel.iter().all(|c| c.is_finite()) && (0.0..=1.0).contains(&pixel[3]),
                    "{name}, volume {i}, {method:?}, column {x}, row {y}: {pixel:?}"
                );
            }
        }
    }
}

#[test]
fn what_is_not_finite_is_not_there() {
    for missing in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
        let volume = f64s([3; 3], vec![missing; 27]);
        for function in Function::of_slot("composite") {
            let composite = Composite::of(function.name, |p| function.default_of(p)).unwrap();
            let mut plan = plan(&volume, parallel(DVec3::Y, 9.0, 1.0), grey(-1.0, 1.0));
            plan.technique_mut().composite = composite;
            plan.background = [0.25, 0.5, 0.75, 1.0];
            for (name, _, _, pixel) in draw(&volume, &plan) {
                assert_eq!(pixel, plan.background, "{name}, {missing}, {composite:?}");
            }
        }
        // One such voxel takes the eight cells around it with it, and nothing else.
        let mut values = vec![0.5; 5 * 5 * 5];
        values[0] = missing;
        let volume = f64s([5; 3], values);
        for composite in SHOWING_VALUES {
            let mut plan = plan(&volume, parallel(DVec3::Y, 9.0, 0.9), grey(-1.0, 1.0));
            plan.technique_mut().composite = composite;
            for (name, _, _, pixel) in draw(&volume, &plan) {
                let found = value_shown(pixel, -1.0, 1.0);
                assert!((found - 0.5).abs() < 1e-6, "{name}, {composite:?}: {found}");
            }
        }
    }
}

#[test]
fn large_whole_numbers_keep_what_single_precision_holds() {
    let largest = f64::from(u32::MAX);
    let volume = of_samples(
        centered([2; 3], DMat3::IDENTITY),
        Samples::U32(vec![u32::MAX; 8]),
    );
    let mut plan = plan(&volume, parallel(DVec3::Y, 9.0, 0.5), grey(0.0, largest));
    plan.technique_mut().composite = Composite::Mip;
    for (name, _, _, pixel) in draw(&volume, &plan) {
        assert_eq!(pixel, [1.0; 4], "{name}");
    }
}

#[test]
fn a_flat_volume_is_lit_as_if_unlit() {
    let volume = of_samples(centered([4; 3], DMat3::IDENTITY), Samples::U8(vec![9; 64]));
    let mut flat = plan(&volume, parallel(DVec3::Y, 9.0, 1.0), grey(0.0, 18.0));
    let unlit = draw(&volume, &flat);
    flat.technique_mut().shade = simple::blinn_phong(0.1, 0.5, 0.9, 3.0);
    assert_eq!(unlit, draw(&volume, &flat));
    assert_eq!(unlit.len(), renderers().len() * 48);
}

#[test]
fn a_mask_does_not_cover_cells_with_voxels_that_are_not_finite() {
    let volume = of_samples(
        centered([12; 3], DMat3::IDENTITY),
        Samples::U8(vec![200; 1728]),
    );
    let value = |i: usize| match i % 29 {
        0 => f32::NAN,
        7 => f32::INFINITY,
        19 => f32::NEG_INFINITY,
        n => n as f32,
    };
    let mask_grid = centered([5; 3], DMat3::from_diagonal(DVec3::splat(2.6)));
    // Below every value, and between them.
    for threshold in [-1.0, 14.5] {
        for keep_inside in [true, false] {
            let mask = of_samples(mask_grid, Samples::F32((0..125).map(value).collect()));
            let mut plan = plan(
                &volume,
                parallel(DVec3::new(0.3, 0.9, 0.2).normalize(), 40.0, 9.0),
                grey(0.0, 255.0),
            );
            let mut clip = cut_box(DAffine3::from_scale(DVec3::splat(1.0 / 13.0)), keep_inside);
            clip.shape = ClipShape::Mask { mask: 0, threshold };
            plan.sample_clips.push(clip);
            let mut data = Datasets::from(&volume);
            data.masks.push((&mask).into());
            let drawn = drawn(&data, &plan);
            let first = &drawn[0].1;
            // Something is drawn: if the mask covered all or nothing, one of the two pictures would be empty.
            let lit = first.pixels().iter().filter(|pixel| pixel[3] > 0.0).count();
            assert!(lit > 0, "{threshold} {keep_inside}");
            for (renderer, image) in &drawn[1..] {
                let Agreement { psnr_db, .. } = agreement(first, image);
                assert!(
                    psnr_db > 60.0,
                    "{renderer}, {threshold}, {keep_inside}: {psnr_db}"
                );
            }
        }
    }
}
