//! Threads, tiles, skipping and instruction sets change no byte of a picture that the CPU draws.

use crate::random::{Random, seeds};
use crate::simple;
use glam::{DAffine3, DMat3, DQuat, DVec3};
use std::collections::BTreeMap;
use std::path::PathBuf;
use strahl_cpu::{Counts, InstructionSet, Options, Renderer};
use strahl_scene::plan::{
    ALL_LAYERS, Classify, ClipShape, Composite, Plan, SampleClip, Sampling, Shade,
};
use strahl_scene::{Method, Scene, Shading, ShadingModel, resolve};
use strahl_volume::read::{MemoryFiles, ReadOptions, read_file};
use strahl_volume::{Control, Datasets, Metadata, Rescale, Samples, Volume};

/// The pixels as bits, so that NaN equals itself and 0 is not −0.
fn draw(renderer: &Renderer, plan: &Plan, options: &Options) -> (Vec<[u32; 4]>, Counts) {
    let rendered = renderer.render(plan, options, &Control::NONE).unwrap();
    let bits = |pixel: &[f32; 4]| pixel.map(f32::to_bits);
    (
        rendered.image.pixels().iter().map(bits).collect(),
        rendered.stats.counts.unwrap(),
    )
}

const WHOLE: u32 = 1 << 16;

fn plainly() -> Options {
    Options {
        threads: 1,
        tile: WHOLE,
        skip: false,
        instructions: Some(InstructionSet::Portable),
    }
}

/// The same picture, but drawn by the loop for any functions: with a clip that clips nothing.
fn without_own_loop(plan: &Plan) -> Plan {
    let mut plan = plan.clone();
    plan.sample_clips.push(SampleClip {
        shape: ClipShape::Box,
        unit_from_world: DAffine3::from_scale_rotation_translation(
            DVec3::ZERO,
            DQuat::IDENTITY,
            DVec3::splat(2.0),
        ),
        keep_inside: false,
        layers: ALL_LAYERS,
    });
    plan
}

/// Draws once plainly, then in other ways; returns the share of lattice points that were skipped.
fn check(what: &str, data: impl Into<Datasets>, plan: &Plan, ways: &[(usize, u32, bool)]) -> f64 {
    let renderer = Renderer::new(data);
    let (expected, plain) = draw(&renderer, &without_own_loop(plan), &plainly());
    let mut skipped = 0.0;
    // Every set that this CPU has, in turns.
    let sets = InstructionSet::ALL.into_iter().filter(|set| set.is_there());
    for (&(threads, tile, skip), set) in ways.iter().zip(sets.cycle()) {
        let options = Options {
            threads,
            tile,
            skip,
            instructions: Some(set),
        };
        let (found, counts) = draw(&renderer, plan, &options);
        if let Some(i) = (0..expected.len()).find(|&i| expected[i] != found[i]) {
            panic!(
                "{what}, {options:?}: pixel {i} is {:?} instead of {:?}\n{:?}",
                found[i].map(f32::from_bits),
                expected[i].map(f32::from_bits),
                plan.technique().composite
            );
        }
        assert_eq!(counts.lattice_points, plain.lattice_points, "{what}");
        assert_eq!(counts.samples_visible == 0, plain.samples_visible == 0);
        if skip {
            skipped = counts.points_skipped as f64 / (counts.lattice_points as f64).max(1.0);
        } else {
            assert_eq!(counts.points_skipped, 0);
        }
    }
    skipped
}

#[test]
fn on_random_scenes() {
    let ways = [
        (1, WHOLE, true),
        (2, 1, false),
        (7, 7, true),
        (2, 32, true),
        (7, 1, true),
    ];
    // By composite, the scenes that skipped a fifth of their points and more.
    let mut skipping: BTreeMap<String, usize> = BTreeMap::new();
    for seed in seeds(400) {
        let mut random = Random::new(seed ^ 0x5A3E);
        // Small noisy volumes have few empty bricks; blobs are surrounded by them.
        let is_blob = seed % 3 == 0;
        let volume = if is_blob {
            let grid = crate::simple::centered([48; 3], random.rotation());
            crate::variants::blobs(grid, &[random.direction() * 9.0], 5.0)
        } else {
            random.volume()
        };
        let mut plan = random.plan(&volume, [19, 13]);
        if is_blob {
            plan.technique_mut().table = crate::variants::ramp();
        }
        let way = ways[seed as usize % ways.len()];
        let what = format!("seed {seed}");
        let skipped = check(&what, &volume, &plan, &[(1, WHOLE, true), way]);
        let composite = plan.technique().composite.function().name;
        *skipping.entry(composite.to_owned()).or_default() += usize::from(skipped > 0.2);
    }
    println!("{skipping:?}");
    for (composite, least) in [
        ("emission_absorption", 20),
        ("first_hit", 10),
        ("mip", 5),
        ("minip", 1),
    ] {
        let scenes = skipping[composite];
        assert!(scenes >= least, "{composite}: only {scenes} skipped");
    }
}

/// Voxels of a few values, most of them the same, some of them not finite.
fn ties_and_peaks(random: &mut Random, dims: [usize; 3]) -> Volume {
    let usual = random.pick(&[0.0, 0.0, 7.0, -3.0]);
    let (values, rare) = (
        random.pick(&[1, 2, 5, 100]),
        random.pick(&[2, 20, 200, 2000]),
    );
    let broken = random.once_in(3);
    let count = dims.iter().product();
    let voxels: Vec<f32> = std::iter::repeat_with(|| {
        if broken && random.once_in(50) {
            random.pick(&[f32::NAN, f32::INFINITY, f32::NEG_INFINITY])
        } else if random.once_in(rare) {
            usual + random.below(2 * values + 1) as f32 - values as f32
        } else {
            usual
        }
    })
    .take(count)
    .collect();
    let samples = match random.below(3) {
        0 => Samples::U8(voxels.iter().map(|&v| v as u8).collect()),
        1 => Samples::I16(voxels.iter().map(|&v| v as i16).collect()),
        _ => Samples::F32(voxels),
    };
    let rescale = if random.once_in(3) {
        Rescale::new(-2.5, 10.0)
    } else {
        Rescale::IDENTITY
    };
    let grid = simple::centered(dims, DMat3::IDENTITY);
    Volume::new(grid, samples, rescale, Metadata::default()).unwrap()
}

/// Rays look where the largest value is likely; also where the gradient there counts, and so which of many
/// equal values is taken.
#[test]
fn of_projections_with_ties() {
    let mut skipping = 0;
    for seed in seeds(160) {
        let mut random = Random::new(seed ^ 0x71E5);
        let long = random.once_in(5);
        let dims = if long {
            [5, 4, 140]
        } else {
            random.pick(&[[9, 9, 9], [24, 21, 23], [40, 1, 33], [2, 30, 50]])
        };
        let volume = ties_and_peaks(&mut random, dims);
        let mut plan = random.plan(&volume, [19, 13]);
        plan.technique_mut().composite = random.pick(&[Composite::Mip, Composite::Minip]);
        plan.technique_mut().shade = Shade::Unlit;
        plan.lights.clear();
        if random.once_in(2) {
            plan.technique_mut().classify = Classify::GradientTable {
                low_per_mm: 0.1,
                high_per_mm: 2.0,
            };
        }
        if long {
            // More points than are looked at together.
            plan.camera = simple::parallel(DVec3::new(0.01, 0.0, 1.0), 300.0, 3.0);
            plan.lattice.step_mm = 0.05;
        }
        let what = format!("seed {seed}");
        let ways = [(1, WHOLE, true), (2, 5, true), (2, 32, false), (1, 8, true)];
        skipping += usize::from(check(&what, &volume, &plan, &ways) > 0.25);
    }
    assert!(
        skipping >= 10,
        "only {skipping} skipped a quarter of the points"
    );
}

/// As many scenes again, by every rule of sampling.
#[test]
fn by_every_rule_of_sampling() {
    let ways = [(1, WHOLE, true), (7, 7, true), (2, 1, true)];
    let (mut skipping, mut others) = (0, 0);
    for seed in seeds(600) {
        let mut random = Random::new(seed ^ 0x57E9);
        let volume = random.volume();
        let mut plan = random.plan(&volume, [19, 13]);
        plan.sampling = random.sampling(&plan);
        others += usize::from(plan.sampling != Sampling::Regular);
        let skipped = check(&format!("seed {seed}"), &volume, &plan, &ways);
        skipping += usize::from(skipped > 0.0);
    }
    assert!(others >= 200 && skipping >= 35, "{others}, {skipping}");
}

/// Bricks that clips leave nothing of are left out, by every composite rule.
#[test]
fn with_clips_of_every_shape() {
    let ways = [(1, WHOLE, true), (7, 7, true), (2, 1, true)];
    let (mut skipping, mut shown) = (0, 0);
    for seed in seeds(400) {
        let mut random = Random::new(seed ^ 0xC119);
        let volume = random.volume();
        let mask = match random.below(3) {
            0 => random.volume(),
            _ => ties_and_peaks(&mut random, volume.grid().dims()),
        };
        let mut plan = random.plan(&volume, [19, 13]);
        plan.sampling = random.sampling(&plan);
        for _ in 0..1 + random.below(2) {
            let clip = random.sample_clip(volume.grid(), &mask);
            plan.sample_clips.push(clip);
        }
        let data = Datasets {
            masks: vec![mask.clone()],
            ..Datasets::from(&volume)
        };
        let skipped = check(&format!("seed {seed}"), data, &plan, &ways);
        skipping += usize::from(skipped > 0.0);
        shown += usize::from(skipped < 1.0);
    }
    assert!(skipping >= 100 && shown >= 200, "{skipping}, {shown}");
}

fn scan(name: &str) -> Option<Volume> {
    let shared = std::env::var_os("STRAHL_SHARED").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared"),
        PathBuf::from,
    );
    let path = shared.join("data").join(name);
    let Ok(bytes) = std::fs::read(&path) else {
        eprintln!("skipped: {} is not there", path.display());
        return None;
    };
    let folder = MemoryFiles::from([(name.to_owned(), bytes)]);
    let loaded = read_file(name, &folder, &ReadOptions::default()).unwrap();
    Some(loaded.volume)
}

/// Every composite, unlit and lit where it may be, of a scan with its own preset.
fn check_scan(name: &str) {
    let Some(volume) = scan(name) else { return };
    for method in Method::ALL {
        let models: &[_] = if method.is_projection() {
            &[ShadingModel::Unlit]
        } else {
            &[ShadingModel::Unlit, ShadingModel::BlinnPhong]
        };
        for &model in models {
            let scene = Scene {
                method: Some(method),
                shading: Some(Shading {
                    model: Some(model),
                    ..Shading::default()
                }),
                size: Some([45, 39]),
                ..Scene::default()
            };
            let plan = resolve(&scene, &volume.header(), None).unwrap();
            assert_eq!(
                plan.technique().shade == Shade::Unlit,
                model == ShadingModel::Unlit
            );
            let ways = [(7, 7, true), (2, 32, false), (2, 1, true)];
            let skipped = check(&format!("{name} {method:?}"), &volume, &plan, &ways);
            if matches!(
                plan.technique().composite,
                Composite::FirstHit { .. } | Composite::Mip
            ) {
                assert!(skipped > 0.05, "{name}, {method:?}: {skipped} skipped");
            }
        }
    }
}

#[test]
fn on_the_fuel() {
    check_scan("fuel.nii.gz");
}

#[test]
fn on_the_engine() {
    check_scan("engine.nii.gz");
}

#[test]
fn on_the_brain() {
    check_scan("brain-t1.nii.gz");
}
