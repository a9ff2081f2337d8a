//! The variants of every step that have no brute-force truth: exact answers, and pairs of pictures
//! that must be the same.

use crate::parameters::random_values;
use crate::random::{Random, seeds};
use crate::simple::{
    blinn_phong, centered, cut_box, grey, grids, of_samples, one_sample_at, parallel, plan, plane,
    value_shown, volume, white,
};
use crate::techniques::any_illustration;
use crate::value_gradient::table_over;
use glam::{DAffine3, DMat3, DQuat, DVec3};
use std::collections::{BTreeMap, HashMap};
use strahl_cpu::{Options, Rendered, Renderer};
use strahl_scene::OtherData;
use strahl_scene::plan::*;
use strahl_scene::transfer::TransferTable;
use strahl_shader::registry::{FUNCTIONS, Function, Skips};
use strahl_volume::{Control, Datasets, Grid, Mesh, Samples, Volume};

/// Every estimate of the gradient.
fn estimates() -> Vec<GradientMethod> {
    Function::of_slot("gradient")
        .map(|function| GradientMethod::of(function.name, |p| function.default_of(p)).unwrap())
        .collect()
}

pub fn draw(data: impl Into<Datasets>, plan: &Plan) -> Rendered {
    draw_with(data, plan, &Options::default())
}

pub fn draw_with(data: impl Into<Datasets>, plan: &Plan, options: &Options) -> Rendered {
    Renderer::new(data)
        .render(plan, options, &Control::NONE)
        .unwrap_or_else(|error| panic!("{error}"))
}

/// The largest difference of a channel.
pub fn distance(a: &Rendered, b: &Rendered) -> f32 {
    let pixels = a.image.pixels().iter().zip(b.image.pixels());
    pixels
        .flat_map(|(a, b)| a.iter().zip(b).map(|(a, b)| (a - b).abs()))
        .fold(0.0, f32::max)
}

/// Blobs with soft borders, one per number.
pub fn blobs(grid: Grid, centers: &[DVec3], radius_mm: f64) -> Volume {
    volume(grid, |p| {
        let near = centers
            .iter()
            .map(|c| c.distance(p))
            .fold(f64::MAX, f64::min);
        (1.5 - near / radius_mm).clamp(0.0, 1.0)
    })
}

/// Transparent up to 0.2, then a ramp in color and opacity.
pub fn ramp() -> TransferTable {
    let entries = (0..64)
        .map(|i| {
            let v = i as f32 / 63.0;
            [v, 0.4, 1.0 - v, ((v - 0.2) * 0.8).max(0.0)]
        })
        .collect();
    TransferTable::new([0.0, 1.0], 1.0, entries)
}

#[test]
fn every_estimator_gives_the_slope_of_a_ramp_on_every_grid() {
    let slope = DVec3::new(0.3, -0.2, 0.5);
    for grid in grids() {
        let ramp = volume(grid, |p| 0.5 + p.dot(slope));
        for method in estimates() {
            let mut plan = plan(&ramp, parallel(DVec3::Y, 100.0, 0.5), white(1.0, 1.0));
            one_sample_at(&mut plan, 0.0);
            plan.field_mut().gradient = method;
            plan.technique_mut().composite =
                Composite::Debug(DebugView::GradientMagnitude { white_per_mm: 2.0 });
            let steep = draw(&ramp, &plan);
            plan.technique_mut().composite = Composite::Debug(DebugView::Normal);
            let normal = draw(&ramp, &plan);
            for y in 0..plan.height {
                for x in 0..plan.width {
                    let found = 2.0 * f64::from(steep.image.pixel(x, y)[0]);
                    assert!(
                        (found - slope.length()).abs() < 1e-4,
                        "{method:?}: {found} instead of {}",
                        slope.length()
                    );
                    let color = normal.image.pixel(x, y);
                    let found =
                        DVec3::from_array([0, 1, 2].map(|c| f64::from(color[c]))) * 2.0 - 1.0;
                    assert!(
                        found.distance(slope.normalize()) < 1e-4,
                        "{method:?}: {found}"
                    );
                }
            }
        }
    }
}

#[test]
fn the_gradient_of_opacity_is_that_of_the_classified_ramp() {
    let grid = centered([16; 3], DMat3::IDENTITY);
    let values = volume(grid, |p| 0.5 + 0.02 * p.x);
    // Opacity 0.8 (v − 0.2) between the border and the middle: 0.8 · 0.02 per mm.
    let mut plan = plan(&values, parallel(DVec3::Y, 100.0, 0.5), ramp());
    one_sample_at(&mut plan, 0.0);
    plan.technique_mut().composite =
        Composite::Debug(DebugView::GradientMagnitude { white_per_mm: 0.02 });
    plan.technique_mut().gradient_input = GradientInput::Opacity;
    for method in estimates() {
        plan.field_mut().gradient = method;
        let found = draw(&values, &plan).image.pixel(4, 3)[0];
        assert!((found - 0.8).abs() < 1e-3, "{method:?}: {found}");
    }
}

#[test]
fn back_to_front_is_front_to_back_without_an_early_end() {
    for seed in seeds(60) {
        let mut random = Random::new(seed ^ 0xB2F);
        let volume = random.volume();
        let mut plan = random.plan(&volume, [9, 7]);
        plan.technique_mut().composite = Composite::EmissionAbsorption {
            stop_at_transmittance: 0.0,
        };
        let forwards = draw(&volume, &plan);
        plan.technique_mut().composite = Composite::BackToFront;
        let off = distance(&forwards, &draw(&volume, &plan));
        assert!(off < 2e-5, "seed {seed}: {off}");
    }
}

/// Two overlapping volumes in a Plan, of the same world.
pub fn two(first: &Volume, second: &Volume) -> Plan {
    let mut plan = plan(
        first,
        parallel(DVec3::new(0.2, 1.0, -0.3), 60.0, 14.0),
        ramp(),
    );
    (plan.width, plan.height) = (23, 19);
    let field = Field {
        volume: 1,
        grid: *second.grid(),
        rescale: second.rescale(),
        ..*plan.field()
    };
    let technique = Technique {
        table: white(0.3, 1.0),
        ..plan.technique().clone()
    };
    plan.add_layer(field, technique);
    plan
}

/// Changes every technique of a Plan in the same way.
pub fn change_all(plan: &mut Plan, change: impl Fn(&mut Technique)) {
    plan.techniques.iter_mut().for_each(change);
}

pub fn pair() -> (Volume, Volume) {
    let turned = DMat3::from_rotation_z(0.5) * 0.9;
    (
        blobs(
            centered([20; 3], DMat3::IDENTITY),
            &[DVec3::new(-3.0, 0.0, 1.0)],
            5.0,
        ),
        blobs(
            centered([18, 22, 20], turned),
            &[DVec3::new(3.0, 1.0, 0.0)],
            5.0,
        ),
    )
}

#[test]
fn overlapping_volumes_do_not_care_for_their_order() {
    let (a, b) = pair();
    let plan = two(&a, &b);
    let data = |volumes| Datasets {
        volumes,
        ..Datasets::default()
    };
    let mut swapped = plan.clone();
    swapped.layers.reverse();
    swapped.fields[0].volume = 1;
    swapped.fields[1].volume = 0;
    let one = draw(data(vec![a.clone(), b.clone()]), &plan);
    assert!(one.stats.counts.unwrap().samples_visible > 1000);
    let off = distance(&one, &draw(data(vec![b.clone(), a.clone()]), &swapped));
    assert!(off < 1e-6, "{off}");
    // And without skipping, with threads, from behind.
    let plainly = Options {
        threads: 1,
        skip: false,
        ..Options::default()
    };
    let all = draw_with(data(vec![a.clone(), b.clone()]), &plan, &plainly);
    assert_eq!(one.image.pixels(), all.image.pixels());
    let mut backwards = plan;
    change_all(&mut backwards, |technique| {
        technique.composite = Composite::BackToFront
    });
    let off = distance(&one, &draw(data(vec![a.clone(), b.clone()]), &backwards));
    assert!(off < 1e-5, "{off}");
}

#[test]
fn an_invisible_volume_changes_nothing_and_a_volume_twice_is_twice_as_dense() {
    let (a, b) = pair();
    let mut plan = two(&a, &b);
    let data = Datasets {
        volumes: vec![a.clone(), b.clone()],
        ..Datasets::default()
    };
    // The lattice begins where the first object does: an own one inside the other moves nothing.
    plan.fields[1].grid = plan.field().grid;
    plan.fields[1].volume = 0;
    plan.techniques[1].table = white(0.0, 1.0);
    let mut alone = plan.clone();
    alone.layers.pop();
    let single = draw(data.clone(), &alone);
    assert!(distance(&draw(data.clone(), &plan), &single) < 1e-6);
    // Two of opacity a are one of 1 − (1 − a)².
    plan.technique_mut().table = white(0.2, 1.0);
    plan.techniques[1].table = white(0.2, 1.0);
    alone.technique_mut().table = white(1.0 - 0.8 * 0.8, 1.0);
    let off = distance(&draw(data.clone(), &plan), &draw(data, &alone));
    assert!(off < 1e-5, "{off}");
}

#[test]
fn a_moved_volume_looks_as_from_a_moved_camera() {
    let (a, _) = pair();
    let camera = parallel(DVec3::new(0.2, 1.0, -0.3), 60.0, 14.0);
    let unmoved = plan(&a, camera, ramp());
    let turn =
        DAffine3::from_mat3_translation(DMat3::from_rotation_x(0.7), DVec3::new(5.0, -9.0, 2.0));
    let mut moved = unmoved.clone();
    let grid = moved.field().grid;
    moved.field_mut().grid = Grid::new(grid.dims(), turn * grid.world_from_voxel()).unwrap();
    moved.field_mut().is_moved = true;
    moved.camera.eye_mm = turn.transform_point3(camera.eye_mm);
    for axis in [
        &mut moved.camera.right,
        &mut moved.camera.up,
        &mut moved.camera.forward,
    ] {
        *axis = turn.transform_vector3(*axis);
    }
    let off = distance(&draw(&a, &unmoved), &draw(&a, &moved));
    assert!(off < 1e-4, "{off}");
    // Without a word that it is moved it is another volume's Plan.
    moved.field_mut().is_moved = false;
    let refused = Renderer::new(&a).render(&moved, &Options::default(), &Control::NONE);
    assert!(matches!(
        refused,
        Err(strahl_cpu::Error::OtherData(OtherData::Grid { .. }))
    ));
}

/// A square across the view at `y_mm`, larger than the picture.
pub fn wall(y_mm: f32) -> Mesh {
    let corners = [[-50.0, -50.0], [50.0, -50.0], [50.0, 50.0], [-50.0, 50.0]];
    let corners = corners.map(|[x, z]| [x, y_mm, z]).to_vec();
    Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]], None).unwrap()
}

#[test]
fn a_mesh_hides_what_is_behind_it_and_no_more() {
    let grid = centered([20; 3], DMat3::IDENTITY);
    let fog = volume(grid, |_| 0.5);
    let opacity = 0.1;
    for y_mm in [-30.0, -9.99, -4.3, 0.0, 7.7, 12.0] {
        let mesh = wall(y_mm);
        let data = Datasets {
            volumes: vec![fog.clone()],
            masks: vec![],
            meshes: vec![mesh.clone()],
            ..Datasets::default()
        };
        let mut plan = plan(&fog, parallel(DVec3::Y, 60.0, 8.0), white(opacity, 1.0));
        plan.lattice.step_mm = 0.01;
        plan.with_depth = true;
        plan.meshes = vec![PlanMesh {
            mesh: 0,
            world_from_mesh: DAffine3::IDENTITY,
            color: [0.0; 3],
        }];
        let drawn = draw(data, &plan);
        // White fog before a black wall: its brightness is its opacity.
        let length_mm = (f64::from(y_mm) + 10.0).clamp(0.0, 20.0);
        let expected = 1.0 - (1.0 - opacity).powf(length_mm);
        for pixel in drawn.image.pixels() {
            assert!(
                (f64::from(pixel[0]) - expected).abs() < 1e-3,
                "{y_mm}: {pixel:?}"
            );
            assert!((pixel[3] - 1.0).abs() < 1e-6);
        }
        for depth_mm in drawn.depth_mm.unwrap() {
            assert!((depth_mm - 60.0 - y_mm).abs() < 1e-3, "{depth_mm}");
        }
    }
}

#[test]
fn the_depth_of_a_hit_is_that_of_the_sphere() {
    let grid = centered([40; 3], DMat3::IDENTITY);
    let ball = volume(grid, |p| 20.0 - p.length());
    let mut plan = plan(&ball, parallel(DVec3::Y, 60.0, 6.0), grey(0.0, 1.0));
    plan.technique_mut().composite = Composite::FirstHit { threshold: 8.0 };
    plan.with_depth = true;
    let depth_mm = draw(&ball, &plan).depth_mm.unwrap();
    for y in 0..plan.height {
        for x in 0..plan.width {
            let ray = plan.camera.ray(x, y, plan.width, plan.height);
            let across = ray.origin_mm - DVec3::Y * ray.origin_mm.y;
            let expected = 60.0 - (144.0 - across.length_squared()).sqrt();
            let found = f64::from(depth_mm[(y * plan.width + x) as usize]);
            assert!(
                (found - expected).abs() < 0.05,
                "{found} instead of {expected}"
            );
        }
    }
}

#[test]
fn a_mask_of_a_half_space_cuts_as_a_box() {
    let grid = centered([20; 3], DMat3::IDENTITY);
    let fog = volume(grid, |_| 0.5);
    // Between x = −0.5 and 0.5 mm the mask rises from 0 to 1: half at 0.
    let mask = of_samples(
        grid,
        Samples::U8((0..8000).map(|i| u8::from(i % 20 >= 10)).collect()),
    );
    let data = Datasets {
        volumes: vec![fog.clone()],
        masks: vec![mask.clone()],
        meshes: vec![],
        ..Datasets::default()
    };
    for keep_inside in [true, false] {
        let mut masked = plan(
            &fog,
            parallel(DVec3::new(0.6, 1.0, 0.2), 60.0, 12.0),
            white(0.1, 1.0),
        );
        (masked.width, masked.height) = (40, 30);
        let unit_from_world = DAffine3::from_scale(DVec3::splat(1.0 / 20.0));
        masked.sample_clips = vec![SampleClip {
            shape: ClipShape::Mask {
                mask: 0,
                threshold: 0.5,
            },
            unit_from_world,
            keep_inside,
            layers: ALL_LAYERS,
        }];
        let mut boxed = masked.clone();
        let half = DAffine3::from_translation(DVec3::new(-0.5, 0.0, 0.0))
            * DAffine3::from_scale(DVec3::new(1.0 / 10.0, 1.0 / 22.0, 1.0 / 22.0));
        boxed.sample_clips = vec![cut_box(half, keep_inside)];
        let (masked, boxed) = (draw(data.clone(), &masked), draw(&fog, &boxed));
        assert!(masked.stats.counts.unwrap().samples_visible > 10_000);
        // A sample on the border itself may fall to either side.
        let off = distance(&masked, &boxed);
        assert!(off < 0.06, "{off}");
        let share = masked.stats.counts.unwrap().samples_visible as f64
            / boxed.stats.counts.unwrap().samples_visible as f64;
        assert!((share - 1.0).abs() < 0.002, "{share}");
    }
}

#[test]
fn clips_cut_the_objects_that_they_name() {
    let (a, b) = pair();
    let mut plan = two(&a, &b);
    let data = Datasets {
        volumes: vec![a.clone(), b.clone()],
        ..Datasets::default()
    };
    let mut alone = plan.clone();
    alone.layers.pop();
    // Nothing is left of the second: as if it were not there (on the same lattice).
    plan.fields[1].grid = plan.field().grid;
    plan.fields[1].volume = 0;
    let nothing = DAffine3::from_scale(DVec3::splat(1e-6));
    for clip in [
        SampleClip {
            layers: 0b10,
            ..cut_box(nothing, false)
        },
        SampleClip {
            layers: 0b10,
            shape: ClipShape::Ellipsoid,
            ..cut_box(nothing, false)
        },
        SampleClip {
            layers: 0b10,
            shape: ClipShape::Cylinder,
            ..cut_box(nothing, false)
        },
    ] {
        plan.sample_clips = vec![clip];
        let off = distance(&draw(data.clone(), &plan), &draw(data.clone(), &alone));
        assert!(off < 1e-6, "{clip:?}: {off}");
    }
    plan.sample_clips.clear();
    plan.ray_clips = vec![ClipPlane {
        layers: 0b10,
        ..plane(DVec3::X, -1000.0)
    }];
    assert!(distance(&draw(data.clone(), &plan), &draw(data.clone(), &alone)) < 1e-6);
    plan.ray_clips.clear();
    // Half of the second is left: on one side of the picture both are seen, on the other the first alone.
    let both = draw(data.clone(), &plan);
    assert!(distance(&both, &draw(data.clone(), &alone)) > 0.1);
    let right = plan.camera.right;
    let half = DAffine3::from_scale_rotation_translation(
        DVec3::splat(200.0),
        DQuat::from_mat3(&DMat3::from_cols(
            right,
            plan.camera.up,
            right.cross(plan.camera.up),
        )),
        -100.0 * right,
    );
    plan.sample_clips = vec![SampleClip {
        layers: 0b10,
        ..cut_box(half.inverse(), true)
    }];
    let cut = draw(data.clone(), &plan);
    let alone = draw(data, &alone);
    let (mut left_differs, mut right_differs) = (0.0f32, 0.0f32);
    for y in 0..plan.height {
        for x in 0..plan.width {
            let [cut, both, alone] = [&cut, &both, &alone].map(|drawn| drawn.image.pixel(x, y));
            let off = |a: [f32; 4]| (0..4).map(|c| (a[c] - cut[c]).abs()).fold(0.0, f32::max);
            if x < plan.width / 2 {
                assert!(off(both) < 1e-6, "({x}, {y})");
                left_differs = left_differs.max(off(alone));
            } else if x > plan.width / 2 {
                assert!(off(alone) < 1e-6, "({x}, {y})");
                right_differs = right_differs.max(off(both));
            }
        }
    }
    assert!(left_differs > 0.1 && right_differs > 0.1);
}

#[test]
fn frames_converge_to_the_picture_of_a_fine_step() {
    let (a, _) = pair();
    // A step in the table shows as rings.
    let entries = (0..64).map(|i| [1.0, 1.0, 1.0, if i < 32 { 0.0 } else { 0.1 }]);
    let step = TransferTable::new([0.0, 1.0], 1.0, entries.collect());
    let mut plan = plan(&a, parallel(DVec3::new(0.2, 1.0, -0.3), 60.0, 14.0), step);
    plan.lattice.step_mm = 0.02;
    let fine = draw(&a, &plan);
    plan.lattice.step_mm = 1.3;
    for jitter in [
        Jitter::Hash(3),
        Jitter::SineHash,
        Jitter::WhiteTile(3),
        Jitter::BlueTile(3),
    ] {
        plan.lattice.jitter = jitter;
        plan.lattice.frames = 1;
        let one = distance(&fine, &draw(&a, &plan));
        plan.lattice.frames = 64;
        let many = distance(&fine, &draw(&a, &plan));
        assert!(one > 0.004 && many < one / 3.0, "{jitter:?}: {one}, {many}");
    }
}

#[test]
fn compositing_in_display_space_is_the_over_of_encoded_numbers() {
    let grid = centered([4; 3], DMat3::IDENTITY);
    let fog = volume(grid, |_| 0.5);
    let mut plan = plan(&fog, parallel(DVec3::Y, 60.0, 0.5), white(0.5, 1.0));
    plan.lattice.step_mm = 1.0;
    one_sample_at(&mut plan, 0.0);
    plan.background = [0.0, 0.0, 0.0, 1.0];
    plan.compositing = Compositing::Display;
    let grey = draw(&fog, &plan).image.pixel(4, 3)[0];
    // Half white over black is 0.5 of the screen, which is 0.214 of the light.
    assert!((grey - 0.214_041).abs() < 1e-4, "{grey}");
}

#[test]
fn an_interpolating_spline_goes_through_the_voxels() {
    let mut random = Random::new(17);
    let grid = centered([9, 8, 7], DMat3::IDENTITY);
    let samples = (0..grid.voxel_count()).map(|_| random.unit() as f32);
    let noise = of_samples(grid, Samples::F32(samples.collect()));
    let mut plan = plan(&noise, parallel(DVec3::Y, 60.0, 0.5), grey(-1.0, 2.0));
    (plan.width, plan.height) = (1, 1);
    plan.lattice.step_mm = 1.0;
    plan.technique_mut().composite = Composite::Mip;
    for reconstruct in [Reconstruct::BSplineInterpolating, Reconstruct::CatmullRom] {
        plan.field_mut().reconstruct = reconstruct;
        for voxel in [[0usize, 0, 0], [4, 3, 3], [8, 7, 6], [2, 5, 1]] {
            let place = DVec3::from_array(voxel.map(|n| n as f64));
            let center = grid.world_from_voxel().transform_point3(place);
            plan.camera.eye_mm = center - DVec3::Y * 60.0;
            one_sample_at(&mut plan, 0.0);
            plan.ray_clips = vec![
                plane(DVec3::Y, 0.5 - center.y),
                plane(-DVec3::Y, 0.5 + center.y),
            ];
            let found = value_shown(draw(&noise, &plan).image.pixel(0, 0), -1.0, 2.0);
            let [x, y, z] = voxel;
            let stored = noise.value(x, y, z);
            assert!(
                (found - stored).abs() < 2e-5,
                "{reconstruct:?} {voxel:?}: {found} for {stored}"
            );
        }
    }
}

/// Any function of a slot that is a choice of its own, with random values.
pub fn any_of(
    slot: &str,
    random: &mut Random,
    [low, high]: [f32; 2],
    steep_per_mm: f32,
) -> (&'static str, HashMap<&'static str, f64>) {
    let choices: Vec<_> = Function::of_slot(slot)
        .filter(|function| function.is_way_of.is_none())
        .collect();
    let function = random.pick(&choices);
    let values = [low, high].map(f64::from);
    let drawn = random_values(function, random, values, f64::from(steep_per_mm));
    (function.name, drawn)
}

/// A random Plan with any variant of every step.
pub fn any_variant(random: &mut Random, volume: &Volume) -> Plan {
    let mut plan = random.plan(volume, [13, 11]);
    let [low, high] = volume.statistics().range.map(|v| v as f32);
    let high = if high > low { high } else { low + 1.0 };
    let steep = (high - low) / volume.grid().min_spacing_mm() as f32;
    let mut any = |slot: &str| any_of(slot, random, [low, high], steep);
    let (name, values) = any("classify");
    plan.technique_mut().classify = Classify::of(name, |p| values[p]).unwrap();
    let (name, values) = any("composite");
    // Where a gradient is small, rounding turns the normal.
    if name != "normal" {
        plan.technique_mut().composite = Composite::of(name, |p| values[p]).unwrap();
    }
    let (name, values) = any("reconstruct");
    plan.field_mut().reconstruct = Reconstruct::of(name, |p| values[p]).unwrap();
    let (name, values) = any("fetch");
    let (model, of_model) = any("illuminate");
    let (shade, of_shade) = any("shade");
    let keep_last_normal = random.once_in(2);
    plan.field_mut().gradient = random.pick(&estimates());
    if random.once_in(2) {
        plan.field_mut().fetch = Fetch::of(name, |p| values[p]).unwrap();
    }
    // An opacity that follows the gradient has no gradient: `resolve` refuses it.
    if !matches!(
        plan.technique().classify,
        Classify::GradientTable { .. } | Classify::ValueGradient { .. }
    ) {
        plan.technique_mut().gradient_input =
            random.pick(&[GradientInput::Value, GradientInput::Opacity]);
    }
    plan.technique_mut().shade = random.pick(&[
        plan.technique().shade,
        blinn_phong(0.2, 0.5, 0.3, 20.0),
        Shade::Lit {
            ambient: 0.1,
            illuminate: Illuminate::of(model, |p| of_model[p]).unwrap(),
            keep_last_normal,
        },
        Shade::of(shade, |p| of_shade[p]).unwrap_or(Shade::GradientOpacity { full_per_mm: steep }),
    ]);
    if random.once_in(2) {
        plan.technique_mut().illustrate = any_illustration(random, steep);
    }
    // What belongs to no place of the ray has no surface: `resolve` refuses to light it.
    if !plan.technique().composite.function().has_place {
        plan.technique_mut().shade = Shade::Unlit;
        plan.technique_mut().illustrate = Illustrate::Plain;
    }
    if random.once_in(4) {
        let (lo, hi) = volume.grid().bounds_mm();
        let axes = DMat3::from_diagonal((hi - lo) * 0.7);
        plan.sample_clips.push(SampleClip {
            shape: random.pick(&[ClipShape::Ellipsoid, ClipShape::Cylinder]),
            ..cut_box(
                DAffine3::from_mat3_translation(axes, volume.grid().center_mm()).inverse(),
                random.once_in(2),
            )
        });
    }
    if by_both(&plan) {
        plan.technique_mut().table = table_over([low, high]);
        plan.technique_mut().classify = crate::value_gradient::classify(0.5 * steep);
    }
    plan
}

/// Whether values are classified together with their gradients, by a table of its own kind.
fn by_both(plan: &Plan) -> bool {
    matches!(plan.technique().classify, Classify::ValueGradient { .. })
}

#[test]
fn skipping_changes_no_byte_of_any_variant() {
    // The scenes in which something was skipped and something is seen, by the functions that draw them.
    let mut skipping: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    let has_bricks = |f: &&Function| f.skips != Skips::Nothing && f.name != "normal";
    let skipped_by: Vec<_> = Function::of_slot("composite").filter(has_bricks).collect();
    let models: Vec<_> = Function::of_slot("illuminate").collect();
    for seed in seeds(200) {
        let mut random = Random::new(seed ^ 0x7A21);
        // Noise of every type, which seldom has empty bricks, and blobs, which do.
        let is_blob = seed % 2 == 0;
        let volume = if is_blob {
            blobs(
                centered([48; 3], DMat3::IDENTITY),
                &[random.direction() * 5.0],
                4.0,
            )
        } else {
            random.volume()
        };
        let range = volume.statistics().range;
        if range.iter().any(|end| end.abs() > 1e15) {
            continue;
        }
        let mut plan = any_variant(&mut random, &volume);
        if is_blob {
            plan.field_mut().fetch = Fetch::Stored;
            let turn = seed as usize / 2;
            set_composite(&mut plan, &mut random, skipped_by[turn % skipped_by.len()]);
            set_model(&mut plan, &mut random, models[turn % models.len()]);
            if !by_both(&plan) {
                plan.technique_mut().table = ramp();
            }
        }
        let renderer = Renderer::new(&volume);
        let bits = |threads, tile, skip| {
            let options = Options {
                threads,
                tile,
                skip,
                ..Options::default()
            };
            let drawn = match renderer.render(&plan, &options, &Control::NONE) {
                Ok(drawn) => drawn,
                // Coefficients of what is not finite.
                Err(strahl_cpu::Error::Coefficients(_)) => return None,
                Err(error) => panic!("seed {seed}: {error}"),
            };
            let pixels = drawn.image.pixels().iter();
            let bits: Vec<_> = pixels.map(|p| p.map(f32::to_bits)).collect();
            Some((bits, drawn.stats.counts.unwrap().points_skipped))
        };
        let Some((plain, _)) = bits(1, 1 << 16, false) else {
            continue;
        };
        let (skipped, points) = bits(1 + seed as usize % 3, 7, true).unwrap();
        assert!(plain == skipped, "seed {seed}: {plan:#?}");
        let is_seen = plain.iter().any(|pixel| *pixel != plain[0]);
        for function in functions_of(&plan) {
            let scenes = skipping.entry((function.slot, function.name)).or_default();
            *scenes += usize::from(points > 0 && is_seen);
        }
    }
    let chosen = [
        "classify",
        "composite",
        "reconstruct",
        "gradient",
        "illuminate",
    ];
    let functions = FUNCTIONS.iter().filter(|function| {
        let has_bricks = function.slot != "composite" || function.skips != Skips::Nothing;
        // The CPU goes through every brick from the far end; small values have bricks in `same_bytes.rs`; where a
        // gradient is small, rounding turns the normal that `normal` shows.
        let is_left_out = ["back_to_front", "minip", "normal"].contains(&function.name);
        chosen.contains(&function.slot)
            && function.is_way_of.is_none()
            && has_bricks
            && !is_left_out
    });
    let never: Vec<_> = functions
        .map(|function| (function.slot, function.name))
        .filter(|name| skipping.get(name).copied().unwrap_or(0) == 0)
        .collect();
    assert!(never.is_empty(), "nothing was skipped with {never:?}");
}

/// Draws by another composite, with random values.
fn set_composite(plan: &mut Plan, random: &mut Random, function: &Function) {
    let values = random_values(function, random, [0.0, 1.0], 0.2);
    plan.technique_mut().composite = Composite::of(function.name, |p| values[p]).unwrap();
    if !function.has_place {
        plan.technique_mut().shade = Shade::Unlit;
    }
}

/// Lights what is lit by another model, with random values.
fn set_model(plan: &mut Plan, random: &mut Random, function: &Function) {
    if let Shade::Lit { illuminate, .. } = &mut plan.technique_mut().shade {
        let values = random_values(function, random, [0.0, 1.0], 0.2);
        *illuminate = Illuminate::of(function.name, |p| values[p]).unwrap();
    }
}

/// The functions that variants choose among.
fn functions_of(plan: &Plan) -> Vec<&'static Function> {
    let technique = plan.technique();
    let mut functions = vec![
        technique.composite.function(),
        technique.classify.function(),
        plan.field().reconstruct.function(),
        plan.field().gradient.function(),
    ];
    if let Shade::Lit { illuminate, .. } = technique.shade {
        functions.push(illuminate.function());
    }
    functions
}
