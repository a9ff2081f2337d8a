//! Functions against their formulas, in double precision: each renderer draws what the paper says, not only what the
//! other renderers do.

use crate::importance::Seen;
use crate::simple::{centered, cut_box, draw, of_samples, one_sample_at, parallel, plan, white};
use glam::{DAffine3, DMat3, DVec3};
use strahl_scene::plan::*;
use strahl_scene::transfer::TransferTable;
use strahl_volume::{Samples, Volume};

/// A column along z, one voxel per number, 1 mm apart.
fn column(numbers: &[f32]) -> Volume {
    let n = numbers.len();
    let numbers = numbers.iter().flat_map(|number| [*number; 4]);
    of_samples(
        centered([2, 2, n], DMat3::IDENTITY),
        Samples::F32(numbers.collect()),
    )
}

/// Straight down the middle of a column from its first number on, a sample at each voxel.
fn down(volume: &Volume, table: TransferTable) -> Plan {
    let mut plan = plan(volume, parallel(DVec3::Z, 50.0, 0.01), table);
    (plan.width, plan.height) = (1, 1);
    plan.field_mut().reconstruct = Reconstruct::Nearest;
    plan.lattice.step_mm = 1.0;
    plan
}

fn near(what: &str, found: f32, expected: f64, tolerance: f64) {
    assert!(
        (f64::from(found) - expected).abs() <= tolerance,
        "{what}: {found}, not {expected}"
    );
}

/// Of a light.
const RADIANCE: [f32; 3] = [0.8, 0.5, 0.2];

/// A ramp that rises along `normal`, and a Plan that shows one sample of it, seen from `to_eye` and lit from `to_light`.
fn lit_ramp(
    [normal, to_eye, to_light]: [DVec3; 3],
    table: TransferTable,
    illuminate: Illuminate,
) -> (Volume, Plan) {
    let grid = centered([12; 3], DMat3::IDENTITY);
    let volume = crate::simple::volume(grid, |place| 50.0 + 10.0 * normal.dot(place));
    let mut plan = plan(&volume, parallel(-to_eye, 40.0, 2.0), table);
    (plan.width, plan.height) = (3, 3);
    one_sample_at(&mut plan, 0.0);
    plan.lights = vec![PlanLight::Directional {
        to_light,
        radiance: RADIANCE,
    }];
    plan.technique_mut().shade = Shade::Lit {
        ambient: 0.1,
        illuminate,
        keep_last_normal: false,
    };
    (volume, plan)
}

/// Numbers from 0 to 200, some larger than all before them.
const NUMBERS: [f32; 8] = [20.0, 60.0, 10.0, 90.0, 90.0, 50.0, 140.0, 30.0];

/// Color and opacity of a number.
fn look(number: f64) -> (DVec3, f64) {
    let v = number / 200.0;
    (DVec3::new(v, 1.0 - v, v * v), 0.2 + 0.3 * v)
}

/// The table of [`look`].
fn looks() -> TransferTable {
    let entries = (0..201).map(|i| {
        let (color, opacity) = look(f64::from(i));
        let [r, g, b] = color.to_array();
        [r, g, b, opacity].map(|number| number as f32)
    });
    TransferTable::new([0.0, 200.0], 1.0, entries.collect())
}

/// The steepest central difference of a ray, over white.
#[test]
fn gmip_is_the_largest_gradient() {
    let numbers = [3.0, 3.0, 5.0, 11.0, 2.0, 2.5, 2.5, 40.0, 39.0, 39.0];
    let volume = column(&numbers);
    let mut plan = down(&volume, white(1.0, 1.0));
    plan.technique_mut().composite = Composite::Gmip { white_per_mm: 25.0 };
    let at = |i: usize| f64::from(numbers[i.min(numbers.len() - 1)]);
    let differences = (0..numbers.len()).map(|i| 0.5 * (at(i + 1) - at(i.saturating_sub(1))).abs());
    let steepest = differences.fold(0.0, f64::max);
    assert_eq!(steepest, 18.75);
    for (renderer, _, _, pixel) in draw(&volume, &plan) {
        near(renderer.name, pixel[0], steepest / 25.0, 1e-5);
        assert_eq!(pixel[3], 1.0);
    }
}

/// S. Bruckner and E. Gröller 2009, equations 3 to 5, over known samples: what lies in front fades where the ray meets a
/// larger value, by the rise; γ from −1, where nothing fades, to 0. Above 0 the sum fades to the largest value.
#[test]
fn mida_is_the_sum_of_the_paper() {
    let volume = column(&NUMBERS);
    for blend in [-1.0f32, -0.6, 0.0, 0.4, 1.0] {
        let mut plan = down(&volume, looks());
        plan.technique_mut().composite = Composite::Mida {
            low: 0.0,
            high: 150.0,
            blend,
            stop_at_transmittance: 0.0,
        };
        let blend = f64::from(blend);
        let (mut color, mut alpha, mut largest) = (DVec3::ZERO, 0.0f64, 0.0f64);
        for number in NUMBERS.map(f64::from) {
            let share = number / 150.0;
            let rise = (share - largest).max(0.0);
            largest = largest.max(share);
            // β = 1 − δ·(1 + γ).
            let kept = 1.0 - rise * (1.0 + blend.min(0.0));
            let (own, opacity) = look(number);
            color = kept * color + (1.0 - kept * alpha) * opacity * own;
            alpha = kept * alpha + (1.0 - kept * alpha) * opacity;
        }
        let (own, opacity) = look(140.0);
        let maximum = blend.max(0.0);
        color = (1.0 - maximum) * color + maximum * opacity * own;
        alpha = (1.0 - maximum) * alpha + maximum * opacity;
        for (renderer, _, _, pixel) in draw(&volume, &plan) {
            for (c, expected) in color.to_array().into_iter().chain([alpha]).enumerate() {
                near(
                    &format!("{renderer} {blend} channel {c}"),
                    pixel[c],
                    expected,
                    2e-5,
                );
            }
        }
    }
}

/// F. de Moura Pinto and C. M. D. S. Freitas 2010, with the importance of a sample by its gradient or by its value.
#[test]
fn samples_are_as_important_as_their_gradients_or_values() {
    let volume = column(&NUMBERS);
    let at = |i: usize| f64::from(NUMBERS[i.min(NUMBERS.len() - 1)]);
    let by_gradient = |i: usize| 0.5 * (at(i + 1) - at(i.saturating_sub(1))).abs() / 40.0;
    let by_value = |i: usize| (at(i) - 20.0) / 80.0;
    let (gain, mut found) = (3.0f32, Vec::new());
    for (measure, share) in [(0, &by_gradient as &dyn Fn(usize) -> f64), (3, &by_value)] {
        let mut plan = down(&volume, looks());
        plan.technique_mut().composite = Composite::ImportanceAware {
            measure,
            gain,
            first: 1.0,
            second: 0.2,
            third: 0.6,
            full_per_mm: 40.0,
            low: 20.0,
            high: 100.0,
        };
        let mut seen = Seen::default();
        for (i, number) in NUMBERS.into_iter().enumerate() {
            let (color, opacity) = look(f64::from(number));
            let importance = f64::from(gain) * share(i).clamp(0.0, 1.0);
            seen.add((opacity * color).to_array(), opacity, importance);
        }
        let expected = seen.color.into_iter().chain([seen.alpha]);
        for (renderer, _, _, pixel) in draw(&volume, &plan) {
            for (found, expected) in pixel.into_iter().zip(expected.clone()) {
                near(&format!("{renderer} {measure}"), found, expected, 2e-5);
            }
        }
        found.push(seen.color);
    }
    let [a, b] = [0, 1].map(|i| DVec3::from_array(found[i]));
    assert!(a.distance(b) > 0.01, "{a} {b}");
}

/// The length of a chord through an ellipsoid and through the cylinder along z, inside and around.
#[test]
fn clips_of_round_shapes_leave_their_chords() {
    let volume = of_samples(
        centered([20; 3], DMat3::IDENTITY),
        Samples::U8(vec![200; 8000]),
    );
    // Axes of 6, 4 and 8 mm, the center off the middle, turned.
    let turned = DMat3::from_rotation_z(0.4) * DMat3::from_rotation_x(0.7);
    let center = DVec3::new(0.7, -0.4, 0.9);
    let semi = DVec3::new(6.0, 4.0, 8.0);
    let world_from_unit =
        DAffine3::from_mat3_translation(turned * DMat3::from_diagonal(2.0 * semi), center);
    for shape in [ClipShape::Ellipsoid, ClipShape::Cylinder, ClipShape::Box] {
        for keep_inside in [true, false] {
            let mut plan = plan(&volume, parallel(DVec3::Z, 60.0, 8.0), white(1.0, 1.0));
            (plan.width, plan.height) = (15, 15);
            plan.lattice.step_mm = 0.01;
            plan.technique_mut().composite =
                Composite::Debug(DebugView::SampleCount { white: 4000.0 });
            plan.sample_clips = vec![SampleClip {
                shape,
                ..cut_box(world_from_unit.inverse(), keep_inside)
            }];
            let renderers: Vec<_> = strahl_conformance::renderers()
                .into_iter()
                .take(2)
                .collect();
            for (renderer, x, y, pixel) in crate::simple::draw_by(&renderers, &volume, &plan) {
                let ray = plan.camera.ray(x, y, 15, 15);
                let inside = |z: f64| {
                    let world = DVec3::new(ray.origin_mm.x, ray.origin_mm.y, z);
                    let own = turned.transpose() * (world - center) / semi;
                    match shape {
                        ClipShape::Ellipsoid => own.length() <= 1.0,
                        ClipShape::Cylinder => own.truncate().length() <= 1.0 && own.z.abs() <= 1.0,
                        _ => own.abs().max_element() <= 1.0,
                    }
                };
                let kept =
                    (0..40_000).filter(|i| inside(-10.0 + f64::from(*i) * 5e-4) == keep_inside);
                let length_mm = kept.count() as f64 * 5e-4;
                let found_mm = f64::from(pixel[0]) * 40.0;
                // A sample more or less at either end of a chord.
                assert!(
                    (found_mm - length_mm).abs() <= 0.025,
                    "{renderer} {shape:?} {keep_inside} ({x}, {y}): {found_mm}, not {length_mm}"
                );
            }
        }
    }
}

/// Gray from black to white above a threshold, nothing up to it.
#[test]
fn thresholds_show_what_is_above_them() {
    for (value, expected) in [
        (40.0f32, 0.0),
        (50.0, 0.0),
        (50.5, 0.405),
        (80.0, 0.7),
        (130.0, 1.0),
    ] {
        let volume = column(&[value; 4]);
        let mut plan = down(&volume, white(1.0, 1.0));
        one_sample_at(&mut plan, 0.0);
        plan.technique_mut().classify = Classify::Threshold {
            threshold: 50.0,
            black: 10.0,
            white: 110.0,
        };
        for (renderer, _, _, pixel) in draw(&volume, &plan) {
            near(&format!("{renderer} {value}"), pixel[3], expected, 1e-5);
            near(
                &format!("{renderer} {value}"),
                pixel[0],
                expected * expected,
                1e-5,
            );
        }
    }
}

/// ambient·c + Σ radiance·(diffuse·c·|N·L| + specular·|N·H|^shininess), with absolute values of both products.
#[test]
fn two_sided_blinn_phong_has_absolute_products() {
    let normal = DVec3::new(0.3, -0.2, -0.9).normalize();
    let eye = DVec3::new(0.1, 0.2, -1.0).normalize();
    let own = [0.9f32, 0.5, 0.2];
    let table = TransferTable::new([0.0, 1.0], 1.0, vec![[own[0], own[1], own[2], 1.0]; 2]);
    // From the side of the eye, from behind, from behind with a half vector that points away, from along the surface.
    for to_light in [
        DVec3::new(0.7, 0.1, -0.6),
        DVec3::new(0.2, -0.3, 0.9),
        DVec3::new(-0.9, 0.3, 1.5),
        normal.cross(eye),
    ] {
        let light = to_light.normalize();
        // Without highlights and with an ambient share of 1 − p, this is the color between itself and its darkening.
        for specular in [0.3, 0.0] {
            let model = Illuminate::BlinnPhongTwoSided {
                diffuse: 0.6,
                specular,
                shininess: 5.0,
            };
            let (volume, plan) = lit_ramp([normal, eye, light], table.clone(), model);
            let half = (light + eye).normalize();
            let matt = 0.6 * normal.dot(light).abs();
            let highlight = f64::from(specular) * normal.dot(half).abs().powi(5);
            let mut renderers = Vec::new();
            for (renderer, _, _, pixel) in draw(&volume, &plan) {
                renderers.push(renderer.name);
                for ((found, own), radiance) in pixel.into_iter().zip(own).zip(RADIANCE) {
                    let [own, radiance] = [own, radiance].map(f64::from);
                    let expected = 0.1 * own + radiance * (matt * own + highlight);
                    let what = format!("{renderer} {light} {specular}");
                    near(&what, found, expected, 1e-4);
                }
            }
            assert!(renderers.contains(&"cpu") && renderers.contains(&"evaluator"));
        }
    }
}

/// R. Cook and K. Torrance 1982: D of B. Walter et al. 2007, G of E. Heitz 2014 (height-correlated Smith) and F of C.
/// Schlick 1994, as they are printed there; everything times π, as the diffuse part is.
#[test]
fn cook_torrance_is_d_times_f_times_g() {
    let normal = DVec3::new(0.3, -0.2, -0.9).normalize();
    let eye = DVec3::new(0.1, 0.2, -1.0).normalize();
    for to_light in [
        DVec3::new(0.7, 0.1, -0.6),
        DVec3::new(-0.5, -0.8, -0.3),
        eye,
    ] {
        let light = to_light.normalize();
        for (roughness, reflectance) in [(0.1f32, 0.04f32), (0.4, 0.3), (1.0, 0.9)] {
            let model = Illuminate::CookTorrance {
                diffuse: 0.6,
                roughness,
                reflectance,
            };
            let (volume, plan) = lit_ramp([normal, eye, light], white(1.0, 1.0), model);
            let alpha2 = f64::from(roughness).powi(4);
            let half = (light + eye).normalize();
            let [nl, nv, nh, lh] = [
                normal.dot(light),
                normal.dot(eye),
                normal.dot(half),
                light.dot(half),
            ];
            // π·D, and G₂ by the two Λ.
            let d = alpha2 / (nh * nh * (alpha2 - 1.0) + 1.0).powi(2);
            let lambda = |cosine: f64| {
                let tan2 = 1.0 / (cosine * cosine) - 1.0;
                0.5 * ((1.0 + alpha2 * tan2).sqrt() - 1.0)
            };
            let g = 1.0 / (1.0 + lambda(nl) + lambda(nv));
            let f0 = f64::from(reflectance);
            let f = f0 + (1.0 - f0) * (1.0 - lh).powi(5);
            let mirrored = d * f * g / (4.0 * nl * nv);
            for (renderer, _, _, pixel) in draw(&volume, &plan) {
                for (found, radiance) in pixel.into_iter().zip(RADIANCE) {
                    let expected = match nl > 0.0 {
                        true => 0.1 + f64::from(radiance) * nl * (0.6 + mirrored),
                        false => 0.1,
                    };
                    near(
                        &format!("{renderer} {roughness} {light}"),
                        found,
                        expected,
                        2e-3 * expected.max(1.0),
                    );
                }
            }
        }
    }
}

/// Opacity times min(|gradient| / full, 1).
#[test]
fn gradient_opacity_is_opacity_times_the_gradient() {
    let volume = crate::simple::volume(centered([12; 3], DMat3::IDENTITY), |place| 10.0 * place.y);
    for (full_per_mm, share) in [(40.0f32, 0.25), (10.0, 1.0), (5.0, 1.0)] {
        let mut plan = plan(&volume, parallel(DVec3::Z, 40.0, 2.0), white(0.5, 1.0));
        plan.lattice.step_mm = 1.0;
        one_sample_at(&mut plan, 0.0);
        plan.technique_mut().shade = Shade::GradientOpacity { full_per_mm };
        for (renderer, _, _, pixel) in draw(&volume, &plan) {
            for found in pixel {
                near(&format!("{renderer}"), found, 0.5 * share, 1e-5);
            }
        }
    }
}

/// Between two voxels, the premultiplied mean of what both look like: not the look of the value between them.
#[test]
fn pre_classified_voxels_are_mixed() {
    let volume = column(&[0.0, 100.0, 0.0, 100.0, 0.0, 100.0]);
    let entry = |r: f32, g: f32, a: f32| [r, g, 0.0, a];
    let entries = vec![
        entry(1.0, 0.0, 0.2),
        entry(0.0, 0.0, 1.0),
        entry(0.0, 1.0, 0.6),
    ];
    let table = TransferTable::new([0.0, 100.0], 1.0, entries);
    for part in [0.25, 0.5, 0.75] {
        let mut plan = down(&volume, table.clone());
        plan.field_mut().reconstruct = Reconstruct::Trilinear;
        plan.technique_mut().classify = Classify::PreClassified;
        // Between the voxels 2 and 3, at −0.5 and 0.5 mm.
        one_sample_at(&mut plan, part - 0.5);
        for (renderer, _, _, pixel) in draw(&volume, &plan) {
            let expected = [
                0.2 * (1.0 - part),
                0.6 * part,
                0.0,
                0.2 * (1.0 - part) + 0.6 * part,
            ];
            for (found, expected) in pixel.into_iter().zip(expected) {
                near(&format!("{renderer} {part}"), found, expected, 1e-5);
            }
        }
    }
}
