#![no_main]
//! The text of a scene, resolved against two volumes. What is understood is written so that it means
//! the same, and a plan keeps what `docs/plan.md` promises.

use std::sync::LazyLock;
use strahl_scene::plan::{Plan, PlanLight, Projection};
use strahl_scene::{Scene, resolve};
use strahl_volume::{Grid, Metadata, Modality, Rescale, Samples, Volume, VolumeHeader};

static HEADERS: LazyLock<[VolumeHeader; 2]> = LazyLock::new(|| {
    let header = |samples, rescale, modality| {
        let grid = Grid::centered([4, 3, 2], [0.5, 0.7, 2.0].into()).unwrap();
        let metadata = Metadata {
            modality,
            ..Metadata::default()
        };
        Volume::new(grid, samples, rescale, metadata)
            .unwrap()
            .header()
    };
    let stored = (0..24).map(|i| i * 150).collect();
    let ct = header(
        Samples::U16(stored),
        Rescale::new(1.0, -1024.0),
        Some(Modality::Ct),
    );
    let flat = header(Samples::F32(vec![f32::NAN; 24]), Rescale::IDENTITY, None);
    [ct, flat]
});

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let Ok(text) = std::str::from_utf8(input) else {
        return;
    };
    let Ok(scene) = Scene::parse("scene.json", text) else {
        return;
    };
    let again = Scene::parse("again.json", &scene.to_json());
    assert_eq!(again.ok().as_ref(), Some(&scene));
    for header in HEADERS.iter() {
        match resolve(&scene, header, None) {
            Ok(plan) => check(&plan),
            Err(problems) => assert!(!problems.to_string().is_empty()),
        }
    }
});

fn check(plan: &Plan) {
    let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
    assert!((1..=65_535).contains(&plan.width) && (1..=65_535).contains(&plan.height));
    let camera = &plan.camera;
    assert!(camera.eye_mm.is_finite());
    for axis in [camera.right, camera.up, camera.forward] {
        assert!(near(axis.length(), 1.0));
    }
    assert!(camera.right.cross(camera.up).distance(-camera.forward) < 1e-9);
    let half = match camera.projection {
        Projection::Perspective { tan_half_height } => tan_half_height,
        Projection::Orthographic { half_height_mm } => half_height_mm,
    };
    assert!(half > 0.0 && half.is_finite());
    assert!(plan.lattice.step_mm > 0.0 && plan.lattice.step_mm.is_finite());
    let table = &plan.technique().table;
    let [lo, hi] = table.domain();
    assert!(lo.is_finite() && hi.is_finite() && lo < hi);
    assert!(table.reference_mm() > 0.0 && table.reference_mm().is_finite());
    assert!(table.entries().len() >= 2);
    for &[r, g, b, opacity] in table.entries() {
        assert!([r, g, b].iter().all(|c| c.is_finite() && *c >= 0.0));
        assert!((0.0..=1.0).contains(&opacity));
    }
    for light in &plan.lights {
        let radiance = match light {
            PlanLight::Directional { to_light, radiance } => {
                assert!(near(to_light.length(), 1.0));
                radiance
            }
            PlanLight::Point {
                place_mm,
                reach_mm,
                radiance,
            } => {
                assert!(place_mm.is_finite() && *reach_mm > 0.0 && reach_mm.is_finite());
                radiance
            }
            PlanLight::Head { radiance } => radiance,
        };
        assert!(radiance.iter().all(|r| (0.0..=1000.0).contains(r)));
    }
    for plane in &plan.ray_clips {
        assert!(near(plane.normal.length(), 1.0) && plane.offset_mm.is_finite());
    }
    for clip in &plan.sample_clips {
        assert!(clip.unit_from_world.is_finite());
    }
    assert!(plan.background.iter().all(|c| (0.0..=1.0).contains(c)));
    assert!(plan.display.exposure > 0.0 && plan.display.exposure.is_finite());
}
