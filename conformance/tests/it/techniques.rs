//! Layers that are drawn by techniques of their own.

use crate::graph::twice;
use crate::random::{Random, seeds};
use crate::simple::{blinn_phong, white};
use crate::variants::{change_all, distance, draw, pair, ramp, two};
use std::sync::Arc;
use strahl_conformance::agreement::agreement;
use strahl_conformance::device;
use strahl_evaluate::Evaluator;
use strahl_program::{Functions, loop_of};
use strahl_scene::plan::*;
use strahl_scene::{Headers, Scene, resolve_with};
use strahl_shader::{Linker, Program, Texels, ray_loop};
use strahl_volume::{Control, Datasets};

/// Any technique for values of `range`. Not both an opacity that follows the gradient, and a gradient of the
/// opacity, are in one Plan: `resolve` refuses it.
pub fn any_technique(random: &mut Random, [low, high]: [f32; 2], of_opacity: bool) -> Technique {
    let gradient_input = if of_opacity {
        random.pick(&[GradientInput::Value, GradientInput::Opacity])
    } else {
        GradientInput::Value
    };
    let steep = (high - low) / 4.0;
    let grey = Classify::Identity {
        black: low - 1.0,
        white: high * 1.5,
    };
    let by_gradient = Classify::GradientTable {
        low_per_mm: 0.05 * steep,
        high_per_mm: 0.5 * steep,
    };
    Technique {
        classify: random.pick(&[
            Classify::Table,
            Classify::PreClassified,
            if of_opacity { grey } else { by_gradient },
            Classify::Threshold {
                threshold: 0.6 * low + 0.4 * high,
                black: low,
                white: 2.0 * high,
            },
        ]),
        table: match random.once_in(2) {
            true => ramp(),
            false => white(0.2, 1.0),
        },
        gradient_input,
        shade: random.pick(&[
            Shade::Unlit,
            blinn_phong(0.2, 0.7, 0.2, 9.0),
            blinn_phong(0.4, 0.3, 0.0, 1.0),
            Shade::Lit {
                ambient: 0.2,
                illuminate: Illuminate::CookTorrance {
                    diffuse: 0.6,
                    roughness: 0.4,
                    reflectance: 0.1,
                },
                keep_last_normal: true,
            },
            Shade::GradientOpacity { full_per_mm: steep },
        ]),
        illustrate: any_illustration(random, steep),
        composite: Composite::EmissionAbsorption {
            stop_at_transmittance: 1.0 / 256.0,
        },
    }
}

pub fn light() -> Vec<PlanLight> {
    vec![PlanLight::Directional {
        to_light: glam::DVec3::new(0.6, -0.8, 0.0),
        radiance: [1.0, 0.9, 0.8],
    }]
}

#[test]
fn each_layer_is_drawn_by_its_technique() {
    let (a, b) = pair();
    let data = Datasets {
        volumes: vec![a.clone(), b.clone()],
        ..Datasets::default()
    };
    let mut plan = two(&a, &b);
    plan.lights = light();
    let shades = [blinn_phong(0.2, 0.7, 0.2, 9.0), Shade::Unlit];
    for layer in 0..2 {
        let mut alone = plan.clone();
        alone.techniques[1 - layer].table = white(0.0, 1.0);
        let mut alike = alone.clone();
        for (technique, shade) in alone.techniques.iter_mut().zip(shades) {
            technique.shade = shade;
        }
        change_all(&mut alike, |technique| technique.shade = shades[layer]);
        let alone = draw(data.clone(), &alone);
        assert!(alone.stats.counts.unwrap().samples_visible > 1000);
        let alike_drawn = draw(data.clone(), &alike);
        assert_eq!(alone.image.pixels(), alike_drawn.image.pixels(), "{layer}");
        change_all(&mut alike, |technique| technique.shade = shades[1 - layer]);
        let other = draw(data.clone(), &alike);
        assert!(distance(&alone, &other) > 0.01, "{layer}: light matters");
    }
}

/// A Plan of two volumes whose techniques are any.
fn any_two(random: &mut Random) -> (strahl_volume::Volume, strahl_volume::Volume, Plan) {
    let (a, b) = pair();
    let mut plan = two(&a, &b);
    (plan.width, plan.height) = (41, 33);
    plan.lights = light();
    let of_opacity = random.once_in(2);
    for (technique, volume) in plan.techniques.iter_mut().zip([&a, &b]) {
        let range = volume.statistics().range.map(|v| v as f32);
        *technique = any_technique(random, range, of_opacity);
    }
    if random.once_in(3) {
        change_all(&mut plan, |technique| {
            technique.composite = Composite::BackToFront;
        });
    }
    (a, b, plan)
}

#[test]
fn all_renderers_draw_each_layer_by_its_technique() {
    let mut varied = 0;
    for seed in seeds(24) {
        let mut random = Random::new(seed ^ 0x7EC4);
        let (a, b, plan) = any_two(&mut random);
        varied += usize::from(!plan.has_one_technique());
        let data = Datasets {
            volumes: vec![a.clone(), b.clone()],
            ..Datasets::default()
        };
        let cpu = draw(data.clone(), &plan).image;
        let here = Evaluator::new(data.clone()).render(&plan, &Control::NONE);
        let here = here.unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        let apart = agreement(&cpu, &here.image);
        assert!(
            apart.psnr_db >= 90.0 && apart.far == 0.0,
            "seed {seed}: {apart:?} {:#?}",
            plan.techniques
        );
        let [settings, by_graph] = twice(&data, &plan);
        let apart = agreement(&settings, &by_graph);
        assert!(
            apart.psnr_db > 100.0 && apart.far == 0.0,
            "seed {seed}, by its graph: {apart:?} {:#?}",
            plan.techniques
        );
        let Some(device) = device() else { continue };
        let mut renderer = strahl_gpu::Renderer::new(device, data.clone());
        let gpu = renderer.render(&plan, &Control::NONE).unwrap();
        let apart = agreement(&cpu, &gpu.image);
        assert!(
            apart.psnr_db >= 45.0,
            "seed {seed}, on the GPU: {apart:?} {:#?}",
            plan.techniques
        );
    }
    assert!(varied > 15, "{varied}");
}

pub fn linked(linker: &mut Linker, plan: &Plan) -> Arc<Program> {
    let functions = Functions::of(plan, true, |_, threshold| f64::from(threshold)).unwrap();
    let skeleton = ray_loop(&loop_of(plan, Texels::Float)).unwrap();
    linker.link(&skeleton, &functions.selection).unwrap()
}

#[test]
fn which_technique_a_layer_has_is_data() {
    let (a, b) = pair();
    let mut plan = two(&a, &b);
    plan.lights = light();
    let mut linker = Linker::new();
    let of_one = linked(&mut linker, &plan);
    plan.techniques[1].table = white(0.7, 2.0);
    assert!(Arc::ptr_eq(&of_one, &linked(&mut linker, &plan)), "a table");
    plan.techniques[0].shade = blinn_phong(0.2, 0.7, 0.2, 9.0);
    plan.techniques[1].classify = Classify::Threshold {
        threshold: 3.0,
        black: 0.0,
        white: 9.0,
    };
    let of_both = linked(&mut linker, &plan);
    assert!(!Arc::ptr_eq(&of_one, &of_both));
    plan.techniques.swap(0, 1);
    plan.techniques[0].classify = Classify::Threshold {
        threshold: 5.0,
        black: -1.0,
        white: 8.0,
    };
    plan.techniques[1].shade = blinn_phong(0.1, 0.8, 0.0, 3.0);
    plan.techniques[1].table = white(0.1, 1.0);
    assert!(Arc::ptr_eq(&of_both, &linked(&mut linker, &plan)));
}

#[test]
fn objects_of_scenes_have_techniques_of_their_own() {
    let (a, b) = pair();
    let headers = Headers {
        volumes: vec![a.header(), b.header()],
        ..Headers::from(a.header())
    };
    let plan = |text: &str| resolve_with(&Scene::parse("scene", text).unwrap(), &headers);
    let with = |own: &str| {
        format!(
            r#"{{ "shading": {{ "model": "lambert", "diffuse": 0.5 }},
                 "objects": [{{ "volume": {{ "path": "b" }}, {own} }}] }}"#
        )
    };
    let mixed = plan(&with(
        r#""shading": { "model": "unlit" }, "functions": { "classify": { "module": "pre_classified" } }"#,
    ))
    .unwrap();
    let [first, second] = &mixed.techniques[..] else {
        panic!("{:?}", mixed.techniques)
    };
    assert!(matches!(first.shade, Shade::Lit { .. }));
    assert_eq!(first.classify, Classify::Table);
    assert_eq!(second.shade, Shade::Unlit);
    assert_eq!(second.classify, Classify::PreClassified);
    assert!(!mixed.lights.is_empty() && !mixed.has_one_technique());
    for (own, message) in [
        (
            r#""shading": { "diffuse": 11 }"#,
            "objects[0].shading.diffuse",
        ),
        (
            r#""functions": { "jitter": { "module": "hash" } }"#,
            "objects[0].functions.jitter",
        ),
        (
            r#""functions": { "classify": { "module": "nothing" } }"#,
            "objects[0].functions.classify.module",
        ),
    ] {
        let problems = plan(&with(own)).unwrap_err().to_string();
        assert!(problems.contains(message), "{problems}");
    }
}

/// None, or one of each function.
pub fn any_illustration(random: &mut Random, steep: f32) -> Illustrate {
    random.pick(&[
        Illustrate::Plain,
        Illustrate::Plain,
        Illustrate::DepthCue {
            strength: 0.8,
            nearest_mm: 20.0,
            farthest_mm: 60.0,
            red: 0.1,
            green: 0.2,
            blue: 0.5,
        },
        Illustrate::Silhouette {
            strength: 3.0,
            gradient_weight: 0.5,
            full_per_mm: steep,
            from_slant: 0.3,
            to_slant: 0.8,
        },
        Illustrate::Halo {
            width_mm: 1.5,
            reach_mm: 8.0,
            strength: 0.8,
            steps: 4,
        },
        Illustrate::ContourLines {
            width_mm: 1.2,
            reach_mm: 1.5,
            strength: 0.7,
            softness: 0.5,
        },
    ])
}
