//! Segments of label volumes, each drawn by a technique of its own.

use crate::graph::{on_gpu, twice_rendered};
use crate::random::{Random, seeds};
use crate::simple::{blinn_phong, centered, cut_box, of_samples, parallel, plan, white};
use crate::techniques::{any_technique, light, linked};
use crate::variants::{any_variant, blobs, distance, draw, ramp};
use glam::{DAffine3, DMat3, DVec3};
use std::collections::BTreeMap;
use std::sync::Arc;
use strahl_conformance::agreement::agreement;
use strahl_conformance::device;
use strahl_evaluate::Evaluator;
use strahl_graph::standard;
use strahl_scene::Rendered;
use strahl_scene::plan::*;
use strahl_scene::transfer::TransferTable;
use strahl_shader::Linker;
use strahl_volume::{Control, Datasets, Grid, LabelVolume, Metadata, Rescale, Samples, Volume};

/// A label volume with the id of each voxel by its place in the world.
pub fn labels(grid: Grid, id: impl Fn(DVec3) -> u32) -> LabelVolume {
    let [nx, ny, nz] = grid.dims();
    let place = |i: usize| [i % nx, i / nx % ny, i / nx / ny].map(|n| n as f64);
    let place = |i| grid.world_from_voxel().transform_point3(place(i).into());
    let ids = (0..nx * ny * nz).map(|i| id(place(i))).collect();
    let ids = Samples::U32(ids);
    let volume = Volume::new(grid, ids, Rescale::IDENTITY, Metadata::default()).unwrap();
    LabelVolume::from_volume(volume, Vec::new()).unwrap()
}

/// Draws segments by these techniques, all others by the first.
fn segmented(plan: &mut Plan, labels: &LabelVolume, techniques: &[(u32, Option<usize>)]) {
    let look = |(id, technique): &(u32, Option<usize>)| {
        let technique = *technique;
        let look = SegmentLook::HIDDEN;
        (*id, SegmentLook { technique, ..look })
    };
    plan.layers[0].segments = Segments::Labeled(Box::new(Labeled {
        labels: 0,
        grid: *labels.grid(),
        is_moved: false,
        looks: techniques.iter().map(look).collect(),
        others: SegmentLook::of(0),
        groups: Vec::new(),
    }));
}

pub fn data(volume: &Volume, labels: &LabelVolume) -> Datasets {
    Datasets {
        labels: vec![labels.clone()],
        ..volume.into()
    }
}

fn ball() -> Volume {
    blobs(
        centered(
            [24, 22, 20],
            DMat3::from_diagonal(DVec3::new(1.0, 0.8, 1.2)),
        ),
        &[DVec3::new(-2.0, 1.0, 0.0), DVec3::new(4.0, -1.0, 2.0)],
        6.0,
    )
}

/// The ball seen askew, without an early end.
fn view(volume: &Volume) -> Plan {
    let camera = parallel(DVec3::new(0.3, 1.0, -0.4), 60.0, 12.0);
    let mut plan = plan(volume, camera, ramp());
    (plan.width, plan.height) = (31, 27);
    plan.lights = light();
    plan
}

#[test]
fn one_segment_is_the_picture_without_labels() {
    let mut rules = BTreeMap::new();
    for seed in seeds(60) {
        let mut random = Random::new(seed ^ 0x1AB5);
        let volume = random.volume();
        let range = volume.statistics().range;
        if range.iter().any(|end| end.abs() > 1e15) {
            continue;
        }
        let plain = any_variant(&mut random, &volume);
        let rule = plain.technique().composite;
        if !rule.is_local() {
            continue;
        }
        let mut plan = plain.clone();
        plan.global_rule = GlobalRule::EmissionAbsorption {
            stop_at_transmittance: 0.0,
        };
        let one = labels(*volume.grid(), |_| 7);
        segmented(&mut plan, &one, &[]);
        let renderer = strahl_cpu::Renderer::new(data(&volume, &one));
        let drawn = |plan| renderer.render(plan, &Default::default(), &Control::NONE);
        let (Ok(plain), Ok(of_segments)) = (drawn(&plain), drawn(&plan)) else {
            continue; // Coefficients of what is not finite.
        };
        let same = plain.image.pixels() == of_segments.image.pixels();
        assert!(same, "seed {seed}: {rule:?} {plan:#?}");
        *rules
            .entry(format!("{rule:?}").split(' ').next().unwrap().to_owned())
            .or_insert(0) += 1;
    }
    assert!(rules.len() >= 5, "{rules:?}");
}

#[test]
fn segments_by_one_technique_add_up_to_the_picture_without_labels() {
    let volume = ball();
    let plain = view(&volume);
    let cells = labels(*volume.grid(), |place| {
        let cell = (place / 3.0).floor().as_ivec3();
        (cell.x & 1) as u32 + 2 * (cell.y & 1) as u32 + 4 * (cell.z & 1) as u32
    });
    let mut plan = plain.clone();
    segmented(&mut plan, &cells, &[]);
    let [plain, of_segments] = [&plain, &plan].map(|plan| draw(data(&volume, &cells), plan));
    assert!(plain.stats.counts.as_ref().unwrap().samples_visible > 1000);
    let off = distance(&plain, &of_segments);
    assert!(off < 1e-5, "{off}");
}

/// Two techniques, and ids 1 and 2 on either side of a plane halfway between voxels.
fn halves() -> (Volume, LabelVolume, Plan) {
    let volume = ball();
    let mut plan = view(&volume);
    let second = Technique {
        table: white(0.3, 2.0),
        shade: blinn_phong(0.2, 0.7, 0.2, 9.0),
        ..plan.technique().clone()
    };
    plan.techniques.push(second);
    let sides = labels(*volume.grid(), |place| if place.x < 1.0 { 1 } else { 2 });
    segmented(&mut plan, &sides, &[(1, Some(0)), (2, Some(1))]);
    (volume, sides, plan)
}

/// Keeps what lies on the side of id 1, or of id 2.
fn side(keep_inside: bool) -> SampleClip {
    let half = DAffine3::from_scale_rotation_translation(
        DVec3::splat(200.0),
        glam::DQuat::IDENTITY,
        DVec3::new(-99.0, 0.0, 0.0),
    );
    cut_box(half.inverse(), keep_inside)
}

#[test]
fn segments_are_layers_that_are_clipped_apart() {
    let (volume, sides, plan) = halves();
    let mut layers = plan.clone();
    layers.layers = vec![
        Layer {
            field: 0,
            segments: Segments::Whole { technique: 0 },
        },
        Layer {
            field: 0,
            segments: Segments::Whole { technique: 1 },
        },
    ];
    layers.sample_clips = vec![
        SampleClip {
            layers: 0b01,
            ..side(true)
        },
        SampleClip {
            layers: 0b10,
            ..side(false)
        },
    ];
    let [of_layers, of_segments] = [&layers, &plan].map(|plan| draw(data(&volume, &sides), plan));
    assert!(of_layers.stats.counts.as_ref().unwrap().samples_visible > 1000);
    let off = distance(&of_layers, &of_segments);
    assert!(off < 1e-5, "{off}");
}

#[test]
fn a_hidden_segment_is_a_clip() {
    let (volume, sides, mut plan) = halves();
    let mut clipped = plan.clone();
    clipped.layers[0].segments = Segments::Whole { technique: 0 };
    clipped.sample_clips = vec![side(true)];
    segmented(&mut plan, &sides, &[(1, Some(0)), (2, None)]);
    let [clipped, hidden] = [&clipped, &plan].map(|plan| draw(data(&volume, &sides), plan));
    assert!(clipped.stats.counts.as_ref().unwrap().samples_visible > 1000);
    assert!(clipped.image.pixels() == hidden.image.pixels());
}

/// A ball of one id in another one, on voxels that are large beside those of the volume: what is clipped by its mask lies
/// inside where the interpolated mask is a half.
#[test]
fn borders_lie_where_interpolated_membership_is_one_half() {
    let volume = ball();
    let grid = centered([9, 8, 10], DMat3::from_diagonal(DVec3::new(3.0, 2.5, 2.7)));
    let balls = labels(grid, |place| 1 + u32::from(place.length() > 6.0));
    let mut plan = view(&volume);
    let mut clipped = plan.clone();
    let dims = DVec3::from_array(grid.dims().map(|n| n as f64));
    let voxel_from_unit =
        DAffine3::from_translation(0.5 * (dims - 1.0)) * DAffine3::from_scale(dims);
    clipped.sample_clips = vec![SampleClip {
        shape: ClipShape::Mask {
            mask: 0,
            threshold: 0.5,
        },
        unit_from_world: (grid.world_from_voxel() * voxel_from_unit).inverse(),
        keep_inside: true,
        layers: ALL_LAYERS,
    }];
    segmented(&mut plan, &balls, &[(2, None)]);
    let data = Datasets {
        masks: vec![balls.mask(&[1]).unwrap()],
        ..data(&volume, &balls)
    };
    let [clipped, hidden] = [&clipped, &plan].map(|plan| draw(data.clone(), plan));
    let pixels = clipped.image.pixels().iter().zip(hidden.image.pixels());
    let differ = |(a, b): &(&[f32; 4], &[f32; 4])| (0..4).any(|i| (a[i] - b[i]).abs() > 1e-4);
    let differing = pixels.filter(differ).count();
    // A lattice point within rounding of the border is on either side.
    assert!(differing <= 2, "{differing} pixels");
    assert!(hidden.stats.counts.as_ref().unwrap().samples_visible > 500);
}

/// Normals of a segment are those of its border, whatever the values are: a ball of one value is lit as a ball.
#[test]
fn gradients_of_a_segment_are_those_of_its_border() {
    let grid = centered([24; 3], DMat3::IDENTITY);
    let volume = of_samples(grid, Samples::U8(vec![5; 24 * 24 * 24]));
    let of_ball = labels(grid, |place| u32::from(place.length() < 9.0));
    let camera = parallel(DVec3::Y, 60.0, 12.0);
    let mut plan = plan(&volume, camera, white(1.0, 1.0));
    (plan.width, plan.height) = (24, 24);
    plan.lattice.step_mm = 0.25;
    let technique = plan.technique_mut();
    technique.composite = Composite::Debug(DebugView::Normal);
    technique.gradient_input = GradientInput::Segment;
    // Without segments everything is one, and nothing has a normal.
    let flat = draw(Datasets::from(&volume), &plan);
    plan.technique_mut().composite = Composite::EmissionAbsorption {
        stop_at_transmittance: 0.0,
    };
    plan.technique_mut().shade = lambert_of_the_eye();
    plan.lights = vec![PlanLight::Head { radiance: [1.0; 3] }];
    segmented(&mut plan, &of_ball, &[(0, None)]);
    let lit = draw(data(&volume, &of_ball), &plan);
    let mut compared = 0;
    for (i, pixel) in lit.image.pixels().iter().enumerate() {
        let (x, y) = (i % 24, i / 24);
        let [x, y] = [x, y].map(|n| n as f64 - 11.5);
        let radius = x.hypot(y);
        if radius > 7.5 {
            continue;
        }
        // The cosine of a ball's normal to the eye.
        let expected = (1.0 - (radius / 9.0).powi(2)).sqrt();
        let off = (f64::from(pixel[0]) - expected).abs();
        assert!(off < 0.2, "{x} {y}: {} instead of {expected}", pixel[0]);
        compared += 1;
    }
    assert!(compared > 100);
    assert!(flat.image.pixels().iter().all(|pixel| pixel[0] == pixel[1]));
}

/// Matt, without ambient light: the cosine to the light.
fn lambert_of_the_eye() -> Shade {
    Shade::Lit {
        ambient: 0.0,
        illuminate: Illuminate::Lambert { diffuse: 1.0 },
        keep_last_normal: false,
    }
}

#[test]
fn what_is_hidden_is_skipped_without_changing_a_byte() {
    let mut skipped = 0;
    for seed in seeds(48) {
        let mut random = Random::new(seed ^ 0x51D5);
        let (volume, labels, mut plan) = any_segments(&mut random);
        if let Segments::Labeled(labeled) = &mut plan.layers[0].segments {
            labeled
                .looks
                .insert(random.pick(&[0, 300, 900]), SegmentLook::HIDDEN);
        }
        let renderer = strahl_cpu::Renderer::new(data(&volume, &labels));
        let drawn = [true, false].map(|skip| {
            let options = strahl_cpu::Options {
                skip,
                ..strahl_cpu::Options::default()
            };
            renderer.render(&plan, &options, &Control::NONE).unwrap()
        });
        assert!(
            drawn[0].image.pixels() == drawn[1].image.pixels(),
            "seed {seed}: {plan:#?}"
        );
        skipped += drawn[0].stats.counts.as_ref().unwrap().points_skipped;
        assert_eq!(drawn[1].stats.counts.as_ref().unwrap().points_skipped, 0);
    }
    assert!(skipped > 1000, "{skipped}");
}

/// Nothing is hidden here; a technique shows the ball only, in segments that are large beside bricks.
#[test]
fn what_techniques_do_not_show_is_skipped_without_changing_a_byte() {
    let grid = centered([40; 3], DMat3::IDENTITY);
    let volume = blobs(
        grid,
        &[DVec3::new(-9.0, 3.0, 0.0), DVec3::new(8.0, -4.0, 5.0)],
        5.0,
    );
    let mut plan = view(&volume);
    let second = Technique {
        table: white(0.3, 2.0),
        ..plan.technique().clone()
    };
    plan.techniques.push(second);
    let sides = labels(grid, |place| 1 + u32::from(place.x + 0.3 * place.y > 2.0));
    for (second, opacity, clips) in [
        (0, 1.0, 0),
        (1, 1.0, 0),
        (1, 0.6, 0),
        // Clips are left to the loop of any rules.
        (1, 0.6, 1),
    ] {
        segmented(&mut plan, &sides, &[(1, Some(0)), (2, Some(second))]);
        look_of(&mut plan, 1).opacity = opacity;
        plan.sample_clips = vec![everything(); clips];
        let [skipped, whole] = skipped_and_whole(&volume, &sides, &plan);
        assert!(
            skipped.image.pixels() == whole.image.pixels(),
            "{second} {opacity} {clips}"
        );
        let counts = skipped.stats.counts.unwrap();
        let share = counts.points_skipped as f64 / counts.lattice_points as f64;
        assert!(share > 0.1, "{share}");
        assert!(counts.samples_visible > 1000);
    }
}

/// The picture without what shows nothing, and with all lattice points.
fn skipped_and_whole(volume: &Volume, labels: &LabelVolume, plan: &Plan) -> [Rendered; 2] {
    let renderer = strahl_cpu::Renderer::new(data(volume, labels));
    [true, false].map(|skip| {
        let options = strahl_cpu::Options {
            skip,
            ..strahl_cpu::Options::default()
        };
        renderer.render(plan, &options, &Control::NONE).unwrap()
    })
}

fn look_of(plan: &mut Plan, id: u32) -> &mut SegmentLook {
    let Segments::Labeled(labeled) = &mut plan.layers[0].segments else {
        panic!("a Plan with segments")
    };
    let others = labeled.others;
    labeled.looks.entry(id).or_insert(others)
}

/// A clip that takes nothing away.
fn everything() -> SampleClip {
    cut_box(DAffine3::from_scale(DVec3::splat(1e-5)), true)
}

/// Two opaque slabs in one segment, of which 0.3 counts, far apart: the run ends in the first slab, and it does not begin
/// again in the second one.
#[test]
fn a_run_that_is_opaque_does_not_begin_again_in_its_segment() {
    let grid = centered([40; 3], DMat3::IDENTITY);
    let is_slab = |z: usize| (6..12).contains(&z) || (28..34).contains(&z);
    let samples = (0..40 * 1600).map(|i| if is_slab(i / 1600) { 200 } else { 0 });
    let volume = of_samples(grid, Samples::U8(samples.collect()));
    let one = labels(grid, |_| 1);
    let mut plan = plan(
        &volume,
        parallel(DVec3::new(0.1, 0.05, 1.0), 60.0, 8.0),
        ramp(),
    );
    plan.global_rule = GlobalRule::EmissionAbsorption {
        stop_at_transmittance: 1.0 / 256.0,
    };
    plan.technique_mut().composite = Composite::EmissionAbsorption {
        stop_at_transmittance: 1.0 / 256.0,
    };
    let entries = [vec![[0.0; 4]; 20], vec![[0.9; 4]]].concat();
    plan.technique_mut().table = TransferTable::new([0.0, 200.0], 1.0, entries);
    for clips in [0, 1] {
        plan.sample_clips = vec![everything(); clips];
        segmented(&mut plan, &one, &[]);
        look_of(&mut plan, 1).opacity = 0.3;
        let [skipped, whole] = skipped_and_whole(&volume, &one, &plan);
        let points_skipped = skipped.stats.counts.unwrap().points_skipped;
        assert!(points_skipped > 200, "{clips}: {:?}", skipped.stats.counts);
        assert!(skipped.image.pixels() == whole.image.pixels());
        let middle =
            whole.image.pixels()[(plan.width * (plan.height / 2) + plan.width / 2) as usize];
        assert!((0.298..0.3001).contains(&middle[3]), "{middle:?}");
    }
}

/// Four random entries over a range of values.
fn table_over([lo, hi]: [f64; 2], random: &mut Random) -> TransferTable {
    let entry = |random: &mut Random| [(); 4].map(|()| random.unit() as f32);
    let entries = (0..4).map(|_| entry(random)).collect();
    let [lo, hi] = [lo as f32, hi.max(lo + 1.0) as f32];
    TransferTable::new([lo, hi], 1.0, entries)
}

/// A segment has no border inside: a cut through it is lit as what has no gradient.
#[test]
fn normals_of_segments_are_not_made_by_rounding() {
    let grid = centered([24; 3], DMat3::IDENTITY);
    let volume = of_samples(grid, Samples::U8(vec![100; 24 * 576]));
    let one = labels(grid, |_| 1);
    for method in [GradientMethod::Central, GradientMethod::Sobel] {
        let mut plan = view(&volume);
        plan.fields[0].gradient = method;
        plan.technique_mut().table = white(0.9, 2.0);
        plan.technique_mut().shade = blinn_phong(0.2, 0.7, 0.2, 9.0);
        plan.technique_mut().gradient_input = GradientInput::Segment;
        segmented(&mut plan, &one, &[]);
        plan.sample_clips = vec![side(true)];
        let drawn = draw(data(&volume, &one), &plan);
        let mut evaluator = Evaluator::new(data(&volume, &one));
        let expected = evaluator.render(&plan, &Control::NONE).unwrap();
        let off = distance(&drawn, &expected);
        assert!(off < 0.02, "{method:?}: {off}");
        assert!(drawn.stats.counts.unwrap().samples_visible > 300);
    }
}

/// The loop for samples and runs that all add up by emission and absorption, and that of any rules.
#[test]
fn both_loops_through_segments_draw_one_picture() {
    let (mut seen, mut of_runs) = (0, 0);
    for seed in seeds(40) {
        let mut random = Random::new(seed ^ 0x2B0B);
        let volume = ball();
        let mut plan = view(&volume);
        plan.techniques = (0..1 + random.below(3))
            .map(|i| Technique {
                table: table_over(volume.statistics().range, &mut random),
                shade: [blinn_phong(0.2, 0.7, 0.2, 9.0), Shade::Unlit][(i + random.below(2)) % 2],
                ..plan.technique().clone()
            })
            .collect();
        let cell = 1.0 + 4.0 * random.unit();
        let cells = labels(*volume.grid(), |place| {
            let cell = (place / cell).floor().as_ivec3();
            (cell.x & 3) as u32 + 4 * (cell.y & 1) as u32 + 8 * (cell.z & 3) as u32
        });
        segmented(&mut plan, &cells, &[(3, None)]);
        let is_of_runs = random.below(2) == 0;
        for id in 4..20 {
            *look_of(&mut plan, id) = SegmentLook {
                tint: [random.unit() as f32, 0.5, 1.0],
                opacity: if is_of_runs { 0.7 } else { 1.0 },
                ..SegmentLook::of(random.below(plan.techniques.len()))
            };
        }
        let fast = draw(data(&volume, &cells), &plan);
        plan.sample_clips = vec![everything()];
        let general = draw(data(&volume, &cells), &plan);
        let off = distance(&fast, &general);
        assert!(off < 1e-5, "seed {seed}: {off}");
        seen += usize::from(fast.stats.counts.unwrap().samples_visible > 1000);
        of_runs += usize::from(is_of_runs);
    }
    assert!(seen > 20 && (5..35).contains(&of_runs), "{seen} {of_runs}");
}

#[test]
fn which_numbers_ids_are_changes_nothing() {
    let (volume, sides, mut plan) = halves();
    let first = draw(data(&volume, &sides), &plan);
    let other = |id| if id == 1 { u32::MAX } else { 40_000 };
    let renamed = labels(*sides.grid(), |place| {
        other(if place.x < 1.0 { 1 } else { 2 })
    });
    segmented(
        &mut plan,
        &renamed,
        &[(other(1), Some(0)), (other(2), Some(1))],
    );
    let second = draw(data(&volume, &renamed), &plan);
    assert!(first.image.pixels() == second.image.pixels());
}

/// A volume of one value; a run of it by a projection has the opacity of its table, however long it is.
#[test]
fn runs_are_told_apart_by_segment_and_not_by_technique() {
    let grid = centered([10; 3], DMat3::IDENTITY);
    let volume = of_samples(grid, Samples::U8(vec![5; 1000]));
    let camera = parallel(DVec3::Z, 30.0, 3.0);
    let mut plan = plan(&volume, camera, white(0.5, 1.0));
    plan.technique_mut().composite = Composite::Mip;
    for (number, id) in [
        (1, (|_| 1) as fn(DVec3) -> u32),
        (2, |place| 1 + u32::from(place.z < 0.0)),
        // The slab in the middle is hidden, and ends a run of the id on both sides.
        (2, |place| 3 * u32::from(place.z.abs() < 2.0)),
        (5, |place| (place.z + 5.0) as u32 / 2),
    ] {
        let of_id = labels(grid, id);
        segmented(
            &mut plan,
            &of_id,
            &if number == 5 { vec![] } else { vec![(3, None)] },
        );
        let drawn = draw(data(&volume, &of_id), &plan);
        let found = drawn.image.pixels()[0][3];
        let expected = 1.0 - 0.5f32.powi(number);
        assert!((found - expected).abs() < 1e-6, "{number} runs: {found}");
    }
}

const ANY_RULE: [GlobalRule; 6] = [
    GlobalRule::EmissionAbsorption {
        stop_at_transmittance: 1.0 / 256.0,
    },
    GlobalRule::EmissionAbsorption {
        stop_at_transmittance: 1.0 / 256.0,
    },
    GlobalRule::Mip,
    GlobalRule::Average,
    GlobalRule::First,
    GlobalRule::ImportanceAware,
];

/// The only pixel of slabs of these ids, two samples of opacity 0.5 each, by all renderers.
fn through_slabs(
    ids: &[u32],
    looks: &[(u32, SegmentLook)],
    groups: &[SegmentGroup],
) -> Vec<[f32; 4]> {
    let grid = centered([2, ids.len(), 2], DMat3::IDENTITY);
    let values = Samples::F32(vec![0.5; grid.voxel_count()]);
    let volume = of_samples(grid, values);
    let first = 0.5 * (ids.len() as f64 - 1.0);
    let slabs = labels(grid, |place| ids[(place.y + first).round() as usize]);
    let mut plan = plan(&volume, parallel(DVec3::Y, 40.0, 0.5), white(0.5, 0.5));
    (plan.width, plan.height) = (1, 1);
    segmented(&mut plan, &slabs, &[]);
    if let Segments::Labeled(labeled) = &mut plan.layers[0].segments {
        labeled.looks = looks.iter().copied().collect();
        labeled.groups = groups.to_vec();
    }
    let data = data(&volume, &slabs);
    let here = Evaluator::new(data.clone()).render(&plan, &Control::NONE);
    let mut pixels = vec![
        draw(data.clone(), &plan).image.pixel(0, 0),
        here.unwrap().image.pixel(0, 0),
    ];
    if let Some(device) = device() {
        let mut renderer = strahl_gpu::Renderer::new(device, data.clone());
        let drawn = renderer.render(&plan, &Control::NONE).unwrap();
        pixels.push(drawn.image.pixel(0, 0));
    }
    pixels
}

#[test]
fn groups_add_up_among_themselves_before_they_meet_the_others() {
    let plain = GlobalRule::EmissionAbsorption {
        stop_at_transmittance: 0.0,
    };
    let group = |rule, opacity| SegmentGroup {
        rule,
        opacity,
        importance: 0.0,
    };
    let look = |group: Option<usize>, tint: [f32; 3]| SegmentLook {
        group,
        tint,
        ..SegmentLook::of(0)
    };
    let (red, dark, green) = ([1.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let looks = [
        (1, look(Some(0), red)),
        (2, look(Some(0), dark)),
        (3, look(Some(1), green)),
        (4, look(None, green)),
        (5, SegmentLook::HIDDEN),
    ];
    // Each run hides 3/4.
    for (ids, rules, expected) in [
        // The brightest of two, before one of no group.
        (
            &[1, 2, 4][..],
            [GlobalRule::Mip, plain],
            [0.75, 0.25 * 0.75, 0.9375],
        ),
        (
            &[2, 1, 4],
            [GlobalRule::Mip, plain],
            [0.75, 0.25 * 0.75, 0.9375],
        ),
        (
            &[2, 1, 4],
            [GlobalRule::First, plain],
            [0.075, 0.25 * 0.75, 0.9375],
        ),
        // Their mean, then a group of one run that is half as opaque.
        (
            &[1, 2, 3],
            [GlobalRule::Average, plain],
            [0.4125, 0.25 * 0.375, 0.84375],
        ),
        // By the rule of the whole: as if there were no group.
        (
            &[2, 1, 4],
            [plain, plain],
            [0.075 + 0.25 * 0.75, 0.0625 * 0.75, 0.984375],
        ),
        // What is hidden parts a group in two samples.
        (&[1, 5, 1], [GlobalRule::Mip, plain], [0.9375, 0.0, 0.9375]),
        (
            &[1, 4, 1],
            [GlobalRule::Mip, plain],
            [0.75 + 0.0625 * 0.75, 0.1875, 0.984375],
        ),
        (
            &[1, 3, 1],
            [GlobalRule::Mip, plain],
            [0.75 + 0.15625 * 0.75, 0.09375, 0.9609375],
        ),
    ] {
        let groups = [group(rules[0], 1.0), group(rules[1], 0.5)];
        for (renderer, [r, g, b, a]) in through_slabs(ids, &looks, &groups).into_iter().enumerate()
        {
            let off = [r - expected[0], g - expected[1], b, a - expected[2]];
            let is_near = off.iter().all(|off| off.abs() < 2e-5);
            assert!(is_near, "{renderer}: {ids:?} {rules:?}: {:?}", [r, g, b, a]);
        }
    }
}

/// Two slabs in front of one another with one gradient everywhere, by the equation of the paper: what covers a sample is the
/// opacity before it in its run, or with `covered_by` 1 on its ray.
#[test]
fn context_is_kept_by_what_covers_a_sample_in_its_run_or_on_its_ray() {
    let (steepness, cut_depth, cut_sharpness, opacity) = (0.4f64, 2.0f64, 0.7f64, 0.5f64);
    let grid = centered([6, 8, 6], DMat3::IDENTITY);
    let volume = crate::simple::volume(grid, |place| 0.5 + 0.1 * place.x);
    let slabs = labels(grid, |place| 1 + u32::from(place.y < 0.0));
    let mut seen = Vec::new();
    for covered_by in [0, 1] {
        let mut plan = plan(&volume, parallel(DVec3::Y, 40.0, 0.5), white(opacity, 0.5));
        (plan.width, plan.height) = (1, 1);
        plan.technique_mut().composite = Composite::ContextPreserving {
            cut_depth: cut_depth as f32,
            cut_sharpness: cut_sharpness as f32,
            full_per_mm: (0.1 / steepness) as f32,
            nearest_mm: 0.0,
            farthest_mm: 1e9,
            stop_at_transmittance: 0.0,
            covered_by,
        };
        segmented(&mut plan, &slabs, &[]);
        let (mut before, mut samples) = (0.0, 0);
        for _ in 0..2 {
            let mut of_run = 0.0;
            for _ in 0..8 {
                let passing = (1.0 - of_run) * (1.0 - before * f64::from(covered_by));
                let kept = steepness.powf((cut_depth * passing).powf(cut_sharpness));
                of_run += (1.0 - of_run) * opacity * kept;
                samples += 1;
            }
            before += (1.0 - before) * of_run;
        }
        let data = data(&volume, &slabs);
        let cpu = draw(data.clone(), &plan);
        assert_eq!(cpu.stats.counts.as_ref().unwrap().samples, samples);
        let here = Evaluator::new(data.clone()).render(&plan, &Control::NONE);
        let mut drawn = vec![cpu.image.pixel(0, 0), here.unwrap().image.pixel(0, 0)];
        if let Some(device) = device() {
            let mut renderer = strahl_gpu::Renderer::new(device, data);
            let rendered = renderer.render(&plan, &Control::NONE).unwrap();
            drawn.push(rendered.image.pixel(0, 0));
        }
        // White: the color, premultiplied, is the opacity.
        for found in drawn.into_iter().flat_map(|pixel| [pixel[0], pixel[3]]) {
            let off = (f64::from(found) - before).abs();
            assert!(off < 2e-5, "{covered_by}: {found} instead of {before}");
        }
        seen.push(before);
    }
    // The second slab is less cut away where the first one covers it.
    assert!(seen[1] > seen[0] + 1e-3, "{seen:?}");
}

/// A Plan of segments by techniques of any kind, whose labels lie on another grid half of the time.
pub fn any_segments(random: &mut Random) -> (Volume, LabelVolume, Plan) {
    let volume = ball();
    let range = volume.statistics().range.map(|v| v as f32);
    let mut plan = view(&volume);
    let (of_opacity, covered_by) = (random.once_in(2), random.below(2) as u32);
    plan.techniques = (0..3)
        .map(|_| Technique {
            composite: random.pick(&[
                Composite::EmissionAbsorption {
                    stop_at_transmittance: 1.0 / 256.0,
                },
                Composite::EmissionAbsorption {
                    stop_at_transmittance: 0.0,
                },
                Composite::Mip,
                Composite::Minip,
                Composite::Average,
                Composite::Gmip { white_per_mm: 3.0 },
                Composite::Mida {
                    low: range[0],
                    high: range[1],
                    blend: -0.3,
                    stop_at_transmittance: 1.0 / 256.0,
                },
                Composite::FirstHit {
                    threshold: 0.4 * range[0] + 0.6 * range[1],
                },
                Composite::ContextPreserving {
                    cut_depth: 2.0,
                    cut_sharpness: 0.7,
                    full_per_mm: 2.0,
                    nearest_mm: 5.0,
                    farthest_mm: 60.0,
                    stop_at_transmittance: 1.0 / 256.0,
                    covered_by,
                },
                Composite::ImportanceAware {
                    measure: 0,
                    gain: 2.0,
                    first: 1.0,
                    second: 0.2,
                    third: 0.6,
                    full_per_mm: 2.0,
                    low: range[0],
                    high: range[1],
                },
            ]),
            ..any_technique(random, range, of_opacity)
        })
        .collect();
    for technique in &mut plan.techniques {
        if random.once_in(3) && !of_opacity {
            technique.table = crate::value_gradient::table_over(range);
            technique.classify = crate::value_gradient::classify(3.0);
        }
        // Where classified voxels are equally opaque, rounding alone would say where the normal points.
        if technique.classify == Classify::PreClassified {
            technique.gradient_input = GradientInput::Value;
        }
        // Such a projection has no surface.
        let has_none = [Composite::Minip, Composite::Average];
        if has_none.contains(&technique.composite) {
            technique.shade = Shade::Unlit;
        }
        let reads_gradient = matches!(
            technique.classify,
            Classify::GradientTable { .. } | Classify::ValueGradient { .. }
        );
        if random.once_in(4) && !of_opacity && !reads_gradient {
            technique.gradient_input = GradientInput::Segment;
        }
        if !technique.composite.function().has_place {
            technique.illustrate = Illustrate::Plain;
        }
    }
    let grid = match random.once_in(2) {
        true => *volume.grid(),
        false => centered(
            [9, 12, 10],
            random.rotation() * DMat3::from_diagonal(DVec3::splat(2.1)),
        ),
    };
    let normal = random.direction();
    let labels = labels(grid, |place| {
        let far = u32::from(place.dot(normal) > 1.0) + 2 * u32::from(place.length() > 5.0);
        far * 300
    });
    segmented(
        &mut plan,
        &labels,
        &[(0, Some(2)), (300, Some(1)), (600, None)],
    );
    if let Segments::Labeled(labeled) = &mut plan.layers[0].segments {
        let look = labeled.looks.get_mut(&300).unwrap();
        look.tint = [1.0, 0.5, 0.25];
        look.opacity = random.pick(&[1.0, 0.6]);
        look.importance = random.pick(&[0.0, 2.0]);
        labeled.others.tint = [0.2, 0.9, 0.4];
        if random.once_in(2) {
            labeled.groups = (0..2)
                .map(|_| SegmentGroup {
                    rule: random.pick(&ANY_RULE),
                    opacity: random.pick(&[1.0, 0.7]),
                    importance: random.pick(&[0.0, 1.5]),
                })
                .collect();
            let groups = [None, Some(0), Some(0), Some(1)];
            labeled.others.group = random.pick(&groups);
            for look in labeled.looks.values_mut() {
                look.group = random.pick(&groups);
            }
        }
    }
    plan.global_rule = random.pick(&ANY_RULE);
    plan.with_depth = true;
    (volume, labels, plan)
}

#[test]
fn all_renderers_draw_segments_by_their_techniques() {
    for seed in seeds(32) {
        let mut random = Random::new(seed ^ 0x5E65);
        let (volume, labels, plan) = any_segments(&mut random);
        let data = data(&volume, &labels);
        let cpu = draw(data.clone(), &plan);
        let here = Evaluator::new(data.clone()).render(&plan, &Control::NONE);
        let here = here.unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        let of_techniques = &plan.techniques;
        let what = format!("seed {seed}: {:?} {of_techniques:#?}", plan.global_rule);
        // A lattice point within rounding of the border of two segments is in either.
        let [first, second] = [&cpu, &here].map(|drawn| {
            let depth_mm = drawn.depth_mm.as_deref().unwrap();
            let pixels = drawn.image.pixels().iter().zip(depth_mm);
            pixels.map(|([r, g, b, a], mm)| [*r, *g, *b, *a, mm.min(1e6)])
        });
        let same = |a: f32, b: f32| (a - b).abs() <= 1e-3;
        let differ = |(a, b): &([f32; 5], [f32; 5])| (0..5).any(|i| !same(a[i], b[i]));
        let differing: Vec<_> = first.zip(second).filter(differ).collect();
        let (number, some) = (differing.len(), differing.iter().take(4));
        let some: Vec<_> = some.collect();
        assert!(number <= 2, "{number} pixels: {some:?} {what}");
        let Some(device) = device() else { continue };
        let mut renderer = strahl_gpu::Renderer::new(device, data.clone());
        let gpu = renderer.render(&plan, &Control::NONE).unwrap();
        let apart = agreement(&cpu.image, &gpu.image);
        assert!(apart.psnr_db >= 45.0, "on the GPU: {apart:?} {what}");
    }
}

/// Each technique as a group of nodes: the same pixels and depths, bit by bit.
#[test]
fn segments_are_their_standard_graph() {
    let mut by_looks = [0; 2];
    for (drawn, seed) in seeds(24).enumerate() {
        let mut random = Random::new(seed ^ 0x96A9);
        let (volume, labels, plan) = any_segments(&mut random);
        let data = data(&volume, &labels);
        let is_covered_by_ray = |technique: &Technique| {
            matches!(
                technique.composite,
                Composite::ContextPreserving { covered_by: 1, .. }
            )
        };
        // What covers a run is not known in a graph.
        if plan.techniques.iter().any(is_covered_by_ray) {
            assert!(standard(&plan).is_err());
            continue;
        }
        let [settings, by_graph] = twice_rendered(&data, &plan);
        let what = format!("seed {seed}: {plan:#?}");
        assert!(settings.image.pixels() == by_graph.image.pixels(), "{what}");
        assert!(settings.depth_mm == by_graph.depth_mm, "{what}");
        // Its compiler takes seconds for each.
        if drawn % 8 == 0
            && let Some(gpu) = on_gpu(data, &plan, &standard(&plan).unwrap())
        {
            let apart = agreement(&settings.image, &gpu);
            assert!(apart.psnr_db >= 45.0, "on the GPU: {apart:?} {what}");
        }
        for technique in &plan.techniques {
            by_looks[usize::from(technique.composite.function().adds_looks)] += 1;
        }
    }
    assert!(by_looks.iter().all(|number| *number > 5), "{by_looks:?}");
}

#[test]
fn the_ends_of_a_table_show_nothing_of_the_next_one() {
    let (volume, _, mut plan) = halves();
    let range = volume.statistics().range.map(|end| end as f32);
    let (near, far) = (
        0.4 * range[0] + 0.6 * range[1],
        0.3 * range[0] + 0.7 * range[1],
    );
    // Most values lie beyond the tables, which fill whole rows of a texture, so that they are side by side.
    let opaque = |color: [f32; 3]| {
        let [r, g, b] = color;
        let row = strahl_shader::TABLE_ROW as usize;
        TransferTable::new([near, far], 1.0, vec![[r, g, b, 1.0]; row])
    };
    plan.techniques[0].shade = Shade::Unlit;
    plan.techniques[0].table = opaque([1.0, 0.0, 0.0]);
    plan.techniques = vec![plan.techniques[0].clone(); 3];
    plan.techniques[1].table = opaque([0.0, 1.0, 0.0]);
    plan.techniques[2].table = opaque([0.0, 0.0, 1.0]);
    let thirds = labels(*volume.grid(), |place| match place.x {
        x if x < -2.0 => 1,
        x if x < 3.0 => 2,
        _ => 3,
    });
    segmented(
        &mut plan,
        &thirds,
        &[(1, Some(0)), (2, Some(1)), (3, Some(2))],
    );
    let data = data(&volume, &thirds);
    let mut drawn = vec![("CPU", draw(data.clone(), &plan).image)];
    let here = Evaluator::new(data.clone()).render(&plan, &Control::NONE);
    drawn.push(("evaluator", here.unwrap().image));
    if let Some(device) = device() {
        let mut renderer = strahl_gpu::Renderer::new(device, data.clone());
        drawn.push(("GPU", renderer.render(&plan, &Control::NONE).unwrap().image));
    }
    for (renderer, image) in drawn {
        let mut shown = [0; 3];
        for [r, g, b, a] in image.pixels().iter().filter(|pixel| pixel[3] > 0.0) {
            let color = [r, g, b].map(|channel| *channel > 0.0);
            let one = color.iter().filter(|is_shown| **is_shown).count() == 1;
            let is_whole = ((r + g + b) / a - 1.0).abs() < 1e-5;
            assert!(one && is_whole, "{renderer}: {:?}", [r, g, b, a]);
            for (number, is_shown) in shown.iter_mut().zip(color) {
                *number += usize::from(is_shown);
            }
        }
        assert!(
            shown.iter().all(|number| *number > 20),
            "{renderer}: {shown:?}"
        );
    }
}

#[test]
fn which_technique_a_segment_has_is_data() {
    let (_, sides, mut plan) = halves();
    plan.techniques[1].composite = Composite::Mip;
    let mut linker = Linker::new();
    let program = linked(&mut linker, &plan);
    let mut same = |what: &str, plan: &Plan| {
        assert!(Arc::ptr_eq(&program, &linked(&mut linker, plan)), "{what}");
    };
    for hidden in [1, 2] {
        let mut plan = plan.clone();
        segmented(&mut plan, &sides, &[(hidden, None), (3 - hidden, Some(1))]);
        same("a hidden segment", &plan);
    }
    segmented(&mut plan, &sides, &[(1, Some(1)), (2, Some(0))]);
    same("other techniques", &plan);
    plan.techniques[0].table = white(0.9, 1.0);
    same("another table", &plan);
    plan.techniques[1].shade = blinn_phong(0.3, 0.5, 0.1, 2.0);
    same("other numbers", &plan);
    plan.techniques.push(plan.techniques[1].clone());
    segmented(&mut plan, &sides, &[(9, Some(2))]);
    same("one more technique of the same functions", &plan);
    plan.techniques[2].composite = Composite::Minip;
    assert!(!Arc::ptr_eq(&program, &linked(&mut linker, &plan)));
}
