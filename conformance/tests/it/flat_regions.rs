//! Where values are equal there is no gradient, whatever rounding makes of the numbers: labels, air, everything that
//! was cut off at a threshold. Otherwise speckle is lit there, and no two renderers agree on it.

use crate::random::{Random, seeds};
use crate::simple::{centered, of_samples, parallel, plan};
use glam::{DMat3, DVec3};
use std::sync::atomic::{AtomicU64, Ordering};
use strahl_conformance::agreement::agreement;
use strahl_conformance::{Renderer, renderers};
use strahl_scene::plan::*;
use strahl_scene::transfer::TransferTable;
use strahl_shader::registry::Function;
use strahl_volume::{Metadata, Rescale, Samples, Volume};

/// Of every reconstruction, estimate of the gradient, and what it is taken of, a Plan.
fn each_gradient(plan: &Plan, mut with: impl FnMut(&str, &Plan)) {
    let of_registry = |slot| Function::of_slot(slot).filter(|f| f.is_way_of.is_none());
    let none = |name: &str| panic!("{name}: no parameters are expected");
    for reconstruct in of_registry("reconstruct") {
        for method in of_registry("gradient") {
            for input in [GradientInput::Value, GradientInput::Opacity] {
                let mut plan = plan.clone();
                let field = plan.field_mut();
                field.reconstruct = Reconstruct::of(reconstruct.name, none).unwrap();
                field.gradient = GradientMethod::of(method.name, none).unwrap();
                plan.technique_mut().gradient_input = input;
                let name = format!("{} {} {input:?}", reconstruct.name, method.name);
                with(&name, &plan);
            }
        }
    }
}

/// Blocks of equal numbers, up to 7 of them.
fn blocks(random: &mut Random, rescale: Rescale, of: impl Fn(u8) -> f32) -> Volume {
    const EDGE: usize = 24;
    let labels: Vec<u8> = (0..27).map(|_| random.below(7) as u8).collect();
    let at = |i: usize| labels[i % EDGE / 8 + i / EDGE % EDGE / 8 * 3 + i / EDGE / EDGE / 8 * 9];
    let numbers = (0..EDGE * EDGE * EDGE).map(|i| of(at(i))).collect();
    let grid = centered([EDGE; 3], DMat3::from_diagonal(DVec3::new(1.0, 1.1, 0.9)));
    Volume::new(grid, Samples::F32(numbers), rescale, Metadata::default()).unwrap()
}

/// Half opaque, of many colors, over these values.
fn many_colors(domain: [f32; 2]) -> TransferTable {
    let entries = (0..256).map(|i| {
        let v = i as f32 / 255.0;
        [1.0 - v, v, 0.5 + 0.5 * (9.0 * v).sin(), 0.3 + 0.6 * v]
    });
    TransferTable::new(domain, 1.0, entries.collect())
}

fn lit(volume: &Volume, direction: DVec3, table: TransferTable) -> Plan {
    let mut plan = plan(volume, parallel(direction, 60.0, 14.0), table);
    (plan.width, plan.height) = (24, 20);
    plan.lights = vec![PlanLight::Head { radiance: [1.0; 3] }];
    plan.technique_mut().shade = Shade::Lit {
        ambient: 0.1,
        illuminate: Illuminate::Lambert { diffuse: 0.9 },
        keep_last_normal: false,
    };
    plan
}

static CASES: AtomicU64 = AtomicU64::new(0);

/// Numbers that no sum of weights keeps, also far from the zero of their values.
#[test]
fn renderers_agree_inside_of_labels() {
    for seed in seeds(1) {
        let mut random = Random::new(seed);
        let hounsfield = Rescale {
            slope: 0.7,
            intercept: -1024.0,
        };
        for (rescale, domain) in [
            (Rescale::IDENTITY, [0.0, 70.0]),
            (hounsfield, [-1024.0, -975.0]),
        ] {
            let volume = blocks(&mut random, rescale, |label| f32::from(label) * 9.7);
            let direction = random.direction();
            let plan = lit(&volume, direction, many_colors(domain));
            each_gradient(&plan, |name, plan| {
                // It swings around every edge: nothing is flat.
                if plan.field().reconstruct == Reconstruct::BSplineInterpolating {
                    return;
                }
                // Making a pipeline for each of them takes longer than all else.
                let cases = CASES.fetch_add(1, Ordering::Relaxed);
                let now = |renderer: &Renderer| cases.is_multiple_of(renderer.one_in.div_ceil(5));
                let mut drawn = renderers()
                    .into_iter()
                    .filter(now)
                    .map(|renderer| (renderer, renderer.draw(&volume, plan)));
                let (_, first) = drawn.next().unwrap();
                for (renderer, image) in drawn {
                    let psnr_db = agreement(&first, &image).psnr_db;
                    assert!(
                        psnr_db >= 45.0,
                        "seed {seed}, {name}: {renderer} {psnr_db:.1} dB"
                    );
                }
            });
        }
    }
}

/// Exactly none, of values and of opacities.
#[test]
fn equal_voxels_have_no_gradient() {
    for number in [0.1f32, 7.7, 1234.5, -3.3e-5] {
        let grid = centered([6, 7, 8], DMat3::IDENTITY);
        let volume = of_samples(grid, Samples::F32(vec![number; 6 * 7 * 8]));
        let around = [number - 0.3 * number.abs(), number + 0.5 * number.abs()];
        let direction = DVec3::new(0.3, 0.7, -0.5);
        let mut plan = lit(&volume, direction, many_colors(around));
        plan.technique_mut().composite = Composite::Debug(DebugView::GradientRaw);
        each_gradient(&plan, |name, plan| {
            // The third one is the second on a device.
            for renderer in renderers().into_iter().take(2) {
                let image = renderer.draw(&volume, plan);
                let mut hit = image.pixels().iter().filter(|pixel| pixel[3] > 0.0);
                let is_none = |pixel: &&[f32; 4]| pixel[..3] != [0.5; 3];
                assert!(hit.clone().count() > 20, "{name}: {renderer}");
                assert_eq!(hit.find(is_none), None, "{number} {name}: {renderer}");
            }
        });
    }
}

/// What is not made by rounding is a gradient, however small: here ten times what would not count.
#[test]
fn small_gradients_are_gradients() {
    let grid = centered([9; 3], DMat3::IDENTITY);
    let of_rounding = 1.0 / f64::from(1u32 << 18);
    for (factor, is_lit) in [(10.0, true), (0.3, false)] {
        let volume = crate::simple::volume(grid, |place| 1.0 + factor * of_rounding * place.x);
        let domain = [0.5, 1.5];
        let mut plan = lit(&volume, DVec3::Z, many_colors(domain));
        plan.technique_mut().composite = Composite::Debug(DebugView::Normal);
        for method in Function::of_slot("gradient") {
            plan.field_mut().gradient =
                GradientMethod::of(method.name, |_| unreachable!()).unwrap();
            for renderer in renderers() {
                let image = renderer.draw(&volume, &plan);
                let middle = image.pixels()[(10 * 24 + 12) as usize];
                let expected = if is_lit { 1.0 } else { 0.5 };
                assert!(
                    (middle[0] - expected).abs() < 0.02,
                    "{}: {renderer}: {middle:?}",
                    method.name
                );
            }
        }
    }
}
