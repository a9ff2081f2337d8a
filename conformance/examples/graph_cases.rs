//! Programs that the graph compiler makes beside hand-written ones: the four cases of `crates/graph/benches`.
//! Both draw in turns, so that a noisy machine disturbs both alike; the pictures must be the same.
//!
//!     cargo run --release -p strahl-conformance --example graph_cases

#[path = "../../crates/graph/benches/cases.rs"]
mod cases;

use cases::{CASES, tables};
use strahl_gpu::{Device, Renderer};
use strahl_volume::{Control, Datasets};

const ROUNDS: usize = 21;

fn main() {
    let device = match Device::open(None) {
        Ok(device) => device,
        Err(error) => return println!("skipped: {error}"),
    };
    println!("{}", device.adapter());
    for case in &CASES {
        let volumes = case.volumes();
        let plan = case.plan(&volumes);
        let data = Datasets {
            volumes: volumes.clone(),
            ..Datasets::default()
        };
        let mut renderer = Renderer::new(&device, data);
        let functions = renderer.functions(&plan).expect("functions");
        let what = renderer.loop_of(&plan).expect("a loop");
        let generated = case.generated(&plan, &what, &functions);
        let tables = tables(&generated, &plan);
        let by_hand = case.by_hand(&what, &functions);
        let (mut ours, mut theirs) = (Vec::new(), Vec::new());
        let mut off = 0.0f32;
        for round in 0..=ROUNDS {
            let mut draw = |program, parameters: &[u8]| {
                let start = cpu_seconds();
                let drawn = renderer.render_by(&plan, program, parameters, &tables, &Control::NONE);
                let image = drawn.expect("a picture").image;
                (image, cpu_seconds() - start)
            };
            // Who is first changes from round to round.
            let (a, b) = if round % 2 == 0 {
                let a = draw(&generated.program, &generated.parameters);
                (a, draw(&by_hand.0, &by_hand.1))
            } else {
                let b = draw(&by_hand.0, &by_hand.1);
                (draw(&generated.program, &generated.parameters), b)
            };
            // The first round makes pipelines.
            if round > 0 {
                ours.push(a.1);
                theirs.push(b.1);
            }
            let pixels = a.0.pixels().iter().zip(b.0.pixels());
            let differences = pixels.flat_map(|(a, b)| a.iter().zip(b).map(|(a, b)| (a - b).abs()));
            off = differences.fold(off, f32::max);
        }
        let (ours, theirs) = (median(ours), median(theirs));
        println!(
            "{}: generated {:.1} ms, hand-written {:.1} ms, ratio {:.3}; largest difference {off:.1e}",
            case.name,
            1e3 * ours,
            1e3 * theirs,
            ours / theirs
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
