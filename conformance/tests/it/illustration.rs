//! Slot illustrate against its formulas, in double precision, on each renderer.

use crate::simple::{centered, draw, from_eye, one_sample_at, parallel, plan, volume, white};
use glam::{DMat3, DVec3};
use strahl_scene::plan::*;
use strahl_scene::transfer::TransferTable;
use strahl_volume::Volume;

/// A sample of each ray in the middle of a ramp that rises by 10 per mm along `normal`, seen from `to_eye`; its color
/// is white without illustration.
fn ramp(normal: DVec3, to_eye: DVec3) -> (Volume, Plan) {
    let grid = centered([12; 3], DMat3::IDENTITY);
    let volume = volume(grid, |place| 50.0 + 10.0 * normal.dot(place));
    let mut plan = plan(&volume, parallel(-to_eye, 40.0, 2.0), white(1.0, 1.0));
    (plan.width, plan.height) = (3, 3);
    one_sample_at(&mut plan, 0.0);
    (volume, plan)
}

fn near(what: &str, found: f32, expected: f64, tolerance: f64) {
    assert!(
        (f64::from(found) - expected).abs() <= tolerance,
        "{what}: {found}, not {expected}"
    );
}

#[test]
fn silhouettes_are_dark_by_slant_and_steepness() {
    let normal = DVec3::new(0.48, 0.6, 0.64);
    let mut darkest = 1.0f64;
    for (cosine, from_slant, to_slant) in [
        (0.95f64, 0.2, 0.7),
        (0.5, 0.2, 0.7),
        (0.2, 0.2, 0.7),
        // The other way round: what faces the eye is dark.
        (0.95, 0.7, 0.2),
        (0.5, 0.7, 0.2),
    ] {
        for (full_per_mm, gradient_weight) in
            [(5.0f64, 0.5f64), (40.0, 0.5), (40.0, 2.0), (40.0, 0.0)]
        {
            let across = normal.any_orthonormal_vector();
            let to_eye = cosine * normal + (1.0 - cosine * cosine).sqrt() * across;
            let (volume, mut plan) = ramp(normal, to_eye);
            plan.technique_mut().illustrate = Illustrate::Silhouette {
                strength: 3.0,
                gradient_weight: gradient_weight as f32,
                full_per_mm: full_per_mm as f32,
                from_slant: from_slant as f32,
                to_slant: to_slant as f32,
            };
            let rise = ((1.0 - cosine - from_slant) / (to_slant - from_slant)).clamp(0.0, 1.0);
            let steep = (10.0 / full_per_mm).min(1.0).powf(gradient_weight);
            let expected = (-3.0 * steep * rise * rise * (3.0 - 2.0 * rise)).exp();
            darkest = darkest.min(expected);
            for (renderer, _, _, pixel) in draw(&volume, &plan) {
                let what = format!("{renderer} {cosine} {from_slant} {full_per_mm}");
                near(&what, pixel[0], expected, 2e-4);
                near(&what, pixel[3], 1.0, 1e-6);
            }
        }
    }
    assert!(darkest < 0.06, "{darkest}");
}

#[test]
fn what_lies_farther_away_has_more_of_the_color_of_the_depth_cue() {
    let (volume, mut plan) = ramp(DVec3::X, DVec3::Z);
    for is_perspective in [false, true] {
        if is_perspective {
            plan.camera = from_eye(plan.camera, 0.05);
        }
        for (depth_mm, share) in [
            (36.0, 0.0),
            (38.0, 0.0),
            (39.5, 0.25),
            (41.0, 0.5),
            (44.0, 1.0),
        ] {
            plan.technique_mut().illustrate = Illustrate::DepthCue {
                strength: 0.8,
                nearest_mm: 38.0,
                farthest_mm: 44.0,
                red: 0.1,
                green: 0.5,
                blue: 1.0,
            };
            plan.ray_clips.clear();
            one_sample_at(&mut plan, depth_mm - 40.0);
            for (renderer, x, y, pixel) in draw(&volume, &plan) {
                for (found, color) in pixel.into_iter().zip([0.1, 0.5, 1.0]) {
                    let expected = 1.0 + 0.8 * share * (color - 1.0);
                    // Slanted rays have their sample a little behind the middle of the slab.
                    near(
                        &format!("{renderer} {depth_mm} {x} {y}"),
                        found,
                        expected,
                        1e-4,
                    );
                }
            }
        }
    }
}

#[test]
fn contour_lines_have_one_width_on_spheres_of_any_size() {
    // Spheres are the isosurfaces; differences of a square are exact.
    let grid = centered([25; 3], DMat3::IDENTITY);
    let volume = volume(grid, |place| place.length_squared());
    let mut plan = plan(&volume, parallel(-DVec3::Z, 40.0, 9.0), white(1.0, 1.0));
    (plan.width, plan.height) = (31, 31);
    let (width, reach, strength, softness) = (1.5f64, 1.0f64, 0.75, 0.5);
    plan.technique_mut().illustrate = Illustrate::ContourLines {
        width_mm: width as f32,
        reach_mm: reach as f32,
        strength: strength as f32,
        softness: softness as f32,
    };
    let (mut dark, mut light) = (0, 0);
    for z in [0.5, 2.0, 4.0] {
        plan.ray_clips.clear();
        // Along the ray, which comes from above.
        one_sample_at(&mut plan, -z);
        for (renderer, x, y, pixel) in draw(&volume, &plan) {
            let place = |i: u32| (2.0 * (f64::from(i) + 0.5) / 31.0 - 1.0) * 9.0;
            let radius_squared = place(x).powi(2) + place(y).powi(2) + z * z;
            let curvature = 1.0 / (radius_squared + 0.25 * reach * reach).sqrt();
            let bent = (width * curvature).min(1.0);
            let limit = (bent * (2.0 - bent)).sqrt();
            let facing = z / radius_squared.sqrt();
            let inside = ((limit - facing) / (softness * limit)).clamp(0.0, 1.0);
            let expected = 1.0 - strength * inside;
            near(&format!("{renderer} {x} {y} {z}"), pixel[0], expected, 1e-3);
            dark += usize::from(expected < 0.5);
            light += usize::from(expected > 0.99);
        }
    }
    assert!(dark > 500 && light > 500, "{dark} {light}");
}

#[test]
fn without_a_gradient_there_is_no_line_and_no_silhouette() {
    let grid = centered([8; 3], DMat3::IDENTITY);
    let volume = volume(grid, |_| 7.0);
    for illustrate in [
        Illustrate::Silhouette {
            strength: 4.0,
            gradient_weight: 0.0,
            full_per_mm: 1.0,
            from_slant: 0.0,
            to_slant: 0.5,
        },
        Illustrate::ContourLines {
            width_mm: 2.0,
            reach_mm: 1.0,
            strength: 1.0,
            softness: 0.5,
        },
    ] {
        let mut plan = plan(&volume, parallel(DVec3::Y, 40.0, 2.0), white(1.0, 1.0));
        (plan.width, plan.height) = (3, 3);
        one_sample_at(&mut plan, 0.0);
        plan.technique_mut().illustrate = illustrate;
        for (renderer, _, _, pixel) in draw(&volume, &plan) {
            near(&format!("{renderer}"), pixel[0], 1.0, 0.0);
        }
    }
}

#[test]
fn halos_are_as_dark_as_the_ring_in_front_is_covered() {
    // A wall, and before it half a plate that ends at x = 0.
    let grid = centered([25; 3], DMat3::IDENTITY);
    let volume = volume(grid, |place| {
        let is_wall = place.z < -5.5;
        let is_plate = place.x < 0.0 && (2.0..6.0).contains(&place.z);
        f64::from(u8::from(is_wall || is_plate))
    });
    let entries = vec![[1.0, 1.0, 1.0, 0.0], [1.0, 1.0, 1.0, 1.0]];
    let table = TransferTable::new([0.0, 1.0], 1.0, entries);
    let mut plan = plan(&volume, parallel(-DVec3::Z, 40.0, 7.0), table);
    plan.lattice.step_mm = 1.0;
    (plan.width, plan.height) = (28, 21);
    one_sample_at(&mut plan, 8.0);
    let (width, strength) = (3.0, 0.8);
    plan.technique_mut().illustrate = Illustrate::Halo {
        width_mm: width as f32,
        reach_mm: 20.0,
        strength: strength as f32,
        steps: 20,
    };
    let aspect = f64::from(plan.width) / f64::from(plan.height);
    let mut counts = [0; 9];
    for (renderer, x, y, pixel) in draw(&volume, &plan) {
        let across = (2.0 * (f64::from(x) + 0.5) / f64::from(plan.width) - 1.0) * 7.0 * aspect;
        let place = across * plan.camera.right.x;
        let places = (0..8).map(|i| {
            let radius = if i % 2 == 1 { 0.5 * width } else { width };
            place + radius * (f64::from(i) * std::f64::consts::FRAC_PI_4).sin()
        });
        let places: Vec<_> = places.collect();
        // Voxels at the edge are mixed, and the plate ends with the volume.
        if place.abs() > 8.0 || places.iter().any(|x| (-1.0..0.5).contains(x)) {
            continue;
        }
        let covered = places.iter().filter(|x| **x < 0.0).count();
        counts[covered] += 1;
        let expected = 1.0 - strength * (covered as f64 / 4.0).min(1.0);
        near(&format!("{renderer} {x} {y}"), pixel[0], expected, 1e-4);
        near(&format!("{renderer} {x} {y}"), pixel[3], 1.0, 1e-4);
    }
    assert!(counts[0] > 0 && counts[8] > 0, "{counts:?}");
    assert!(counts[1..8].iter().any(|count| *count > 0), "{counts:?}");
}
