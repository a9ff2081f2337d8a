//! The example graphs.

use super::*;
use std::fs;
use strahl::{Backend, Image, Render, Scene, SceneFile};

pub fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/graphs")
}

/// An example, small and over few voxels.
pub fn example(name: &str) -> Scene {
    let path = examples().join(format!("{name}.json"));
    let mut scene = SceneFile::open(&path).unwrap().unwrap().scene;
    scene.size = Some([96, 72]);
    if let Some(volume) = &mut scene.volume
        && volume.phantom.as_deref() == Some("anatomy")
    {
        volume.dims = Some([48, 60, 76]);
    }
    scene
}

pub fn drawn(scene: &Scene, backend: Backend) -> Image {
    let render = Render::scene(scene.clone()).backend(backend);
    render
        .picture()
        .unwrap_or_else(|error| panic!("{error}"))
        .image
}

pub fn has_gpu() -> bool {
    let is_there = !strahl::gpu::adapters().is_empty();
    assert!(
        is_there || std::env::var("CI").as_deref() != Ok("true"),
        "no graphics adapter"
    );
    is_there
}

/// Peak signal to noise in dB, of all channels; and the share of pixels with a channel off by more than 8/255.
pub fn agreement(a: &Image, b: &Image) -> (f64, f64) {
    let (mut square, mut far) = (0.0, 0usize);
    for (p, q) in a.pixels().iter().zip(b.pixels()) {
        let off = (0..4).map(|c| f64::from((p[c] - q[c]).abs()));
        square += off.clone().map(|d| d * d).sum::<f64>();
        far += usize::from(off.fold(0.0, f64::max) > 8.0 / 255.0);
    }
    let n = a.pixels().len() as f64;
    (-10.0 * (square / (4.0 * n)).log10(), far as f64 / n)
}

#[test]
fn every_example_is_one_picture_on_all_backends() {
    let mut seen = 0;
    for entry in fs::read_dir(examples()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "json") {
            continue;
        }
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let scene = example(&name);
        let here = drawn(&scene, Backend::Cpu);
        let colored = here
            .pixels()
            .iter()
            .filter(|p| p[0] != here.pixels()[0][0])
            .count();
        assert!(
            colored > 200,
            "{name}: only {colored} pixels are not background"
        );
        seen += 1;
        if !has_gpu() {
            println!("{name}: skipped on the GPU: no adapter");
            continue;
        }
        let there = drawn(&scene, Backend::Gpu { adapter: None });
        let (psnr, far) = agreement(&here, &there);
        println!("{name}: {psnr:.1} dB, {far:.5} far");
        assert!(
            psnr >= 50.0 && far <= 0.002,
            "{name}: {psnr:.1} dB, {far} far"
        );
    }
    assert!(seen >= 10, "{seen}");
}

#[test]
fn what_settings_can_say_is_their_picture() {
    // Fusing by the node `beside` is what the settings do; a ray caster of nodes alone is emission-absorption.
    for name in ["two-volumes", "ray-caster"] {
        let scene = example(name);
        let settings = Scene {
            graph: None,
            ..scene.clone()
        };
        let (psnr, far) = agreement(
            &drawn(&scene, Backend::Cpu),
            &drawn(&settings, Backend::Cpu),
        );
        assert!(psnr >= 85.0 && far == 0.0, "{name}: {psnr:.1} dB, {far}");
    }
}

/// A slot's function may be named in the graph, too.
#[test]
fn jitter_by_a_node_is_jitter_by_the_settings() {
    let scene = |text: &str| {
        let head = r#""volume": { "phantom": "tree", "dims": [48, 48, 48] }, "step_voxels": 2, "size": [96, 72]"#;
        Scene::parse("jitter", &format!("{{ {head}, {text} }}")).unwrap()
    };
    let settings = scene(r#""jitter": { "seed": 7 }"#);
    let graph = scene(
        r#""graph": { "edits": [{ "name": "jitter", "commands": [
            { "add": { "hash": { "function": "jitter/hash", "params": { "seed": 7 },
                "inputs": { "pixel": "before_jitter", "frame": "ray.frame" } } } },
            { "replace": { "stage": "jitter", "by": "hash" } }
        ] }] }"#,
    );
    let none = scene(r#""preset": "mip""#);
    let (psnr, _) = agreement(
        &drawn(&settings, Backend::Cpu),
        &drawn(&graph, Backend::Cpu),
    );
    assert!(psnr >= 90.0, "{psnr}");
    let (psnr, _) = agreement(&drawn(&none, Backend::Cpu), &drawn(&graph, Backend::Cpu));
    assert!(psnr < 60.0, "jitter changes nothing: {psnr}");
}

/// Thin peaks: the table sees what lies between the samples, as long as values go straight from one to the next.
#[test]
fn pre_integration_is_nearer_to_the_truth() {
    let scene = example("pre-integrated");
    let plain = Scene {
        graph: None,
        ..scene.clone()
    };
    let truth = drawn(
        &Scene {
            step_mm: Some(0.05),
            ..plain.clone()
        },
        Backend::Cpu,
    );
    for (step_mm, gain_db) in [(0.5, 2.0), (0.25, 3.5)] {
        let at_step = |scene: &Scene| Scene {
            step_mm: Some(step_mm),
            ..scene.clone()
        };
        let (with, _) = agreement(&truth, &drawn(&at_step(&scene), Backend::Cpu));
        let (without, _) = agreement(&truth, &drawn(&at_step(&plain), Backend::Cpu));
        assert!(
            with > without + gain_db,
            "{step_mm} mm: {with:.1} dB with, {without:.1} dB without the table"
        );
    }
}
