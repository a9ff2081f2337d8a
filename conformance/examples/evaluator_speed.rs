//! How fast the evaluator is beside the twins of the CPU's own loop: the same scenes, in turns.
//!
//!     cargo run --release -p strahl-conformance --example evaluator_speed

use std::time::Instant;
use strahl_evaluate::Evaluator;
use strahl_scene::{Scene, resolve};
use strahl_volume::Control;
use strahl_volume::Phantom;

const ROUNDS: usize = 7;

fn main() {
    let scenes = [
        ("default", r#"{ "size": [256, 256] }"#),
        (
            "unlit",
            r#"{ "size": [256, 256], "shading": { "model": "unlit" } }"#,
        ),
        (
            "mip",
            r#"{ "size": [256, 256], "method": "mip", "preset": "mip" }"#,
        ),
        (
            "b-spline",
            r#"{ "size": [128, 128], "reconstruct": "b-spline" }"#,
        ),
    ];
    let volume = Phantom::Tree.volume([16; 3]).unwrap();
    let scene = Scene::parse("small", r#"{ "size": [1, 1] }"#).unwrap();
    let plan = resolve(&scene, &volume.header(), None).unwrap();
    let mut evaluator = Evaluator::new(&volume);
    let mut once = || {
        evaluator
            .render(&plan, &Control::NONE)
            .unwrap()
            .stats
            .draw_seconds
    };
    once();
    let seconds = median((0..ROUNDS).map(|_| once()).collect());
    println!(
        "compiling a linked program, and one pixel: {:.2} ms",
        1e3 * seconds
    );
    println!();
    println!("| volume 128³, scene | twins | evaluator | ratio | evaluator, million samples/s |");
    println!("|---|---|---|---|---|");
    for phantom in [Phantom::Tree, Phantom::Anatomy] {
        let volume = phantom.volume([128; 3]).unwrap();
        for (name, text) in scenes {
            let scene = Scene::parse(name, text).unwrap();
            let plan = resolve(&scene, &volume.header(), None).unwrap();
            let twins = strahl_cpu::Renderer::new(&volume);
            let mut evaluator = Evaluator::new(&volume);
            let (mut by_twins, mut by_program, mut samples) = (Vec::new(), Vec::new(), 0);
            for _ in 0..ROUNDS {
                let start = Instant::now();
                let drawn = twins
                    .render(&plan, &Default::default(), &Control::NONE)
                    .unwrap();
                samples = drawn.stats.counts.unwrap().samples;
                by_twins.push(start.elapsed().as_secs_f64());
                let drawn = evaluator.render(&plan, &Control::NONE);
                by_program.push(drawn.unwrap().stats.draw_seconds);
            }
            let (twins, program) = (median(by_twins), median(by_program));
            println!(
                "| {phantom:?}, {name} | {:.1} ms | {:.1} ms | {:.1} | {:.1} |",
                1e3 * twins,
                1e3 * program,
                program / twins,
                1e-6 * samples as f64 / program,
            );
        }
    }
}

fn median(mut seconds: Vec<f64>) -> f64 {
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}
