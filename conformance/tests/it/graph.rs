//! Shader graphs: what settings say and what their graph says is one picture.

use crate::random::{Random, seeds};
use crate::simple::cut_box;
use crate::variants::{any_variant, change_all, pair, ramp, two, wall};
use glam::{DAffine3, DVec3};
use strahl_conformance::agreement::agreement;
use strahl_conformance::device;
use strahl_conformance::gallery::{gallery, scene};
use strahl_evaluate::Evaluator;
use strahl_gpu::Renderer;
use strahl_graph::{Compiler, Graph, standard};
use strahl_scene::plan::{
    Composite, Field, Illuminate, Plan, PlanMesh, SampleClip, Shade, Technique,
};
use strahl_scene::{Image, Rendered, Scene, resolve};
use strahl_volume::phantom::Phantom;
use strahl_volume::{Control, Datasets, Samples};

/// Draws `graph` on the GPU.
pub fn on_gpu(data: impl Into<Datasets>, plan: &Plan, graph: &Graph) -> Option<Image> {
    let mut renderer = Renderer::new(device()?, data);
    let functions = renderer.functions(plan).unwrap();
    let what = renderer.loop_of(plan).unwrap();
    let compiled = Compiler::default()
        .compile("test", graph, &what, &functions)
        .unwrap_or_else(|error| panic!("{error}"));
    let drawn = renderer.render_by(
        plan,
        &compiled.program,
        &compiled.parameters,
        &[],
        &Control::NONE,
    );
    Some(drawn.unwrap().image)
}

#[test]
fn the_standard_graph_is_the_picture_of_the_settings() {
    let Some(device) = device() else { return };
    let volume: &'static _ = Box::leak(Box::new(Phantom::Tree.volume([40, 36, 44]).unwrap()));
    let mut compared = 0;
    let to_maximum = (
        "composite",
        "mida to the maximum",
        r#""method": "mida", "blend": 0.5"#.into(),
    );
    for variant in gallery().iter().chain([&to_maximum]) {
        let text = scene(variant, [80, 64]);
        let plan = resolve(
            &Scene::parse("scene", &text).unwrap(),
            &volume.header(),
            None,
        )
        .unwrap();
        if matches!(plan.technique().composite, Composite::Debug(_)) {
            assert!(standard(&plan).is_err());
            continue;
        }
        let graph = standard(&plan).unwrap();
        let settings = Renderer::new(device, volume)
            .render(&plan, &Control::NONE)
            .unwrap()
            .image;
        let by_graph = on_gpu(volume, &plan, &graph).unwrap();
        let a = agreement(&settings, &by_graph);
        println!("{}: {a:?}", variant.1);
        assert!(a.psnr_db > 90.0 && a.far == 0.0, "{}: {a:?}", variant.1);
        compared += 1;
    }
    assert!(compared > 30, "{compared}");
}

/// Draws `plan` by its program and by its standard graph, both evaluated.
pub fn twice(data: &Datasets, plan: &Plan) -> [Image; 2] {
    twice_rendered(data, plan).map(|rendered| rendered.image)
}

/// The same, with distances.
pub fn twice_rendered(data: &Datasets, plan: &Plan) -> [Rendered; 2] {
    let mut evaluator = Evaluator::new(data.clone());
    let settings = evaluator.render(plan, &Control::NONE).unwrap();
    let (what, functions) = (
        evaluator.loop_of(plan).unwrap(),
        evaluator.functions(plan).unwrap(),
    );
    let graph = standard(plan).unwrap_or_else(|error| panic!("{error}"));
    let compiled = Compiler::default()
        .compile("test", &graph, &what, &functions)
        .unwrap_or_else(|error| panic!("{error}"));
    let (program, parameters) = (&compiled.program, &compiled.parameters);
    let drawn = evaluator.render_by(plan, program, parameters, &[], &Control::NONE);
    [settings, drawn.unwrap()]
}

fn assert_same(what: &str, [settings, by_graph]: &[Image; 2]) {
    let a = agreement(settings, by_graph);
    assert!(a.psnr_db > 100.0 && a.far == 0.0, "{what}: {a:?}");
}

#[test]
fn random_settings_are_their_standard_graph() {
    let mut drawn = 0;
    for seed in seeds(60) {
        let mut random = Random::new(seed);
        let volume = random.volume();
        if matches!(
            volume.samples(),
            Samples::U32(_) | Samples::I32(_) | Samples::F64(_)
        ) {
            continue;
        }
        let plan = any_variant(&mut random, &volume);
        if standard(&plan).is_err() {
            continue;
        }
        // No prefilter runs over voxels that are not finite.
        if Evaluator::new(&volume).functions(&plan).is_err() {
            continue;
        }
        let what = format!(
            "seed {seed}: {:?} {:?}",
            plan.technique().composite,
            plan.technique().shade
        );
        assert_same(&what, &twice(&(&volume).into(), &plan));
        drawn += 1;
    }
    assert!(drawn > 20, "{drawn}");
}

/// Several objects, forwards and backwards, with masks, meshes and memory of the last normal.
#[test]
fn several_objects_are_their_standard_graph() {
    let (a, b) = pair();
    let mesh = wall(1.0);
    let data = Datasets {
        volumes: vec![a.clone(), b.clone()],
        masks: Vec::new(),
        meshes: vec![mesh.clone()],
        ..Datasets::default()
    };
    let mut plan = two(&a, &b);
    (plan.width, plan.height) = (61, 50);
    assert_same("two", &twice(&data, &plan));
    change_all(&mut plan, |technique| {
        technique.composite = Composite::BackToFront
    });
    assert_same("from the back", &twice(&data, &plan));
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
    assert_same("three", &twice(&data, &plan));
    change_all(&mut plan, |technique| {
        technique.composite = Composite::EmissionAbsorption {
            stop_at_transmittance: 0.01,
        };
    });
    plan.sample_clips = vec![SampleClip {
        layers: 0b101,
        ..cut_box(DAffine3::from_scale(DVec3::splat(1.0 / 9.0)), true)
    }];
    plan.technique_mut().shade = Shade::Lit {
        illuminate: Illuminate::BlinnPhong {
            diffuse: 0.6,
            specular: 0.4,
            shininess: 12.0,
        },
        ambient: 0.2,
        keep_last_normal: true,
    };
    assert_same("lit, clipped", &twice(&data, &plan));
    plan.meshes = vec![PlanMesh {
        mesh: 0,
        world_from_mesh: DAffine3::from_scale(DVec3::splat(0.15)),
        color: [0.2, 0.5, 0.9],
    }];
    assert_same("and a mesh", &twice(&data, &plan));
}
