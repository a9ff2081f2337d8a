//! The linked program beside a hand-written ray caster of the same settings: what composition costs.
//! Both draw in turns, so that a noisy machine disturbs both alike; the pictures must be the same.
//!
//!     cargo bench -p strahl-gpu

use std::sync::Arc;
use strahl_gpu::{Device, Renderer};
use strahl_scene::{Scene, resolve};
use strahl_shader::{Linker, Selection, Skeleton};
use strahl_volume::Control;
use strahl_volume::Phantom;

const ROUNDS: usize = 15;

fn main() {
    let device = match Device::open(None) {
        Ok(device) => device,
        Err(error) => return println!("skipped: {error}"),
    };
    println!("{}", device.adapter());
    let text = r##"{
        "size": [384, 384], "preset": "solid", "background": "#000000",
        "lights": [{ "type": "head" }],
        "shading": { "ambient": 0.25, "diffuse": 0.75, "specular": 0.2, "shininess": 24 }
    }"##;
    let scene = Scene::parse("bench", text).unwrap();
    let hand_written = Skeleton {
        name: "hand-written".into(),
        wgsl: include_str!("hand_written.wgsl").into(),
        parts: Vec::new(),
        orders: [Arc::from(""), Arc::from("")],
        functions: Vec::new(),
        objects: 1,
    };
    let hand_written = Linker::new()
        .link(&hand_written, &Selection::new())
        .unwrap();
    // Radiance; diffuse, specular, shininess; ambient; where rays stop.
    let settings = [
        [1.0, 1.0, 1.0, 0.0],
        [0.75, 0.2, 24.0, 0.0],
        [0.25, 0.0, 0.0, 0.0],
        [1.0f32 / 256.0, 0.0, 0.0, 0.0],
    ];
    let settings: Vec<u8> = settings
        .iter()
        .flatten()
        .flat_map(|number| number.to_le_bytes())
        .collect();
    for (phantom, edge) in [(Phantom::Tree, 128), (Phantom::Anatomy, 128)] {
        let volume = phantom.volume([edge; 3]).unwrap();
        let plan = resolve(&scene, &volume.header(), None).unwrap();
        let mut renderer = Renderer::new(&device, &volume);
        let (mut linked, mut by_hand) = (Vec::new(), Vec::new());
        let mut off = 0.0f32;
        for round in 0..=ROUNDS {
            let start = cpu_seconds();
            let a = renderer.render(&plan, &Control::NONE).unwrap();
            let middle = cpu_seconds();
            let b = renderer
                .render_by(&plan, &hand_written, &settings, &[], &Control::NONE)
                .unwrap();
            // The first round makes pipelines.
            if round > 0 {
                linked.push(middle - start);
                by_hand.push(cpu_seconds() - middle);
            }
            let pixels = a.image.pixels().iter().zip(b.image.pixels());
            let differences = pixels.flat_map(|(a, b)| a.iter().zip(b).map(|(a, b)| (a - b).abs()));
            off = differences.fold(off, f32::max);
        }
        let (linked, by_hand) = (median(linked), median(by_hand));
        println!(
            "{phantom:?} {edge}³: linked {:.1} ms, hand-written {:.1} ms, ratio {:.3}; largest difference {off:.1e}",
            1e3 * linked,
            1e3 * by_hand,
            linked / by_hand
        );
        assert!(off < 0.02, "not the same picture");
    }
}

/// Of all threads of this process: what other programs do meanwhile does not count.
fn cpu_seconds() -> f64 {
    let threads = std::fs::read_dir("/proc/self/task").into_iter().flatten();
    let spent = threads.flatten().filter_map(|thread| {
        let text = std::fs::read_to_string(thread.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<f64>().ok()
    });
    1e-9 * spent.sum::<f64>()
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
