//! Renderers against the truth on random scenes.

use crate::random::{Random, seeds};
use strahl_conformance::{renderers, truth};
use strahl_scene::plan::{Illuminate, Plan, PlanLight, Shade};
use strahl_scene::transfer::TransferTable;

/// The brightest colour that a Plan can give, at least 1: tolerances are shares of it.
fn brightest(plan: &Plan) -> f64 {
    let Shade::Lit {
        ambient,
        illuminate: Illuminate::BlinnPhong {
            diffuse, specular, ..
        },
        ..
    } = plan.technique().shade
    else {
        return 1.0;
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
    f64::from(ambient + (diffuse + specular) * radiance).max(1.0)
}

/// The plan as a message shows it: without the many entries of its table.
fn without_table(plan: &Plan) -> Plan {
    let mut plan = plan.clone();
    plan.technique_mut().table = TransferTable::new([0.0, 1.0], 1.0, vec![[0.0; 4]; 2]);
    plan
}

#[test]
fn every_pixel_of_a_random_scene_lies_within_its_bounds() {
    let renderers = renderers();
    // Bounds that anything passes would test nothing: how wide they are, and what is seen.
    let (mut pixels, mut narrow, mut not_background) = (0, 0, 0);
    let mut worst = 0.0f64;
    for seed in seeds(1000) {
        let mut random = Random::new(seed);
        let volume = random.volume();
        let plan = random.plan(&volume, [9, 7]);
        let bounds = truth::bounds(
            &plan,
            &truth::Voxels::new(&volume, plan.field().reconstruct),
        );
        for bounds in &bounds {
            pixels += 1;
            narrow += usize::from(bounds.doubt() < 1e-3);
            not_background += usize::from(bounds.distance(plan.background) > 1e-3);
        }
        for renderer in &renderers {
            let image = (renderer.draw)(&volume, &plan);
            for (i, (pixel, bounds)) in image.pixels().iter().zip(&bounds).enumerate() {
                let share = bounds.distance(*pixel) / brightest(&plan);
                worst = worst.max(share);
                assert!(
                    share <= renderer.tolerance,
                    "{}, seed {seed}, column {}, row {}: {pixel:?} is {share} outside {bounds:?}\n\
                     {:?} voxels of {}, {:#?}",
                    renderer.name,
                    i % 9,
                    i / 9,
                    volume.grid().dims(),
                    volume.sample_type(),
                    without_table(&plan),
                );
            }
        }
    }
    println!(
        "{pixels} pixels, {narrow} narrow, {not_background} show something, worst {worst:.2e}"
    );
    assert!(
        narrow * 100 > pixels * 90,
        "{narrow} of {pixels} are narrow"
    );
    assert!(
        not_background * 100 > pixels * 15,
        "{not_background} of {pixels}"
    );
}
