//! One frame of 512² of the anatomy phantom, and of the bonsai where `../shared/data` has it, with the
//! camera, step and transfer function of its timing case there.
//!
//!     cargo bench -p strahl-cpu

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::path::PathBuf;
use strahl_cpu::{Options, Renderer};
use strahl_scene::{Camera, Method, Scene, resolve};
use strahl_scene::{Color, Shading, ShadingModel, TransferFunction, TransferPoint, View};
use strahl_volume::phantom::Phantom;
use strahl_volume::read::{MemoryFiles, ReadOptions, read_file};
use strahl_volume::{Control, Volume};

/// The transfer function of the bonsai: value, opacity per voxel edge, color.
const BONSAI: [(f64, f64, [f64; 3]); 6] = [
    (0.0, 0.0, [0.0, 0.0, 0.0]),
    (30.0, 0.0, [0.0, 0.0, 0.0]),
    (45.0, 0.05, [0.2, 0.6, 0.1]),
    (80.0, 0.3, [0.3, 0.7, 0.2]),
    (120.0, 0.5, [0.6, 0.4, 0.2]),
    (255.0, 0.9, [0.8, 0.7, 0.5]),
];

fn bonsai() -> Option<Volume> {
    let shared = std::env::var_os("STRAHL_SHARED").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared"),
        PathBuf::from,
    );
    let name = "bonsai.nii.gz";
    let Ok(bytes) = std::fs::read(shared.join("data").join(name)) else {
        eprintln!("skipped: {name} is not there");
        return None;
    };
    let folder = MemoryFiles::from([(name.to_owned(), bytes)]);
    Some(
        read_file(name, &folder, &ReadOptions::default())
            .unwrap()
            .volume,
    )
}

fn bonsai_scene() -> Scene {
    let point = |&(value, opacity, color)| TransferPoint::new(value, opacity, Color(color));
    Scene {
        transfer_function: Some(TransferFunction {
            points: Some(BONSAI.iter().map(point).collect()),
            ..TransferFunction::default()
        }),
        camera: Some(Camera {
            view: Some(View::Top),
            elevation_deg: Some(20.0),
            azimuth_deg: Some(30.0),
            zoom: Some(1.4),
            ..Camera::default()
        }),
        step_voxels: Some(1.0),
        ..Scene::default()
    }
}

fn frames(criterion: &mut Criterion, name: &str, volume: &Volume, scene: &Scene) {
    let mut group = criterion.benchmark_group(name);
    group.sample_size(10);
    let renderer = Renderer::new(volume);
    for (what, method, model) in [
        ("unshaded", Method::EmissionAbsorption, ShadingModel::Unlit),
        (
            "shaded",
            Method::EmissionAbsorption,
            ShadingModel::BlinnPhong,
        ),
        ("mip", Method::Mip, ShadingModel::Unlit),
        ("first-hit", Method::FirstHit, ShadingModel::BlinnPhong),
    ] {
        let scene = Scene {
            method: Some(method),
            threshold: (method == Method::FirstHit)
                .then_some(scene.threshold)
                .flatten(),
            shading: Some(Shading {
                model: Some(model),
                ..Shading::default()
            }),
            size: Some([512, 512]),
            ..scene.clone()
        };
        let plan = resolve(&scene, &volume.header(), None).unwrap();
        for skip in [true, false] {
            let options = Options {
                skip,
                ..Options::default()
            };
            let what = format!("{what}{}", if skip { "" } else { ", every sample" });
            group.bench_function(what, |bench| {
                bench.iter(|| black_box(renderer.render(&plan, &options, &Control::NONE).unwrap()));
            });
        }
    }
}

fn all(criterion: &mut Criterion) {
    let anatomy = Phantom::Anatomy
        .volume(Phantom::Anatomy.default_dims())
        .unwrap();
    frames(criterion, "anatomy", &anatomy, &Scene::default());
    if let Some(volume) = bonsai() {
        frames(criterion, "bonsai", &volume, &bonsai_scene());
    }
}

criterion_group!(benches, all);
criterion_main!(benches);
