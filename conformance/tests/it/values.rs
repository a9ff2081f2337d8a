//! Values, gradients, projections and hits of fields that are known everywhere.

use crate::random::{Random, renderers_of, seeds};
use crate::simple::{
    self, centered, draw, draw_by, grey, grids, one_sample_at, parallel, plan, value_shown,
};
use glam::{DMat3, DVec3};
use strahl_conformance::{closed_form, truth};
use strahl_scene::plan::{Composite, GradientInput, Plan, PlanLight, Reconstruct};
use strahl_scene::transfer::TransferTable;
use strahl_volume::phantom::Phantom;
use strahl_volume::{Metadata, Rescale, Samples, Volume};

/// Where the one sample of a pixel lies after [`one_sample_at`].
fn place(plan: &Plan, x: u32, y: u32, distance_mm: f64) -> DVec3 {
    let (origin, direction) = truth::ray(plan, x, y);
    let depth = distance_mm - origin.dot(plan.camera.forward);
    origin + direction * (depth / direction.dot(plan.camera.forward))
}

/// The largest error of a single sample's value against `exact`.
fn worst_value(
    volume: &Volume,
    mut plan: Plan,
    lo: f64,
    hi: f64,
    exact: impl Fn(DVec3) -> f64,
) -> f64 {
    plan.technique_mut().table = grey(lo, hi);
    plan.technique_mut().composite = Composite::Average;
    one_sample_at(&mut plan, 0.3);
    let mut worst: f64 = 0.0;
    for (_, x, y, pixel) in draw(volume, &plan) {
        assert_eq!(pixel[3], 1.0, "column {x}, row {y} has no sample");
        let error = value_shown(pixel, lo, hi) - exact(place(&plan, x, y, 0.3));
        worst = worst.max(error.abs());
    }
    worst
}

/// The normals of single samples: white diffuse light from the six sides of the world, in two pictures.
/// The largest distance to ± the direction of `gradient`.
fn worst_normal(
    volume: &Volume,
    mut plan: Plan,
    at: impl Fn(&Plan, u32, u32) -> DVec3,
    gradient: impl Fn(DVec3) -> DVec3,
) -> f64 {
    plan.technique_mut().shade = simple::blinn_phong(0.0, 1.0, 0.0, 1.0);
    let lights = |sign: f64| {
        let light = |axis: usize| {
            let mut radiance = [0.0; 3];
            radiance[axis] = 1.0;
            PlanLight::Directional {
                to_light: sign * DVec3::AXES[axis],
                radiance,
            }
        };
        (0..3).map(light).collect()
    };
    plan.lights = lights(1.0);
    let positive = draw(volume, &plan);
    plan.lights = lights(-1.0);
    let negative = draw(volume, &plan);
    let mut worst: f64 = 0.0;
    for ((_, x, y, p), (.., n)) in positive.into_iter().zip(negative) {
        assert_eq!(p[3], 1.0, "column {x}, row {y} shows nothing");
        let normal = DVec3::from_array([0, 1, 2].map(|c| f64::from(p[c]) - f64::from(n[c])));
        let (_, direction) = truth::ray(&plan, x, y);
        let expected = gradient(at(&plan, x, y)).normalize();
        // Turned towards the eye.
        let expected = expected * -expected.dot(direction).signum();
        worst = worst.max(normal.distance(expected));
    }
    worst
}

fn opaque_white() -> TransferTable {
    simple::white(1.0, 1.0)
}

#[test]
fn values_and_gradients_of_a_ramp_are_exact_on_every_grid() {
    let gradient = DVec3::new(1.0, 2.0, 4.0);
    for grid in grids() {
        let ramp = simple::volume(grid, |p| 100.0 + gradient.dot(p));
        let view = parallel(DVec3::new(0.6, -0.5, 0.4), 50.0, 0.8);
        let plan = plan(&ramp, view, opaque_white());
        let worst = worst_value(&ramp, plan.clone(), 80.0, 120.0, |p| {
            100.0 + gradient.dot(p)
        });
        assert!(worst < 5e-5, "{worst}");
        let mut lit = plan;
        one_sample_at(&mut lit, 0.3);
        let worst = worst_normal(&ramp, lit, |_, _, _| DVec3::ZERO, |_| gradient);
        assert!(worst < 2e-5, "{worst}");
    }
}

#[test]
fn values_and_gradients_of_marschner_lobb_converge_with_order_two() {
    // Trilinear interpolation and central differences both miss by the square of the spacing.
    let mut errors = Vec::new();
    for voxels_per_mm in [2.0, 4.0, 8.0] {
        let edge = (8.0 * voxels_per_mm) as usize + 1;
        let grid = centered(
            [edge; 3],
            DMat3::from_diagonal(DVec3::splat(1.0 / voxels_per_mm)),
        );
        let ml = simple::volume(grid, |p| Phantom::MarschnerLobb.value(p));
        let view = parallel(DVec3::new(0.6, -0.5, 0.4), 50.0, 1.5);
        let mut plan = plan(&ml, view, opaque_white());
        (plan.width, plan.height) = (24, 18);
        let value = worst_value(&ml, plan.clone(), 0.0, 1.0, |p| {
            Phantom::MarschnerLobb.value(p)
        });
        one_sample_at(&mut plan, 0.3);
        let at = |plan: &Plan, x, y| place(plan, x, y, 0.3);
        let normal = worst_normal(&ml, plan, at, |p| Phantom::MarschnerLobb.gradient(p));
        errors.push([value, normal]);
    }
    for pair in errors.windows(2) {
        for (coarse, fine) in pair[0].iter().zip(pair[1]) {
            let order = (coarse / fine).log2();
            assert!((1.6..2.4).contains(&order), "order {order}: {errors:?}");
        }
    }
}

#[test]
fn nearest_takes_the_voxel_whose_center_is_nearest() {
    let grid = centered([6, 5, 4], DMat3::from_rotation_z(0.3));
    let ramp = simple::volume(grid, |p| p.x + 7.0 * p.y);
    let view = parallel(DVec3::new(0.1, -0.9, 0.2), 50.0, 1.4);
    let mut plan = plan(&ramp, view, opaque_white());
    plan.field_mut().reconstruct = Reconstruct::Nearest;
    let worst = worst_value(&ramp, plan, -40.0, 40.0, |p| {
        let voxel = grid.voxel_from_world().transform_point3(p).round();
        let center = grid.world_from_voxel().transform_point3(voxel);
        center.x + 7.0 * center.y
    });
    assert!(worst < 5e-5, "{worst}");
}

#[test]
fn projections_of_analytic_fields_are_what_they_must_be() {
    // Linear along the view: the extremes lie at the outermost samples, the mean in the middle.
    let grid = centered([16; 3], DMat3::IDENTITY);
    let linear = simple::volume(grid, |p| 3.0 * p.y + p.x);
    let view = parallel(DVec3::Y, 30.0, 5.0);
    for (composite, y_mm) in [
        (Composite::Mip, 7.5),
        (Composite::Minip, -7.5),
        (Composite::Average, 0.0),
    ] {
        let mut plan = plan(&linear, view, grey(-40.0, 40.0));
        plan.technique_mut().composite = composite;
        // A sample in each half voxel beyond the outermost centers, where the value stays the same.
        plan.lattice.step_mm = 0.5;
        for (name, x, y, pixel) in draw(&linear, &plan) {
            let across = truth::ray(&plan, x, y).0.x;
            let (found, expected) = (value_shown(pixel, -40.0, 40.0), 3.0 * y_mm + across);
            assert!(
                (found - expected).abs() < 1e-4,
                "{name}: {found}, {expected}"
            );
        }
    }
    // The distance from a point: its minimum along a ray is the ray's own distance. Trilinear errors are
    // below 1/(4r), the sampling error below (step/2)²/2r.
    let grid = centered([40; 3], DMat3::IDENTITY);
    let distance = simple::volume(grid, DVec3::length);
    let mut plan = plan(
        &distance,
        parallel(DVec3::new(0.4, 0.8, -0.3), 60.0, 9.0),
        grey(0.0, 40.0),
    );
    plan.technique_mut().composite = Composite::Minip;
    for (name, x, y, pixel) in draw(&distance, &plan) {
        let (origin, direction) = truth::ray(&plan, x, y);
        let expected = (origin - origin.dot(direction) * direction).length();
        let found = value_shown(pixel, 0.0, 40.0);
        let allowed = 0.35 / expected.max(0.35);
        assert!(
            (found - expected).abs() < allowed,
            "{name}: {found}, {expected}"
        );
    }
    // The mean of the square over ±10 mm is 100/3, and 1/6 more by trilinear interpolation.
    let grid = centered([24; 3], DMat3::IDENTITY);
    let square = simple::volume(grid, |p| p.y * p.y);
    let mut plan = simple::plan(&square, parallel(DVec3::Y, 60.0, 9.0), grey(0.0, 100.0));
    plan.technique_mut().composite = Composite::Average;
    plan.lattice.step_mm = 1.0 / 16.0;
    let box_of = centered([1; 3], DMat3::from_diagonal(DVec3::new(60.0, 19.0, 60.0)));
    plan.sample_clips = vec![simple::cut_box(box_of.voxel_from_world(), true)];
    for (name, _, _, pixel) in draw(&square, &plan) {
        let expected = 9.5f64 * 9.5 / 3.0 + 1.0 / 6.0;
        let found = value_shown(pixel, 0.0, 100.0);
        assert!(
            (found - expected).abs() < 2e-3,
            "{name}: {found}, {expected}"
        );
    }
}

/// The hits of a sphere of 14 mm about the origin, at steps of 3 mm.
fn sphere_hits(camera: strahl_scene::plan::PlanCamera) -> (Volume, Plan) {
    let grid = centered([80; 3], DMat3::from_diagonal(DVec3::splat(0.5)));
    let depth = simple::volume(grid, |p| 14.0 - p.length());
    let mut plan = plan(&depth, camera, opaque_white());
    plan.technique_mut().composite = Composite::FirstHit { threshold: 0.0 };
    plan.lattice.step_mm = 3.0;
    (depth, plan)
}

#[test]
fn the_first_hit_lies_on_the_isosurface_whatever_the_step() {
    for camera in [
        parallel(DVec3::new(0.3, -0.8, 0.2), 60.0, 8.0),
        simple::from_eye(parallel(DVec3::Z, 60.0, 1.0), 0.13),
    ] {
        let (depth, plan) = sphere_hits(camera);
        let hit = |plan: &Plan, x, y| {
            let (origin, direction) = truth::ray(plan, x, y);
            let [enter, _] = closed_form::sphere(origin, direction, DVec3::ZERO, 14.0).unwrap();
            origin + enter * direction
        };
        // The normal of a sphere is its place: an error of the depth shows in it, as depth·sin/14.
        let worst = worst_normal(&depth, plan.clone(), hit, |p| -p);
        assert!(worst < 2e-3, "{worst}");
        // Without refinement it would be found up to 3 mm behind.
        let behind = |plan: &Plan, x, y| hit(plan, x, y) + 0.5 * truth::ray(plan, x, y).1;
        assert!(worst_normal(&depth, plan, behind, |p| -p) > 1e-2);
    }
}

#[test]
fn a_ray_that_starts_inside_hits_where_it_starts() {
    let (depth, mut plan) = sphere_hits(parallel(DVec3::Y, 0.0, 1.0));
    plan.camera = simple::from_eye(parallel(DVec3::Y, 5.0, 1.0), 0.4);
    plan.technique_mut().table = grey(0.0, 14.0);
    for (name, _, _, pixel) in draw(&depth, &plan) {
        let found = value_shown(pixel, 0.0, 14.0);
        assert!((found - 9.0).abs() < 0.02, "{name}: {found}");
    }
}

#[test]
fn a_hit_on_the_face_of_a_box_shows_the_value_there() {
    let (depth, mut plan) = sphere_hits(parallel(DVec3::Y, 40.0, 5.0));
    plan.technique_mut().table = grey(0.0, 14.0);
    let half = centered([1; 3], DMat3::from_diagonal(DVec3::new(100.0, 4.0, 100.0)));
    plan.sample_clips = vec![simple::cut_box(half.voxel_from_world(), true)];
    for (name, x, y, pixel) in draw(&depth, &plan) {
        let (origin, _) = truth::ray(&plan, x, y);
        let expected = 14.0 - DVec3::new(origin.x, -2.0, origin.z).length();
        let found = value_shown(pixel, 0.0, 14.0);
        assert!(
            (found - expected).abs() < 0.05,
            "{name}: {found}, {expected}"
        );
    }
}

#[test]
fn a_stored_number_equal_to_the_threshold_is_hit() {
    let grid = centered([3; 3], DMat3::IDENTITY);
    for stored in [7u8, 8, 9] {
        let volume = simple::of_samples(grid, Samples::U8(vec![stored; 27]));
        let mut plan = plan(&volume, parallel(DVec3::Y, 9.0, 1.0), opaque_white());
        plan.technique_mut().composite = Composite::FirstHit { threshold: 8.0 };
        for (name, _, _, pixel) in draw(&volume, &plan) {
            let expected = f32::from(u8::from(stored >= 8));
            assert_eq!(pixel[3], expected, "{name}, {stored}");
        }
    }
}

#[test]
fn peaks_one_stored_number_wide_are_seen() {
    // 12-bit data, one number of which is opaque: a voxel of it shows, its neighbors do not.
    let mut entries = vec![[0.0; 4]; 4096];
    entries[1234] = [1.0, 0.5, 0.25, 1.0];
    let table = TransferTable::new([0.0, 4095.0], 1.0, entries);
    let grid = centered([3, 1, 1], DMat3::IDENTITY);
    let volume = simple::of_samples(grid, Samples::U16(vec![1233, 1234, 1235]));
    let mut plan = plan(&volume, parallel(DVec3::Y, 9.0, 0.5), table);
    (plan.width, plan.height) = (3, 1);
    plan.field_mut().reconstruct = Reconstruct::Nearest;
    for (name, x, _, pixel) in draw(&volume, &plan) {
        let expected = if x == 1 {
            [1.0, 0.5, 0.25, 1.0]
        } else {
            [0.0; 4]
        };
        assert_eq!(pixel, expected, "{name}, column {x}");
    }
}

/// The pixel of a ray whose samples are `entries`, one after the other: what the paper says, in double precision.
fn peeled(entries: &[[f32; 4]], layer: u32, opaque_above: f32, clear_below: f32) -> [f64; 4] {
    let (mut seen, mut in_layer) = ([0.0; 4], 0);
    for &[r, g, b, opacity] in entries {
        if seen[3] > f64::from(opaque_above) && opacity <= clear_below {
            if in_layer == layer {
                return seen;
            }
            in_layer += 1;
            seen = [0.0; 4];
        }
        let share = (1.0 - seen[3]) * f64::from(opacity);
        for (sum, part) in seen.iter_mut().zip([r, g, b, 1.0]) {
            *sum += share * f64::from(part);
        }
    }
    if in_layer == layer { seen } else { [0.0; 4] }
}

#[test]
fn peeled_layers_are_those_of_the_samples_one_by_one() {
    // Lattice points are voxel centers, and their values 0 to 31: each sample is an entry of the table.
    let ramp = simple::volume(centered([2, 32, 2], DMat3::IDENTITY), |p| p.y + 15.5);
    let mut layers_seen = [0; 4];
    for seed in seeds(300) {
        let mut random = Random::new(seed ^ 0x9EE1);
        let mut unit = || random.unit() as f32;
        let entries: Vec<[f32; 4]> = (0..32)
            .map(|_| [unit(), unit(), unit(), (1.5 * unit() - 0.5).max(0.0)])
            .collect();
        let [opaque_above, clear_below] = [unit(), 0.5 * unit()];
        let layer = random.below(4) as u32;
        let table = TransferTable::new([0.0, 31.0], 1.0, entries.clone());
        let mut plan = plan(&ramp, parallel(DVec3::Y, 60.0, 0.5), table);
        (plan.width, plan.height) = (1, 1);
        plan.lattice.step_mm = 1.0;
        plan.technique_mut().composite = Composite::OpacityPeeling {
            layer,
            opaque_above,
            clear_below,
            stop_at_transmittance: 0.0,
        };
        let expected = peeled(&entries, layer, opaque_above, clear_below);
        layers_seen[layer as usize] += usize::from(expected[3] > 0.0);
        for (name, _, _, pixel) in draw_by(&renderers_of(seed), &ramp, &plan) {
            let is_near = |(&a, &b): (&f32, &f64)| (f64::from(a) - b).abs() < 1e-5;
            let close = pixel.iter().zip(&expected).all(is_near);
            assert!(close, "{name}, seed {seed}: {pixel:?}, not {expected:?}");
        }
    }
    assert!(layers_seen.iter().all(|&n| n >= 10), "{layers_seen:?}");
}

const RECONSTRUCTIONS: [Reconstruct; 4] = [
    Reconstruct::Nearest,
    Reconstruct::Trilinear,
    Reconstruct::BSpline,
    Reconstruct::CatmullRom,
];

/// A column of six voxels along y, with 1 in all but those that `without` names.
fn column(without: impl Fn(usize) -> bool, instead: f32) -> Volume {
    let grid = centered([3, 6, 3], DMat3::IDENTITY);
    let value = |i: usize| if without(i / 3 % 6) { instead } else { 1.0 };
    simple::of_samples(grid, Samples::F32((0..54).map(value).collect()))
}

#[test]
fn what_is_infinite_reaches_no_threshold() {
    // The bracket that is halved begins where nothing has a value.
    let column = column(|y| y < 2, f32::INFINITY);
    for reconstruct in RECONSTRUCTIONS {
        let view = parallel(DVec3::new(0.1, 1.0, 0.05), 9.0, 0.5);
        let mut plan = plan(&column, view, grey(0.0, 2.0));
        plan.lattice.step_mm = 1.7;
        plan.field_mut().reconstruct = reconstruct;
        plan.technique_mut().composite = Composite::FirstHit { threshold: 0.5 };
        for (name, x, y, pixel) in draw(&column, &plan) {
            let found = value_shown(pixel, 0.0, 2.0);
            assert!(
                pixel[3] == 1.0 && (found - 1.0).abs() < 1e-5,
                "{name}, {reconstruct:?}, column {x}, row {y}: {found}"
            );
        }
    }
}

#[test]
fn the_half_voxel_behind_the_last_belongs_to_the_last_cell() {
    // At 5.3 voxels: between 4 and 5, so that a cubic asks for 3 to 6.
    for (reconstruct, first_asked) in RECONSTRUCTIONS.into_iter().zip([5, 4, 3, 3]) {
        let (nan, infinite) = (f32::NAN, f32::INFINITY);
        let cases = [
            (first_asked - 1, nan),
            (first_asked, nan),
            (first_asked, infinite),
        ];
        for (lost, instead) in cases {
            let column = column(|y| y == lost, instead);
            let mut plan = plan(&column, parallel(DVec3::Y, 9.0, 0.5), opaque_white());
            plan.field_mut().reconstruct = reconstruct;
            one_sample_at(&mut plan, 2.8);
            let expected = f32::from(u8::from(lost < first_asked));
            for (name, x, y, pixel) in draw(&column, &plan) {
                assert_eq!(
                    pixel[3], expected,
                    "{name}, {reconstruct:?}, {instead} at {lost}, column {x}, row {y}"
                );
            }
        }
    }
}

/// That a surface of `volume` is white, as without light, though lit it would be darker.
fn is_unlit(what: &str, volume: &Volume, mut plan: Plan) {
    plan.technique_mut().shade = simple::blinn_phong(0.2, 0.7, 0.0, 1.0);
    for (name, x, y, pixel) in draw(volume, &plan) {
        assert_eq!(pixel, [1.0; 4], "{name}, {what}, column {x}, row {y}");
    }
}

#[test]
fn constant_parts_have_no_normal() {
    // From places whose parts of a voxel have no short binary fractions, at samples that lie anywhere.
    let view = simple::from_eye(parallel(DVec3::new(0.3, 0.9, -0.2), 30.0, 1.0), 0.05);
    let grid = centered([7; 3], DMat3::from_diagonal(DVec3::new(0.9, 1.1, 0.7)));
    let surface = |volume: &Volume, table| {
        let mut plan = plan(volume, view, table);
        plan.technique_mut().composite = Composite::FirstHit { threshold: -1e6 };
        plan
    };
    let samples = Samples::U8(vec![0; 343]);
    let rescale = Rescale::new(-0.86, -333.2);
    let zero = Volume::new(grid, samples, rescale, Metadata::default()).unwrap();
    for reconstruct in RECONSTRUCTIONS {
        let mut plan = surface(&zero, opaque_white());
        plan.field_mut().reconstruct = reconstruct;
        is_unlit(&format!("{reconstruct:?}"), &zero, plan);
    }
    let third = simple::volume(grid, |_| 1.0 / 3.0);
    is_unlit("1/3", &third, surface(&third, opaque_white()));
    // An opacity that does not change with the value.
    let ramp = simple::volume(grid, |p| 0.5 + 0.1 * p.y);
    let mut plan = surface(&ramp, simple::white(1.0 / 3.0, 1.0));
    plan.technique_mut().gradient_input = GradientInput::Opacity;
    is_unlit("opacity 1/3", &ramp, plan);
}
