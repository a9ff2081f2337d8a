//! Pairs of scenes whose pictures must be the same, or mirrored.

use crate::random::{Random, renderers_of, seeds};
use crate::simple::{self, centered};
use glam::{DAffine3, DMat3, DVec3};
use strahl_conformance::{renderers, truth};
use strahl_scene::plan::*;
use strahl_scene::transfer::TransferTable;
use strahl_volume::{Grid, Metadata, Volume};

/// The Plan with everything in the world moved by `moved`: a rotation, a mirror or a scale about the
/// world's origin. `length` is its scale.
fn moved(plan: &Plan, grid: &Grid, moved: DMat3, length: f64) -> Plan {
    let direction = |v: DVec3| moved * v / length;
    let mut plan = plan.clone();
    plan.field_mut().grid = *grid;
    let camera = &mut plan.camera;
    camera.eye_mm = moved * camera.eye_mm;
    camera.right = direction(camera.right);
    camera.up = direction(camera.up);
    camera.forward = direction(camera.forward);
    if let Projection::Orthographic { half_height_mm } = &mut camera.projection {
        *half_height_mm *= length;
    }
    for light in &mut plan.lights {
        match light {
            PlanLight::Directional { to_light, .. } => *to_light = direction(*to_light),
            PlanLight::Point {
                place_mm, reach_mm, ..
            } => {
                *place_mm = moved * *place_mm;
                *reach_mm = (f64::from(*reach_mm) * length) as f32;
            }
            PlanLight::Head { .. } => {}
        }
    }
    for clip in &mut plan.ray_clips {
        clip.normal = direction(clip.normal);
        clip.offset_mm *= length;
    }
    for clip in &mut plan.sample_clips {
        clip.unit_from_world *= DAffine3::from_mat3(moved.inverse());
    }
    plan.lattice.step_mm *= length;
    let table = &plan.technique().table;
    let reference_mm = (f64::from(table.reference_mm()) * length) as f32;
    plan.technique_mut().table =
        TransferTable::new(table.domain(), reference_mm, table.entries().to_vec());
    plan
}

fn moved_volume(volume: &Volume, by: DMat3) -> Volume {
    let world_from_voxel = DAffine3::from_mat3(by) * volume.grid().world_from_voxel();
    let grid = Grid::new(volume.grid().dims(), world_from_voxel).unwrap();
    let (samples, rescale) = (volume.samples().clone(), volume.rescale());
    Volume::new(grid, samples, rescale, Metadata::default()).unwrap()
}

/// The moved scene gives the same bytes, or lies within the bounds of the first.
fn check_same(seed: u64, by: DMat3, length: f64, exactly: bool) {
    let mut random = Random::new(seed ^ 0x0E7A);
    let volume = random.volume();
    let plan = random.plan(&volume, [9, 7]);
    let other_volume = moved_volume(&volume, by);
    let other = moved(&plan, other_volume.grid(), by, length);
    let field = truth::Voxels::new(&volume, plan.field().reconstruct);
    for renderer in renderers_of(seed) {
        if !renderer.can_draw(&volume, &plan) {
            continue;
        }
        let bounds = renderer.bounds(&plan, &field);
        let image = renderer.draw(&volume, &plan);
        let found = renderer.draw(&other_volume, &other);
        for (i, bounds) in bounds.iter().enumerate() {
            let (a, b) = (image.pixels()[i], found.pixels()[i]);
            if exactly {
                assert_eq!(a, b, "{}, seed {seed}, pixel {i}", renderer.name);
            } else {
                let distance = bounds.distance(b);
                // The affine itself was rounded in turning, beside what single precision does.
                let allowed = renderer.tolerance(&plan).max(1e-5);
                assert!(
                    distance < allowed,
                    "{renderer}, seed {seed}, pixel {i}: {a:?}, {b:?}"
                );
            }
        }
    }
}

#[test]
fn turning_everything_changes_nothing() {
    for seed in seeds(150) {
        let by = DMat3::from_rotation_x(1.1) * DMat3::from_rotation_z(0.4 + seed as f64);
        check_same(seed, by, 1.0, false);
    }
}

#[test]
fn scaling_everything_by_a_power_of_two_changes_no_byte() {
    for seed in seeds(150) {
        let length = [2.0, 0.25][seed as usize % 2];
        check_same(
            seed,
            DMat3::from_diagonal(DVec3::splat(length)),
            length,
            true,
        );
    }
}

#[test]
fn a_mirrored_volume_gives_a_mirrored_picture() {
    let grid = centered([9, 11, 7], DMat3::from_diagonal(DVec3::new(1.0, 0.8, 1.3)));
    let field = |p: DVec3| (0.9 * p.x).sin() + 0.1 * p.x * p.y + (0.5 * p.z).cos();
    let volume = simple::volume(grid, field);
    let mirrored = simple::volume(grid, |p| field(p * DVec3::new(-1.0, 1.0, 1.0)));
    let entries = vec![[1.0, 0.0, 0.0, 0.0], [0.5, 1.0, 0.2, 0.4]];
    let table = TransferTable::new([-1.0, 2.0], 2.0, entries);
    let mut plan = simple::plan(&volume, simple::parallel(-DVec3::Y, 20.0, 4.0), table);
    plan.camera = simple::from_eye(plan.camera, 0.25);
    plan.technique_mut().shade = simple::blinn_phong(0.2, 0.7, 0.3, 8.0);
    plan.lights = vec![PlanLight::Head { radiance: [1.0; 3] }];
    for composite in [
        plan.technique().composite,
        Composite::FirstHit { threshold: 0.4 },
        Composite::Mip,
        Composite::Average,
    ] {
        plan.technique_mut().composite = composite;
        if matches!(composite, Composite::Mip | Composite::Average) {
            plan.technique_mut().shade = Shade::Unlit;
            plan.lights.clear();
        }
        for renderer in renderers() {
            let image = renderer.draw(&volume, &plan);
            let mirror = renderer.draw(&mirrored, &plan);
            let mut different = false;
            for y in 0..plan.height {
                for x in 0..plan.width {
                    let a = image.pixel(x, y);
                    let b = mirror.pixel(plan.width - 1 - x, y);
                    let close = a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-3);
                    assert!(close, "{composite:?}, column {x}, row {y}: {a:?} and {b:?}");
                    different |= image.pixel(x, y) != mirror.pixel(x, y);
                }
            }
            assert!(different, "the scene is its own mirror image");
        }
    }
}

#[test]
fn an_opacity_of_twice_the_length_is_the_same_material() {
    let grid = centered([10; 3], DMat3::IDENTITY);
    let volume = simple::volume(grid, |p| 0.5 + 0.05 * p.x);
    let table = |reference_mm: f32, length: i32| {
        let entry = |i: usize| {
            let opacity = 0.3 * i as f32 / 255.0;
            [0.2, 0.4, 0.8, 1.0 - (1.0 - opacity).powi(length)]
        };
        TransferTable::new([0.0, 1.0], reference_mm, (0..256).map(entry).collect())
    };
    let view = simple::parallel(DVec3::new(0.2, 0.9, 0.3), 30.0, 2.0);
    let once = simple::draw(&volume, &simple::plan(&volume, view, table(1.0, 1)));
    let twice = simple::draw(&volume, &simple::plan(&volume, view, table(2.0, 2)));
    for (a, b) in once.iter().zip(&twice) {
        assert!(a.3[3] > 0.3, "{a:?}");
        let close = a.3.iter().zip(b.3).all(|(a, b)| (a - b).abs() < 2e-5);
        assert!(close, "{a:?} {b:?}");
    }
}
