//! Emission and absorption against closed forms.

use crate::simple::{self, centered, draw, from_eye, grids, parallel, plan, white};
use glam::{DMat3, DVec3};
use strahl_conformance::{closed_form, renderers, truth};
use strahl_scene::plan::Plan;
use strahl_scene::transfer::TransferTable;
use strahl_volume::Volume;

const TOLERANCE: f64 = 1e-4;

/// Every pixel lets through what `length_mm` of its ray says.
fn check(volume: &Volume, plan: &Plan, opacity: f64, length_mm: impl Fn(DVec3, DVec3) -> f64) {
    let reference_mm = f64::from(plan.technique().table.reference_mm());
    let opacity = f64::from(opacity as f32);
    for (renderer, x, y, pixel) in draw(volume, plan) {
        let (origin, direction) = truth::ray(plan, x, y);
        let length = length_mm(origin, direction);
        let expected = closed_form::transmittance(opacity, reference_mm, length);
        let found = 1.0 - f64::from(pixel[3]);
        let lost = length / plan.lattice.step_mm * renderer.lost_per_sample;
        assert!(
            (found - expected).abs() < TOLERANCE + lost,
            "{renderer}, column {x}, row {y}: {found} instead of {expected} through {length} mm of {opacity}"
        );
        // White, premultiplied: the color is the opacity.
        assert!(pixel[..3].iter().all(|c| (c - pixel[3]).abs() < 1e-5));
    }
}

/// A reference length at which the longest way has an optical depth of 2.
fn reference_mm(opacity: f64, longest_mm: f64) -> f64 {
    longest_mm * -(1.0 - opacity).ln() / 2.0
}

#[test]
fn a_slab_of_any_grid_seen_from_anywhere_passes_the_closed_form() {
    for grid in grids() {
        let slab = simple::volume(grid, |_| 0.5);
        let diagonal = grid.bounds_mm().0.distance(grid.bounds_mm().1);
        let side = parallel(DVec3::Y, 2.0 * diagonal, 0.3 * diagonal);
        let askew = parallel(DVec3::new(-0.3, 0.8, 0.5), 2.0 * diagonal, 0.3 * diagonal);
        let inside = parallel(DVec3::new(0.2, -0.9, 0.1), 0.05 * diagonal, 1.0);
        let cameras = [side, askew, from_eye(askew, 0.2), from_eye(inside, 0.5)];
        for (camera, opacity) in cameras.into_iter().zip([0.9, 0.3, 0.01, 0.99]) {
            let mut plan = plan(
                &slab,
                camera,
                white(opacity, reference_mm(opacity, diagonal)),
            );
            // The number of steps is a whole number: half a step is missing or too much, at an
            // optical depth of 2 over the diagonal.
            plan.lattice.step_mm = diagonal / 12_000.0;
            check(&slab, &plan, opacity, |origin, direction| {
                closed_form::chord_in_grid(origin, direction, &grid)
            });
        }
    }
}

#[test]
fn opacity_correction_makes_the_slab_independent_of_the_step() {
    let grid = centered([16; 3], DMat3::IDENTITY);
    let slab = simple::volume(grid, |_| 0.5);
    for opacity in [0.02, 0.2, 0.7] {
        let expected = closed_form::transmittance(f64::from(opacity as f32), 5.0, 16.0);
        for steps in [1, 2, 3, 7, 16, 64, 1000] {
            let mut plan = plan(&slab, parallel(DVec3::Y, 20.0, 6.0), white(opacity, 5.0));
            // Not exactly a whole number, so that no rounding adds or drops a sample.
            plan.lattice.step_mm = 16.0 / f64::from(steps);
            for (renderer, _, _, pixel) in draw(&slab, &plan) {
                let found = 1.0 - f64::from(pixel[3]);
                let lost = f64::from(steps) * renderer.lost_per_sample;
                assert!(
                    (found - expected).abs() < 3e-6 + lost,
                    "{renderer}, {steps} steps: {found} instead of {expected}"
                );
            }
        }
    }
}

#[test]
fn a_sphere_passes_the_closed_form() {
    // Distance from the center in voxels: trilinear errors are below 1/(4r), 0.004 voxels here.
    const RADIUS: f64 = 66.0;
    let grid = centered([140; 3], DMat3::from_diagonal(DVec3::splat(0.25)));
    let distance = simple::volume(grid, |p| p.length() * 4.0);
    let radius_mm = RADIUS * 0.25;
    for (opacity, camera) in [
        (
            0.8,
            parallel(DVec3::new(0.5, 0.7, -0.2), 60.0, 0.9 * radius_mm),
        ),
        (0.05, from_eye(parallel(DVec3::Z, 60.0, 1.0), 0.25)),
    ] {
        let reference_mm = reference_mm(opacity, 2.0 * radius_mm) * 2.0;
        let entry = |opacity: f64| [1.0, 1.0, 1.0, opacity as f32];
        let edge = [(RADIUS - 0.001) as f32, (RADIUS + 0.001) as f32];
        let table = TransferTable::new(edge, reference_mm as f32, vec![entry(opacity), entry(0.0)]);
        let mut plan = plan(&distance, camera, table);
        plan.lattice.step_mm = radius_mm / 10_000.0;
        check(&distance, &plan, opacity, |origin, direction| {
            closed_form::chord_in_sphere(origin, direction, DVec3::ZERO, radius_mm)
        });
    }
}

#[test]
fn planes_and_boxes_cut_what_they_say() {
    for grid in grids() {
        let slab = simple::volume(grid, |_| 0.5);
        let diagonal = grid.bounds_mm().0.distance(grid.bounds_mm().1);
        let camera = parallel(DVec3::new(-0.3, 0.8, 0.5), 2.0 * diagonal, 0.25 * diagonal);
        let table = || white(0.5, reference_mm(0.5, diagonal));
        let step_mm = diagonal / 24_000.0;

        // Two planes leave a layer, of which a ray crosses thickness / cosine.
        let normal = DVec3::new(0.1, 0.9, 0.2).normalize();
        let mut layer = plan(&slab, camera, table());
        layer.lattice.step_mm = step_mm;
        let plane = |normal: DVec3, offset_mm: f64| simple::plane(normal, offset_mm);
        layer.ray_clips = vec![plane(normal, 0.5), plane(-normal, 0.4)];
        (layer.width, layer.height) = (3, 3);
        layer.camera = parallel(DVec3::new(-0.3, 0.8, 0.5), 2.0 * diagonal, 0.5);
        check(&slab, &layer, 0.5, |_, direction| {
            0.9 / direction.dot(normal)
        });

        // A turned box, kept inside and kept outside; as a grid of one voxel it has a chord.
        let axes = DMat3::from_rotation_y(0.5) * DMat3::from_diagonal(DVec3::new(3.0, 4.0, 2.5));
        let cut = centered([1; 3], axes);
        let of_box = |origin, direction| closed_form::chord_in_grid(origin, direction, &cut);
        for keep_inside in [true, false] {
            let mut plan = plan(&slab, camera, table());
            plan.lattice.step_mm = step_mm;
            plan.sample_clips = vec![simple::cut_box(cut.voxel_from_world(), keep_inside)];
            check(&slab, &plan, 0.5, |origin, direction| {
                let inside = of_box(origin, direction);
                if keep_inside {
                    inside
                } else {
                    closed_form::chord_in_grid(origin, direction, &grid) - inside
                }
            });
        }
    }
}

#[test]
fn halving_the_step_quarters_the_error() {
    // Samples in the middle of their steps: the midpoint rule, of order 2, for what passes. Within a
    // step color and opacity are constant, and what an error of the color weighs is again of order 2.
    let grid = centered([20; 3], DMat3::IDENTITY);
    let ramp = simple::volume(grid, |p| (p.y + 8.0) / 16.0);
    let opaque = f64::from(0.9f32);
    let entries = vec![[1.0, 0.2, 0.0, 0.0], [0.0, 0.6, 1.0, 0.9]];
    let table = TransferTable::new([0.0, 1.0], 4.0, entries);
    let mut plan = plan(&ramp, parallel(DVec3::Y, 20.0, 4.0), table);
    plan.ray_clips = [DVec3::Y, -DVec3::Y]
        .map(|normal| simple::plane(normal, 8.0))
        .to_vec();
    (plan.width, plan.height) = (2, 2);
    let exactly_passes = closed_form::transmittance_of_ramp(opaque, 4.0, 16.0);
    let field = truth::Voxels::new(&ramp, plan.field().reconstruct);
    plan.lattice.step_mm = 16.0 / 4096.0;
    let fine = truth::picture(&plan, &field)[0];
    assert!((1.0 - fine[3] - exactly_passes).abs() < 1e-6, "{fine:?}");
    for renderer in renderers() {
        let mut errors = Vec::new();
        for steps in [8, 16, 32] {
            plan.lattice.step_mm = 16.0 / f64::from(steps);
            let pixel = renderer.draw(&ramp, &plan).pixel(0, 0);
            let passes = (1.0 - f64::from(pixel[3]) - exactly_passes).abs();
            errors.push([passes, (f64::from(pixel[2]) - fine[2]).abs()]);
        }
        for pair in errors.windows(2) {
            for (coarse, half) in pair[0].iter().zip(pair[1]) {
                let order = (coarse / half).log2();
                assert!(
                    (1.8..2.2).contains(&order),
                    "{}: order {order}, errors {errors:?}",
                    renderer.name
                );
            }
        }
    }
}

#[test]
fn ending_early_costs_no_more_than_the_light_that_still_passed() {
    use crate::random::{Random, renderers_of, seeds};
    use crate::simple::draw_by;
    use strahl_scene::plan::Composite;
    let (mut ended, mut drawn) = (0, 0);
    for seed in seeds(150) {
        let mut random = Random::new(seed ^ 0xEA21);
        let volume = random.volume();
        let mut plan = random.plan(&volume, [9, 7]);
        plan.technique_mut().shade = strahl_scene::plan::Shade::Unlit;
        plan.lights.clear();
        let stop = 0.2;
        let composite = |stop_at_transmittance| Composite::EmissionAbsorption {
            stop_at_transmittance,
        };
        plan.technique_mut().composite = composite(0.0);
        let renderers = renderers_of(seed);
        let full = draw_by(&renderers, &volume, &plan);
        plan.technique_mut().composite = composite(stop);
        let early = draw_by(&renderers, &volume, &plan);
        for (full, early) in full.iter().zip(&early) {
            drawn += 1;
            ended += usize::from(full.3 != early.3);
            for (a, b) in full.3.iter().zip(early.3) {
                // Colors and background are at most 1.
                assert!((a - b).abs() <= stop + 1e-6, "{full:?} {early:?}");
            }
        }
    }
    assert!(ended > 20, "{ended} of {drawn} rays ended early");
}
