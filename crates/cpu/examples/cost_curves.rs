//! Measures what a frame costs against one quantity, the others kept: one line of JSON per point.
//!
//!     cargo run --release -p strahl-cpu --example cost_curves -- \
//!         curve=volume|picture|threads|step|opacity [phantom=shells|tree] [at=512] [frames=5] [threads=2]
//!
//! `at` measures one point only. A phantom of 8 bits is made in memory, 256³ where the curve is not that of the volume. The
//! picture stays the same along the curve of the volume: opacities are stated for a length in mm. `peak_kib` is the most
//! memory that the process has had (Linux), after making the volume and after drawing, pictures included.

use serde_json::{Value, json};
use std::time::Instant;
use strahl_cpu::{Options, Renderer, Stats};
use strahl_scene::{Scene, resolve};
use strahl_volume::{Control, Phantom, Volume};

/// What is the same along a curve unless it is what the curve is about.
#[derive(Clone, Copy)]
struct Point {
    edge: usize,
    size: u32,
    threads: usize,
    step_voxels: f64,
    opacity: f64,
}

const USUAL: Point = Point {
    edge: 256,
    size: 512,
    threads: 2,
    step_voxels: 1.0,
    opacity: 1.0,
};

const MODES: [&str; 3] = ["unshaded", "shaded", "mip"];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let argument = |name: &str| {
        let mut values = arguments
            .iter()
            .map(|a| a.strip_prefix(name)?.strip_prefix('='));
        values.find_map(|value| value)
    };
    let number = |name: &str| argument(name).map(|text| text.parse::<f64>().expect("a number"));
    let curve = argument("curve").expect("curve=volume, picture, threads, step or opacity");
    let values: &[f64] = match curve {
        "volume" => &[64.0, 128.0, 256.0, 512.0, 1024.0],
        "picture" => &[128.0, 256.0, 512.0, 1024.0, 2048.0],
        "threads" => &[1.0, 2.0],
        "step" => &[0.25, 0.5, 1.0, 2.0, 4.0],
        "opacity" => &[0.01, 0.03, 0.1, 0.3, 1.0],
        _ => panic!("curve={curve}: there are volume, picture, threads, step and opacity"),
    };
    let phantom = argument("phantom").unwrap_or("shells");
    let phantom = Phantom::from_name(phantom).expect("a phantom");
    let frames = number("frames").unwrap_or(5.0) as u32;
    let mut made: Option<Volume> = None;
    for &value in values {
        if number("at").is_some_and(|at| at != value) {
            continue;
        }
        let mut point = USUAL;
        point.threads = number("threads").unwrap_or(USUAL.threads as f64) as usize;
        match curve {
            "volume" => point.edge = value as usize,
            "picture" => point.size = value as u32,
            "threads" => point.threads = value as usize,
            "step" => point.step_voxels = value,
            _ => point.opacity = value,
        }
        let volume = match made.take() {
            Some(volume) if volume.grid().dims() == [point.edge; 3] => volume,
            _ => phantom
                .volume([point.edge; 3])
                .expect("memory for a phantom"),
        };
        let made_kib = peak_kib();
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(point.threads)
            .build()
            .expect("threads");
        let renderer = pool.install(|| Renderer::new(&volume));
        // Those of the first mode that needs them stay for the others.
        let mut bricks = 0.0f64;
        for mode in MODES {
            let scene = scene(mode, &point);
            let (first, seconds, stats) = pool.install(|| time(&renderer, &volume, &scene, frames));
            bricks = bricks.max(stats.bricks_seconds);
            println!(
                "{}",
                json!({
                    "curve": curve,
                    "phantom": phantom.name(),
                    "x": value,
                    "mode": mode,
                    "first_s": first,
                    "seconds": seconds,
                    "bricks_s": bricks,
                    "points": stats.counts.unwrap().lattice_points,
                    "samples": stats.counts.unwrap().samples,
                    "raw_kib": (volume.grid().voxel_count() / 1024) as f64,
                    "made_kib": made_kib,
                    "peak_kib": peak_kib(),
                })
            );
        }
        drop(renderer);
        made = Some(volume);
    }
}

/// Seconds of the first picture, those of the others, and what the last one has cost, with the bricks of the first.
fn time(
    renderer: &Renderer,
    volume: &Volume,
    scene: &Scene,
    frames: u32,
) -> (f64, Vec<f64>, Stats) {
    let plan = resolve(scene, &volume.header(), None).expect("a plan");
    let draw = || {
        let start = Instant::now();
        let drawn = renderer.render(&plan, &Options::default(), &Control::NONE);
        let stats = drawn.expect("a picture").stats;
        (start.elapsed().as_secs_f64(), stats)
    };
    let (first, mut stats) = draw();
    let mut seconds = Vec::new();
    for _ in 0..frames {
        let drawn = draw();
        seconds.push(drawn.0);
        stats = Stats {
            bricks_seconds: stats.bricks_seconds,
            ..drawn.1
        };
    }
    (first, seconds, stats)
}

fn scene(mode: &str, point: &Point) -> Scene {
    let (lo, hi) = Phantom::Shells.extent_mm();
    let opacity = |share: f64| share * point.opacity;
    let mut scene = json!({
        "transfer_function": {
            "points": [
                [0.2, opacity(0.0), [0.5, 0.2, 0.1]],
                [0.6, opacity(0.3), [0.9, 0.7, 0.5]],
                [0.8, opacity(0.9), [1.0, 0.9, 0.8]],
            ],
            // A 128th of the edge, whatever the number of voxels.
            "reference_mm": (hi - lo).x / 128.0,
        },
        "camera": { "azimuth_deg": 30, "elevation_deg": 20 },
        "step_voxels": point.step_voxels,
        "size": [point.size, point.size],
        "shading": { "model": if mode == "shaded" { "phong" } else { "unlit" } },
    });
    if mode == "mip" {
        scene["method"] = json!("mip");
    }
    Scene::parse("scene", &scene.to_string()).expect("a scene")
}

/// The most memory that this process has had, in KiB; null where nobody says.
fn peak_kib() -> Value {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|line| line.trim().strip_suffix(" kB")?.parse::<u64>().ok());
    json!(kib)
}
