//! Renderers against the truth on random scenes.

use crate::random::{Random, renderers_of, seeds};
use std::collections::BTreeMap;
use strahl_conformance::truth::{self, Bounds};
use strahl_scene::plan::{Illuminate, Plan, PlanLight, Shade};
use strahl_scene::transfer::TransferTable;
use strahl_volume::Volume;

/// The brightest color that a Plan can give, at least 1: tolerances are shares of it.
fn brightest(plan: &Plan) -> f64 {
    let Shade::Lit {
        ambient,
        illuminate,
        ..
    } = plan.technique().shade
    else {
        return 1.0;
    };
    let material = match illuminate {
        Illuminate::BlinnPhong {
            diffuse, specular, ..
        } => diffuse + specular,
        Illuminate::Lambert { diffuse } => diffuse,
        _ => 0.0,
    };
    let radiance: f32 = plan
        .lights
        .iter()
        .map(|light| match light {
            PlanLight::Directional { radiance, .. }
            | PlanLight::Point { radiance, .. }
            | PlanLight::Head { radiance } => radiance.iter().fold(0.0, |a: f32, &b| a.max(b)),
        })
        .sum();
    f64::from(ambient + material * radiance).max(1.0)
}

/// The plan as a message shows it: without the many entries of its table.
fn without_table(plan: &Plan) -> Plan {
    let mut plan = plan.clone();
    plan.technique_mut().table = TransferTable::new([0.0, 1.0], 1.0, vec![[0.0; 4]; 2]);
    plan
}

/// What the rows of docs/coverage.md that name this test are about, as far as the scene has it.
fn subjects(plan: &Plan, volume: &Volume) -> Vec<String> {
    let technique = plan.technique();
    let name = |debug: String| {
        debug
            .split([' ', '('])
            .next()
            .unwrap_or_default()
            .to_owned()
    };
    let mut subjects = vec![
        name(format!("{:?}", technique.composite)),
        name(format!("{:?}", plan.field().reconstruct)),
        name(format!("{:?}", plan.camera.projection)),
        name(format!("{:?}", plan.lattice.jitter)),
        format!("{} planes", plan.ray_clips.len()),
        format!("{} boxes", plan.sample_clips.len()),
    ];
    match technique.shade {
        Shade::Lit { illuminate, .. } => subjects.push(name(format!("{illuminate:?}"))),
        _ => subjects.push("Unlit".into()),
    }
    let (lights, several) = (&plan.lights, "several lights");
    subjects.extend(lights.iter().map(|light| name(format!("{light:?}"))));
    let (lo, hi) = volume.grid().bounds_mm();
    let eye_mm = plan.camera.eye_mm;
    let is_inside = eye_mm.cmpgt(lo).all() && eye_mm.cmplt(hi).all();
    for (is_it, what) in [
        (lights.len() > 1, several),
        (is_inside, "eye in the volume"),
        (volume.statistics().not_finite > 0, "NaN or infinite"),
        (
            plan.ray_clips.len() + plan.sample_clips.len() > 1,
            "several clips",
        ),
    ] {
        subjects.extend(is_it.then(|| what.to_owned()));
    }
    subjects.sort();
    subjects.dedup();
    subjects
}

/// What the test has to have seen in so many scenes.
const SUBJECTS: [&str; 27] = [
    "EmissionAbsorption",
    "Mip",
    "Minip",
    "Average",
    "FirstHit",
    "Trilinear",
    "Nearest",
    "BSpline",
    "CatmullRom",
    "Perspective",
    "Orthographic",
    "Center",
    "Hash",
    "1 planes",
    "2 planes",
    "1 boxes",
    "2 boxes",
    "several clips",
    "Unlit",
    "Lambert",
    "BlinnPhong",
    "several lights",
    "eye in the volume",
    "NaN or infinite",
    "Directional",
    "Head",
    "Point",
];

/// What the pictures of a renderer were like.
#[derive(Debug, Default)]
struct Seen {
    scenes: usize,
    pixels: usize,
    /// Bounds that anything passes would test nothing: pixels with narrow ones.
    narrow: usize,
    not_background: usize,
    /// Scenes that show something, by what they have.
    subjects: BTreeMap<String, usize>,
    /// How far a pixel lay outside, as a share of the brightest color.
    worst: f64,
}

/// The CPU draws every random scene, the evaluator one in five and the GPU one in 20, those
/// that they can draw.
#[test]
fn every_pixel_of_a_random_scene_lies_within_its_bounds() {
    let mut seen: BTreeMap<&str, Seen> = BTreeMap::new();
    let mut failed = Vec::new();
    for seed in seeds(1000) {
        let mut random = Random::new(seed);
        let volume = random.volume();
        let plan = random.plan(&volume, [9, 7]);
        let field = truth::Voxels::new(&volume, plan.field().reconstruct);
        for renderer in renderers_of(seed) {
            if !renderer.can_draw(&volume, &plan) {
                continue;
            }
            let image = renderer.draw(&volume, &plan);
            let tolerance = renderer.tolerance(&plan);
            let seen = seen.entry(renderer.name).or_default();
            seen.scenes += 1;
            let bounds = renderer.bounds(&plan, &field);
            // Of a few pixels that bounds say much of: what else is there shows in the others.
            let tells = |b: &&Bounds| b.doubt() < 1e-3 && b.distance(plan.background) > 1e-3;
            if bounds.iter().filter(tells).count() >= 4 {
                for subject in subjects(&plan, &volume) {
                    *seen.subjects.entry(subject).or_default() += 1;
                }
            }
            for (i, (pixel, bounds)) in image.pixels().iter().zip(&bounds).enumerate() {
                seen.pixels += 1;
                seen.narrow += usize::from(bounds.doubt() < 1e-3);
                seen.not_background += usize::from(bounds.distance(plan.background) > 1e-3);
                let share = bounds.distance(*pixel) / brightest(&plan);
                seen.worst = seen.worst.max(share);
                if share > tolerance {
                    failed.push(format!(
                        "{renderer}, seed {seed}, column {}, row {}: {pixel:?} is {share} outside {bounds:?}, {tolerance} is \
                         allowed; {:?} voxels of {}, {:?}",
                        i % 9,
                        i / 9,
                        volume.grid().dims(),
                        volume.sample_type(),
                        without_table(&plan),
                    ));
                }
            }
        }
    }
    println!("{seen:#?}");
    let few: String = failed.iter().take(10).map(|f| format!("{f}\n")).collect();
    assert!(failed.is_empty(), "{} pixels:\n{few}", failed.len());
    for (name, seen) in seen {
        assert!(seen.narrow * 100 > seen.pixels * 85, "{name}: {seen:?}");
        assert!(
            seen.not_background * 100 > seen.pixels * 15,
            "{name}: {seen:?}"
        );
        // A renderer that draws few scenes cannot see all of it.
        let subjects = SUBJECTS.iter().filter(|_| seen.scenes >= 100);
        for subject in subjects {
            let number = seen.subjects.get(*subject).copied().unwrap_or(0);
            assert!(
                number * 200 > seen.scenes,
                "{name}: {subject} in {number} scenes of {}",
                seen.scenes
            );
        }
    }
}
