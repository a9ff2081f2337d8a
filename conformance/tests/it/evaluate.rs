//! Linked programs without a GPU: the same scenes, the same pictures as from the twins.

use crate::random::{Random, seeds};
use crate::simple::{cut_box, of_samples, parallel, white};
use crate::variants::{any_variant, change_all, pair, ramp, two, wall};
use glam::{DAffine3, DMat3, DVec3};
use std::sync::Arc;
use strahl_conformance::agreement::agreement;
use strahl_conformance::device;
use strahl_conformance::gallery::{gallery, scene};
use strahl_conformance::scenes::{SCENES, prepare};
use strahl_evaluate::Evaluator;
use strahl_scene::plan::*;
use strahl_scene::{Image, OtherData, Scene, resolve};
use strahl_shader::{Module, Texels};
use strahl_volume::phantom::Phantom;
use strahl_volume::{Control, Datasets, Samples, Volume, Work};

fn on_cpu(data: Datasets, plan: &Plan) -> Image {
    strahl_cpu::Renderer::new(data)
        .render(plan, &Default::default(), &Control::NONE)
        .unwrap()
        .image
}

fn looks_the_same(what: &str, first: &Image, second: &Image) {
    let seen = first.pixels().iter().filter(|p| p[3] > 0.0).count();
    assert!(seen > first.pixels().len() / 20, "{what}: nothing is seen");
    let d = agreement(first, second);
    println!(
        "{what}: {:.1} dB, {:.4} far, at most {:.3}",
        d.psnr_db, d.far, d.most
    );
    assert!(
        d.psnr_db >= 90.0 && d.far == 0.0,
        "{what}: {:.1} dB, {} far",
        d.psnr_db,
        d.far
    );
}

fn plan_of(volume: &Volume, text: &str) -> Plan {
    let scene = Scene::parse("scene", text).unwrap();
    resolve(&scene, &volume.header(), None).unwrap()
}

#[test]
fn the_golden_scenes_look_the_same() {
    for (name, text) in SCENES {
        let (volume, plan) = prepare(name, text).unwrap();
        let drawn = Evaluator::new(&volume)
            .render(&plan, &Control::NONE)
            .unwrap();
        looks_the_same(name, &on_cpu((&volume).into(), &plan), &drawn.image);
    }
}

#[test]
fn every_variant_looks_the_same() {
    for phantom in [Phantom::Tree, Phantom::Anatomy] {
        let volume = phantom.volume([40, 36, 44]).unwrap();
        for variant in &gallery() {
            let what = format!("{phantom:?} {}", variant.1);
            let plan = plan_of(&volume, &scene(variant, [60, 50]));
            let drawn = Evaluator::new(&volume).render(&plan, &Control::NONE);
            let drawn = drawn.unwrap_or_else(|error| panic!("{what}: {error}"));
            looks_the_same(&what, &on_cpu((&volume).into(), &plan), &drawn.image);
        }
    }
}

/// The same Plan of the same data on both, depth too.
fn both_draw(what: &str, data: &Datasets, plan: &Plan) {
    let cpu = strahl_cpu::Renderer::new(data.clone())
        .render(plan, &Default::default(), &Control::NONE)
        .unwrap();
    let drawn = Evaluator::new(data.clone())
        .render(plan, &Control::NONE)
        .unwrap();
    looks_the_same(what, &cpu.image, &drawn.image);
    if let (Some(cpu), Some(drawn)) = (cpu.depth_mm, drawn.depth_mm) {
        assert!(cpu.iter().any(|d| d.is_finite()), "{what}: no depth");
        for (cpu, drawn) in cpu.iter().zip(&drawn) {
            let is_near = (cpu - drawn).abs() < 0.001 || cpu == drawn;
            assert!(is_near, "{what}: {drawn} mm, not {cpu}");
        }
    }
}

#[test]
fn several_volumes_meshes_and_masks_look_the_same() {
    let (a, b) = pair();
    let stripes = |samples| of_samples(*a.grid(), samples);
    let mask = stripes(Samples::U16(
        (0..8000)
            .map(|i| if i % 20 >= 10 { 700 } else { 3 })
            .collect(),
    ));
    let mesh = wall(1.0);
    let data = Datasets {
        volumes: vec![a.clone(), b.clone()],
        masks: vec![mask.clone()],
        meshes: vec![mesh.clone()],
        ..Datasets::default()
    };
    let mut plan = two(&a, &b);
    (plan.width, plan.height) = (61, 50);
    both_draw("two volumes", &data, &plan);
    change_all(&mut plan, |technique| {
        technique.composite = Composite::BackToFront
    });
    both_draw("two volumes from the back", &data, &plan);
    let field = Field {
        volume: 1,
        grid: plan.field_of(1).grid,
        ..*plan.field()
    };
    let technique = Technique {
        table: ramp(),
        ..plan.technique().clone()
    };
    plan.add_layer(field, technique);
    both_draw("three objects of two volumes", &data, &plan);
    plan.sample_clips = vec![SampleClip {
        shape: ClipShape::Mask {
            mask: 0,
            threshold: 350.0,
        },
        layers: 0b101,
        ..cut_box(DAffine3::from_scale(DVec3::splat(1.0 / 20.0)), true)
    }];
    both_draw("a mask over two of three", &data, &plan);
    plan.meshes = vec![PlanMesh {
        mesh: 0,
        world_from_mesh: DAffine3::from_mat3_translation(
            DMat3::from_rotation_z(0.3) * 0.15,
            DVec3::new(1.0, 0.0, 2.0),
        ),
        color: [0.2, 0.5, 0.9],
    }];
    plan.lights = vec![
        PlanLight::Directional {
            to_light: DVec3::new(-0.6, -0.8, 0.0),
            radiance: [0.9, 0.7, 0.5],
        },
        PlanLight::Point {
            place_mm: DVec3::new(5.0, -20.0, 9.0),
            reach_mm: 20.0,
            radiance: [0.2, 0.4, 0.6],
        },
    ];
    plan.background = [0.1, 0.1, 0.2, 1.0];
    plan.with_depth = true;
    both_draw("and a mesh", &data, &plan);
    plan.camera = PlanCamera {
        projection: Projection::Perspective {
            tan_half_height: 0.25,
        },
        ..plan.camera
    };
    both_draw("in perspective", &data, &plan);
}

#[test]
fn hits_are_as_far_away() {
    let (a, _) = pair();
    let mut plan = crate::simple::plan(&a, parallel(DVec3::Y, 60.0, 14.0), white(0.0, 1.0));
    (plan.width, plan.height) = (40, 30);
    let [low, high] = a.statistics().range;
    plan.technique_mut().composite = Composite::FirstHit {
        threshold: (0.5 * (low + high)) as f32,
    };
    plan.with_depth = true;
    both_draw("a surface", &Datasets::from(&a), &plan);
}

#[test]
fn random_plans_look_the_same() {
    let (mut drawn, mut failed) = (0, Vec::new());
    for seed in seeds(100) {
        let mut random = Random::new(seed ^ 0x3A7E);
        let volume = random.volume();
        // Whole numbers of 32 bits do not fit into the floats of a texture.
        if matches!(
            volume.samples(),
            Samples::U32(_) | Samples::I32(_) | Samples::F64(_)
        ) {
            continue;
        }
        let mut plan = any_variant(&mut random, &volume);
        // In constant parts the gradient of a cubic is what rounding leaves, and so is the normal.
        if matches!(plan.technique().shade, Shade::Lit { .. })
            && plan.field().reconstruct != Reconstruct::Trilinear
        {
            plan.technique_mut().shade = Shade::Unlit;
        }
        let cpu = match strahl_cpu::Renderer::new(&volume).render(
            &plan,
            &Default::default(),
            &Control::NONE,
        ) {
            Ok(drawn) => drawn.image,
            Err(strahl_cpu::Error::Coefficients(_)) => continue,
            Err(error) => panic!("{error}"),
        };
        let here = Evaluator::new(&volume)
            .render(&plan, &Control::NONE)
            .unwrap();
        let d = agreement(&cpu, &here.image);
        drawn += 1;
        // Transfer functions one entry wide, edges of boxes and nearest voxels: single samples flip, and halvings of
        // a hit. That is at most three of the 143 pixels.
        if d.far > 0.025 {
            failed.push(format!(
                "seed {seed}: {d:?} {:?} {:?} {:?} {:?} {:?} {:?}",
                plan.technique().composite,
                plan.field().reconstruct,
                plan.technique().classify,
                plan.field().fetch,
                plan.field().gradient,
                plan.technique().shade
            ));
        }
    }
    assert!(
        drawn > 40 && failed.is_empty(),
        "{} of {drawn} differ: {failed:#?}",
        failed.len()
    );
}

/// A user's module: the value as red, bands as blue, with a loop, a switch and a parameter.
const BANDS: &str = "struct Params {
    /// Width of a band.
    /// default 200, range 1 to 5000
    width: f32,
}

fn banded(value: f32) -> f32 {
    var left = value;
    var turns = 0u;
    loop {
        if left < params.width {
            break;
        }
        left -= params.width;
        turns += 1u;
        if turns > 40u {
            return 0.0;
        }
    }
    switch turns % 3u {
        case 0u: { return 1.0; }
        case 1u: { return left / params.width; }
        default: { return 0.25; }
    }
}

fn classify(value: f32, position: vec3f) -> Surface {
    let surface = table(value);
    return Surface(vec3f(surface.color.r, 0.1, banded(value)), surface.opacity);
}";

/// A Plan that no twin can draw.
fn banded() -> (Volume, Plan) {
    let volume = Phantom::Anatomy.volume([40, 36, 44]).unwrap();
    let mut plan = plan_of(&volume, r#"{ "size": [70, 60] }"#);
    let module = Module::parse("bands", "bands.wgsl", BANDS).unwrap();
    plan.modules.push(PlanModule {
        module: Arc::new(module),
        values: vec![("width".into(), vec![150.0])],
    });
    (volume, plan)
}

#[test]
fn a_function_of_the_user_is_drawn() {
    let (volume, plan) = banded();
    let refused =
        strahl_cpu::Renderer::new(&volume).render(&plan, &Default::default(), &Control::NONE);
    assert!(matches!(refused, Err(strahl_cpu::Error::NoTwin { .. })));
    let drawn = Evaluator::new(&volume)
        .render(&plan, &Control::NONE)
        .unwrap();
    // Blue comes from nowhere else.
    let blue = drawn.image.pixels().iter().filter(|p| p[2] > 0.2).count();
    assert!(blue > 100, "{blue}");
    let mut wider = plan.clone();
    wider.modules[0].values[0].1 = vec![900.0];
    let other = Evaluator::new(&volume)
        .render(&wider, &Control::NONE)
        .unwrap();
    assert_ne!(drawn.image.pixels(), other.image.pixels());
}

#[test]
fn graphics_processors_draw_the_same() {
    let Some(device) = device() else { return };
    let near = |what: &str, here: &Image, there: &Image| {
        let d = agreement(here, there);
        println!("{what}: {:.1} dB, at most {:.3}", d.psnr_db, d.most);
        assert!(d.psnr_db >= 45.0 && d.far < 0.003, "{what}: {d:?}");
    };
    let draw = |what: &str, volume: &Volume, plan: &Plan| {
        let here = Evaluator::new(volume).render(plan, &Control::NONE).unwrap();
        let there = strahl_gpu::Renderer::new(device, volume)
            .render(plan, &Control::NONE)
            .unwrap();
        near(what, &here.image, &there.image);
    };
    for (name, text) in SCENES {
        let (volume, plan) = prepare(name, text).unwrap();
        draw(name, &volume, &plan);
    }
    let (volume, plan) = banded();
    draw("a function of the user", &volume, &plan);
}

/// Programs that let a sampler interpolate, and those that read whole numbers, draw the same picture.
#[test]
fn however_a_program_reads_texels_the_picture_is_the_same() {
    let volume = Phantom::Anatomy.volume([40, 36, 44]).unwrap();
    let plan = plan_of(&volume, r#"{ "size": [60, 50] }"#);
    let mut evaluator = Evaluator::new(&volume);
    let own = evaluator.render(&plan, &Control::NONE).unwrap();
    for texels in [Texels::Float, Texels::Signed] {
        let is_filtered = texels == Texels::Float;
        let threshold = |_, threshold| f64::from(threshold);
        let functions = strahl_program::Functions::of(&plan, is_filtered, threshold).unwrap();
        let skeleton = strahl_shader::ray_loop(&strahl_program::loop_of(&plan, texels)).unwrap();
        let program = strahl_shader::Linker::new()
            .link(&skeleton, &functions.selection)
            .unwrap();
        let parameters = functions.parameters(&program).unwrap();
        let other = evaluator
            .render_by(&plan, &program, &parameters, &[], &Control::NONE)
            .unwrap();
        looks_the_same(&format!("{texels:?}"), &own.image, &other.image);
    }
}

#[test]
fn on_any_number_of_threads_the_bytes_are_the_same() {
    let (volume, mut plan) = banded();
    plan.lattice.jitter = Jitter::Hash(3);
    plan.lattice.frames = 2;
    let draw = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            Evaluator::new(&volume)
                .render(&plan, &Control::NONE)
                .unwrap()
        })
    };
    let bits = |rendered: strahl_evaluate::Rendered| {
        let pixels = rendered.image.pixels().to_vec();
        pixels
            .into_iter()
            .map(|p| p.map(f32::to_bits))
            .collect::<Vec<_>>()
    };
    let first = bits(draw(1));
    assert!(first == bits(draw(2)) && first == bits(draw(3)));
}

#[test]
fn a_picture_can_be_cancelled_and_a_plan_of_other_data_is_refused() {
    let (volume, plan) = banded();
    let control = Control::listening(|work, _| match work {
        Work::Drawing => std::ops::ControlFlow::Break(()),
        _ => std::ops::ControlFlow::Continue(()),
    });
    let cancelled = Evaluator::new(&volume).render(&plan, &control);
    assert!(matches!(cancelled, Err(strahl_evaluate::Error::Cancelled)));
    let other = Phantom::Tree.volume([8, 8, 8]).unwrap();
    let refused = Evaluator::new(&other).render(&plan, &Control::NONE);
    assert!(matches!(
        refused,
        Err(strahl_evaluate::Error::OtherData(OtherData::Grid { .. }))
    ));
}

/// A volume of 8·n + 1 voxels ends with a brick, and what it shows beyond the last voxel belongs to that.
#[test]
fn the_last_half_voxel_is_seen_whatever_the_bricks() {
    for edge in [1, 2, 8, 9, 10, 16, 17, 18, 33] {
        let grid = strahl_volume::Grid::centered([edge; 3], DVec3::ONE).unwrap();
        let volume = crate::simple::volume(grid, |_| 1.0);
        let size = edge as f64;
        let mut plan = crate::simple::plan(
            &volume,
            parallel(DVec3::new(0.1, 1.0, 0.2), 2.0 * size, 0.8 * size),
            white(0.02, 1.0),
        );
        (plan.width, plan.height) = (30, 30);
        plan.lattice.step_mm = 0.2;
        let (data, what) = (Datasets::from(&volume), format!("{edge}³"));
        both_draw(&what, &data, &plan);
        let Some(device) = device() else { continue };
        let there = strahl_gpu::Renderer::new(device, &volume)
            .render(&plan, &Control::NONE)
            .unwrap();
        looks_the_same(&what, &on_cpu(data, &plan), &there.image);
    }
}

#[test]
fn programs_refuse_rules_of_sampling_by_name() {
    let volume = Phantom::Shells.volume([12; 3]).unwrap();
    let plan = plan_of(&volume, r#"{ "size": [9, 9] }"#);
    let rules = [
        Sampling::Refine { parts: 8 },
        Sampling::Split {
            parts: 10,
            curve: Curve::Linear,
        },
        Sampling::Integrated,
        Sampling::Adaptive { error: 0.1 },
        Sampling::ByOpacity { share: 0.1 },
    ];
    for sampling in rules {
        let plan = Plan {
            sampling,
            ..plan.clone()
        };
        let drawn = Evaluator::new(&volume).render(&plan, &Control::NONE);
        let name = format!("sampling.rule is {:?}", sampling.name());
        let message = drawn.err().map(|error| error.to_string());
        assert!(
            message
                .as_ref()
                .is_some_and(|m| m.contains(&name) && m.contains("the CPU's own loop")),
            "{name}: {message:?}"
        );
        let message = strahl_graph::standard(&plan)
            .err()
            .map(|error| error.to_string());
        assert!(
            message.is_some_and(|m| m.contains(&name)),
            "{name} as a graph"
        );
    }
}
