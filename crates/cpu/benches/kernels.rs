//! Single slots per type of sample and method, in samples per second on one thread, and what skipping costs.
//!
//!     cargo bench -p strahl-cpu --features bench-kernels --bench kernels
//!
//! `STRAHL_SIMD` chooses the instructions, as everywhere.

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::Duration;
use strahl_cpu::kernels::{Kernel, Packet, instructions, run};
use strahl_cpu::{Options, Renderer};
use strahl_scene::plan::Plan;
use strahl_scene::{Scene, resolve};
use strahl_volume::Control;
use strahl_volume::bends::bends;
use strahl_volume::bricks::Bricks;
use strahl_volume::{Grid, Metadata, Phantom, Rescale, SampleType, Samples, Volume};

/// Voxels along an edge: with 8 bits the volume fits into the second cache, with more into the third.
const EDGE: usize = 96;

/// Cells along the edge of the bricks that the renderer makes.
const BRICK_EDGE: usize = 4;

fn volume(kind: SampleType) -> Volume {
    let numbers = || {
        let tree = Phantom::Tree.volume([EDGE; 3]).expect("memory");
        let count = tree.grid().voxel_count();
        (0..count)
            .map(|i| tree.samples().get(i))
            .collect::<Vec<f64>>()
    };
    let samples = match kind {
        SampleType::U8 => Samples::U8(numbers().iter().map(|&v| v as u8).collect()),
        SampleType::I16 => Samples::I16(numbers().iter().map(|&v| v as i16).collect()),
        SampleType::U16 => Samples::U16(numbers().iter().map(|&v| v as u16).collect()),
        _ => Samples::F32(numbers().iter().map(|&v| v as f32).collect()),
    };
    let grid = Grid::centered([EDGE; 3], [1.0; 3].into()).expect("a grid");
    Volume::new(grid, samples, Rescale::IDENTITY, Metadata::default()).expect("a volume")
}

/// 8 × 4 rays, 0.7 voxels apart and oblique, a step of one voxel each: as a picture of such a volume has them.
fn packets() -> Vec<Packet> {
    let last = (EDGE - 3) as f32;
    let mut packets = Vec::new();
    for ray in 0..48 {
        let corner = [(ray % 8) as f32 * 8.0, (ray / 8) as f32 * 10.0];
        for step in 0..EDGE - 4 {
            let along = step as f32;
            packets.push([0, 1, 2].map(|axis| {
                std::array::from_fn(|lane| {
                    let (x, y) = ((lane % 8) as f32 * 0.7, (lane / 8) as f32 * 0.7);
                    let at = match axis {
                        0 => 1.5 + corner[0] + x + 0.3 * along,
                        1 => 1.5 + corner[1] + y + 0.2 * along,
                        _ => 1.5 + 0.93 * along - 0.1 * x,
                    };
                    at.clamp(1.0, last)
                })
            }));
        }
    }
    packets
}

fn plan(volume: &Volume, keys: &str) -> Plan {
    let text = format!(
        r#"{{
            "transfer_function": {{
                "points": [[20, 0, [1, 0, 0]], [60, 0.5, [1, 1, 1]], [90, 0.2, [0, 0, 1]]]
            }},
            {keys}
        }}"#
    );
    let scene = Scene::parse("scene", &text).expect("a scene");
    resolve(&scene, &volume.header(), None).expect("a plan")
}

fn kernels(criterion: &mut Criterion) {
    let set = instructions().expect("instructions");
    let packets = packets();
    let samples = (packets.len() * packets[0][0].len()) as u64;
    let mut bench = |group: &str, name: String, kernel, volume: &Volume, keys: &str| {
        let plan = plan(volume, keys);
        let mut group = criterion.benchmark_group(group);
        group
            .sample_size(20)
            .warm_up_time(Duration::from_millis(500));
        group.measurement_time(Duration::from_secs(2));
        group.throughput(Throughput::Elements(samples));
        group.bench_function(name, |bench| {
            bench.iter(|| black_box(run(kernel, set, &plan, volume, &packets)));
        });
        group.finish();
    };
    let types = [
        ("u8", SampleType::U8),
        ("i16", SampleType::I16),
        ("u16", SampleType::U16),
        ("f32", SampleType::F32),
    ];
    for (name, kind) in types {
        let volume = volume(kind);
        for method in ["nearest", "trilinear", "b-spline"] {
            let keys = format!(r#""reconstruct": "{method}""#);
            let name = format!("{method}, {name}");
            bench("reconstruct", name, Kernel::Reconstruct, &volume, &keys);
        }
        bench(
            "gradient",
            format!("central, {name}"),
            Kernel::Gradient,
            &volume,
            "",
        );
    }
    let of_bytes = volume(SampleType::U8);
    for method in ["forward", "central-9", "sobel", "b-spline"] {
        let keys = format!(r#""gradient": {{ "method": "{method}" }}"#);
        let name = format!("{method}, u8");
        bench("gradient", name, Kernel::Gradient, &of_bytes, &keys);
    }
    for (name, keys) in [
        ("table", ""),
        (
            "gradient-table",
            r#""functions": { "classify": {
                "module": "gradient_table", "params": { "low_per_mm": 5, "high_per_mm": 60 }
            } }"#,
        ),
        (
            "pre-classified",
            r#""functions": { "classify": { "module": "pre_classified" } }"#,
        ),
    ] {
        let name = name.to_owned();
        bench("classify", name, Kernel::Classify, &of_bytes, keys);
    }
}

/// What skipping needs, for 256³ voxels on all cores, and what it costs where there is nothing else to do.
fn skipping(criterion: &mut Criterion) {
    let shells = Phantom::Shells.volume([256; 3]).expect("memory");
    let mut group = criterion.benchmark_group("skipping");
    group
        .sample_size(20)
        .warm_up_time(Duration::from_millis(500));
    group.bench_function("bricks of 256³, u8", |bench| {
        bench.iter_with_large_drop(|| Bricks::with_edge(black_box(&shells), BRICK_EDGE));
    });
    let scene = |keys: &str| {
        let text = format!(r#"{{ "step_voxels": 1, {keys} }}"#);
        let scene = Scene::parse("scene", &text).expect("a scene");
        resolve(&scene, &shells.header(), None).expect("a plan")
    };
    let renderer = Renderer::new(&shells);
    // A new transfer function each time: what is kept of the last one does not help.
    let mut edits = 0.0;
    group.bench_function("what a transfer function shows, 256³", |bench| {
        bench.iter_batched(
            || {
                edits += 1e-4;
                let points = format!("[[{}, 0], [{}, 0.5]]", 0.5 + edits % 0.1, 0.7 + edits % 0.1);
                scene(&format!(
                    r#""transfer_function": {{ "points": {points} }}, "size": [1, 1]"#
                ))
            },
            |plan| renderer.render(&plan, &Options::default(), &Control::NONE),
            BatchSize::PerIteration,
        );
    });
    // Likewise a clip that moves.
    group.bench_function("what a clip leaves of it, 256³", |bench| {
        bench.iter_batched(
            || {
                edits += 1e-4;
                let (low, high) = (0.2 + edits % 0.1, 0.8 + edits % 0.1);
                scene(&format!(
                    r#""clips": [{{ "ellipsoid": {{
                        "min": [{low}, 0.2, 0.3], "max": [{high}, 0.7, 0.6], "space": "fraction"
                    }} }}], "size": [1, 1]"#
                ))
            },
            |plan| renderer.render(&plan, &Options::default(), &Control::NONE),
            BatchSize::PerIteration,
        );
    });
    group.bench_function("second differences of 256³, u8", |bench| {
        bench.iter_with_large_drop(|| bends(black_box(&shells), BRICK_EDGE));
    });
    // Nothing reaches the threshold but the brightest voxels: of each ray only jumps are left.
    let plan = scene(
        r#""size": [512, 512], "method": "first-hit", "threshold": 0.9999, "shading": { "model": "unlit" }"#,
    );
    group.bench_function("jumps of 512² rays through 256³", |bench| {
        bench.iter(|| renderer.render(&plan, &Options::default(), &Control::NONE));
    });
    group.finish();
}

criterion_group!(benches, kernels, skipping);
criterion_main!(benches);
