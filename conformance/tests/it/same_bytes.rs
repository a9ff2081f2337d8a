//! Threads, tiles, skipping and instruction sets change no byte of a picture that the processor draws.

use crate::random::{Random, seeds};
use std::path::PathBuf;
use strahl_cpu::{InstructionSet, Options, Renderer, Stats, no_progress};
use strahl_scene::plan::{Composite, Plan, Shade};
use strahl_scene::{Method, Scene, Shading, ShadingModel, resolve};
use strahl_volume::Volume;
use strahl_volume::read::{MemoryFiles, ReadOptions, read_file};

/// The pixels as bits, so that NaN equals itself and 0 is not −0.
fn draw(renderer: &Renderer, plan: &Plan, options: &Options) -> (Vec<[u32; 4]>, Stats) {
    let rendered = renderer.render(plan, options, &no_progress).unwrap();
    let bits = |pixel: &[f32; 4]| pixel.map(f32::to_bits);
    (
        rendered.image.pixels().iter().map(bits).collect(),
        rendered.stats,
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

/// Draws once plainly, then in other ways; returns the share of lattice points that were skipped.
fn check(what: &str, volume: &Volume, plan: &Plan, ways: &[(usize, u32, bool)]) -> f64 {
    let renderer = Renderer::new(volume);
    let (expected, plain) = draw(&renderer, plan, &plainly());
    let mut skipped = 0.0;
    // Every set that this processor has, in turns.
    let sets = InstructionSet::ALL.into_iter().filter(|set| set.is_there());
    for (&(threads, tile, skip), set) in ways.iter().zip(sets.cycle()) {
        let options = Options {
            threads,
            tile,
            skip,
            instructions: Some(set),
        };
        let (found, stats) = draw(&renderer, plan, &options);
        if let Some(i) = (0..expected.len()).find(|&i| expected[i] != found[i]) {
            panic!(
                "{what}, {options:?}: pixel {i} is {:?} instead of {:?}\n{:?}",
                found[i].map(f32::from_bits),
                expected[i].map(f32::from_bits),
                plan.composite
            );
        }
        assert_eq!(stats.lattice_points, plain.lattice_points, "{what}");
        assert_eq!(stats.samples_visible == 0, plain.samples_visible == 0);
        if skip {
            skipped = stats.points_skipped as f64 / (stats.lattice_points as f64).max(1.0);
        } else {
            assert_eq!(stats.points_skipped, 0);
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
    let mut skipping = 0;
    for seed in seeds(400) {
        let mut random = Random::new(seed ^ 0x5A3E);
        let volume = random.volume();
        let plan = random.plan(&volume, [19, 13]);
        let way = ways[seed as usize % ways.len()];
        let what = format!("seed {seed}");
        let skipped = check(&what, &volume, &plan, &[(1, WHOLE, true), way]);
        skipping += usize::from(skipped > 0.0);
    }
    // Small noisy volumes have few empty bricks; but some scenes must have something to skip.
    assert!(skipping >= 25, "only {skipping} scenes skipped anything");
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
    let methods = [
        Method::EmissionAbsorption,
        Method::Mip,
        Method::Minip,
        Method::Average,
        Method::FirstHit,
    ];
    for method in methods {
        let surface = matches!(method, Method::EmissionAbsorption | Method::FirstHit);
        let models: &[_] = if surface {
            &[ShadingModel::Unlit, ShadingModel::BlinnPhong]
        } else {
            &[ShadingModel::Unlit]
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
            assert_eq!(plan.shade == Shade::Unlit, model == ShadingModel::Unlit);
            let ways = [(7, 7, true), (2, 32, false), (2, 1, true)];
            let skipped = check(&format!("{name} {method:?}"), &volume, &plan, &ways);
            if matches!(plan.composite, Composite::FirstHit { .. } | Composite::Mip) {
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
