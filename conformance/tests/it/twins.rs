//! Every function of the library, alone: its WGSL on an adapter beside its Rust on the CPU, from
//! the same random numbers.
//!
//! Each pixel is one call: parallel rays through a volume of noise, cut to one sample each, with random
//! parameters. A composite gets some samples per ray, or it would have nothing to do.

use crate::parameters::random_values;
use crate::random::{Random, seeds};
use crate::simple::{centered, cut_box, of_samples, one_sample_at, parallel, plan, plane};
use crate::variants::wall;
use glam::{DAffine3, DMat3, DVec3};
use strahl_conformance::device;
use strahl_conformance::twins::{EXCEPTIONS, HARDWARE_WEIGHTS, alike_of};
use strahl_gpu::Renderer;
use strahl_scene::Rendered;
use strahl_scene::plan::*;
use strahl_scene::transfer::TransferTable;
use strahl_shader::registry::{FUNCTIONS, Function};
use strahl_volume::{Control, Datasets, LabelVolume, Mesh, Samples, Volume};

/// What a call is made with.
struct Case {
    volume: Volume,
    masks: Vec<Volume>,
    meshes: Vec<Mesh>,
    labels: Vec<LabelVolume>,
    plan: Plan,
}

impl Case {
    fn data(&self) -> Datasets {
        Datasets {
            volumes: vec![self.volume.clone()],
            masks: self.masks.clone(),
            meshes: self.meshes.clone(),
            labels: self.labels.clone(),
        }
    }
}

/// How often a case is drawn anew that shows next to nothing: parameters may ask for what is not there.
const MOST_DRAWN: u32 = 30;

/// A case that shows something in a fifth of its pixels, and its picture; the last one drawn if none does.
fn seen_case(function: &Function, random: &mut Random) -> (Case, Rendered) {
    let draw = |random: &mut Random| {
        let case = case(function, random);
        let rendered = strahl_cpu::Renderer::new(case.data())
            .render(&case.plan, &Default::default(), &Control::NONE)
            .unwrap();
        (case, rendered)
    };
    let mut last = draw(random);
    for _ in 1..MOST_DRAWN {
        let pixels = last.1.image.pixels();
        if pixels.iter().filter(|pixel| pixel[3] > 0.0).count() >= pixels.len() / 5 {
            break;
        }
        last = draw(random);
    }
    last
}

const DIMS: [usize; 3] = [11, 9, 10];

fn noise(random: &mut Random) -> Volume {
    let n = DIMS.iter().product::<usize>();
    let samples = Samples::U8((0..n).map(|_| random.below(256) as u8).collect());
    let axes = DMat3::from_diagonal(DVec3::new(1.0, 1.2, 0.9));
    of_samples(centered(DIMS, axes), samples)
}

/// Smooth in color and opacity.
fn soft(random: &mut Random, is_opaque: bool) -> TransferTable {
    let (a, b) = (random.unit() as f32, random.unit() as f32);
    let entries = (0..64).map(|i| {
        let v = i as f32 / 63.0;
        let opacity = if is_opaque { 1.0 } else { 0.1 + 0.5 * v };
        [v, 1.0 - v, a * v + b * (1.0 - v), opacity]
    });
    TransferTable::new([0.0, 255.0], 1.0, entries.collect())
}

fn case(function: &Function, random: &mut Random) -> Case {
    let volume = noise(random);
    let camera = parallel(random.direction(), 30.0, 3.0);
    let table = soft(random, true);
    let mut plan = plan(&volume, camera, table);
    (plan.width, plan.height) = (24, 20);
    one_sample_at(&mut plan, random.between(-1.0, 1.0));
    let mut case = Case {
        masks: Vec::new(),
        meshes: Vec::new(),
        labels: Vec::new(),
        plan,
        volume,
    };
    match function.slot {
        "clip_ray" => clip_ray(&mut case, function.name, random),
        "clip_sample" => clip_sample(&mut case, function.name, random),
        "light" | "shade" => lit(&mut case.plan, function, random),
        "jitter" => {
            let seed = random.below(1 << 32) as u32;
            case.plan.lattice.jitter = match function.name {
                "hash" => Jitter::Hash(seed),
                "sine_hash" => Jitter::SineHash,
                _ => random.pick(&[Jitter::WhiteTile(seed), Jitter::BlueTile(seed)]),
            };
        }
        "gradient_input" if function.name == "segment" => of_segments(&mut case, random),
        _ => choose(&mut case.plan, function, random),
    }
    case
}

/// Segments of a few voxels, each lit by the head light as its border lies.
fn of_segments(case: &mut Case, random: &mut Random) {
    let blocks: Vec<_> = (0..64).map(|_| random.below(3) as u8).collect();
    let [nx, ny, _] = DIMS;
    let place = |i: usize| [i % nx / 3, i / nx % ny / 3, i / (nx * ny) / 3];
    let id = |i: usize| blocks[place(i)[0] + 4 * (place(i)[1] + 4 * place(i)[2])];
    let ids = Samples::U8((0..DIMS.iter().product()).map(id).collect());
    let ids = of_samples(*case.volume.grid(), ids);
    let labels = LabelVolume::from_volume(ids, Vec::new()).unwrap();
    let plan = &mut case.plan;
    plan.lights = vec![PlanLight::Head { radiance: [1.0; 3] }];
    let technique = plan.technique_mut();
    technique.gradient_input = GradientInput::Segment;
    technique.shade = Shade::Lit {
        ambient: 0.2,
        illuminate: Illuminate::Lambert { diffuse: 0.8 },
        keep_last_normal: false,
    };
    plan.layers[0].segments = Segments::Labeled(Box::new(Labeled {
        labels: 0,
        grid: *labels.grid(),
        is_moved: false,
        looks: [].into(),
        others: SegmentLook::of(0),
        groups: Vec::new(),
    }));
    case.labels.push(labels);
}

/// The functions that are variants of the Plan, with random values of their parameters.
fn choose(plan: &mut Plan, function: &Function, random: &mut Random) {
    let drawn = random_values(function, random, [0.0, 255.0], WHITE_PER_MM);
    let value = |parameter: &str| drawn[parameter];
    let name = function.is_way_of.unwrap_or(function.name);
    match (function.slot, function.name) {
        // The other ways to reconstruct are those of a texture unit that interpolates.
        ("fetch", "stored") => plan.field_mut().reconstruct = Reconstruct::CatmullRom,
        ("fetch", _) => {
            plan.field_mut().fetch = Fetch::of(name, value).unwrap();
            plan.technique_mut().table = in_unit();
        }
        ("reconstruct", _) => {
            plan.field_mut().reconstruct = Reconstruct::of(name, value).unwrap();
            let has_sampler = Function::of_slot("reconstruct").any(|f| f.is_way_of == Some(name));
            // Of a volume that is a function there is no texture that could be interpolated.
            if has_sampler && function.is_way_of.is_none() {
                of_function(plan);
            } else if name == "b_spline" && random.once_in(2) {
                plan.field_mut().reconstruct = Reconstruct::BSplineInterpolating;
            }
        }
        ("classify", _) => {
            plan.technique_mut().classify = Classify::of(name, value).unwrap();
            if let Classify::ValueGradient { columns, rows, .. } =
                &mut plan.technique_mut().classify
            {
                (*columns, *rows) = (6, 5);
                let any = |_| [0; 4].map(|_: i32| random.unit() as f32);
                let entries = (0..30).map(any).collect();
                plan.technique_mut().table = TransferTable::of_rows([0.0, 255.0], 1.0, 6, entries);
            }
            if name == "pre_classified" {
                plan.technique_mut().table = soft(random, false);
            }
        }
        ("gradient_input", "opacity") => {
            raw_gradient(plan, 1.0);
            plan.technique_mut().table = soft(random, false);
            plan.technique_mut().gradient_input = GradientInput::Opacity;
        }
        ("gradient_input", _) => raw_gradient(plan, WHITE_PER_MM as f32),
        ("gradient", _) => {
            raw_gradient(plan, WHITE_PER_MM as f32);
            plan.field_mut().gradient = GradientMethod::of(name, value).unwrap();
        }
        ("illuminate", _) => {
            let radiance = std::array::from_fn(|_| random.between(0.3, 1.0) as f32);
            plan.lights = vec![PlanLight::Directional {
                to_light: random.direction(),
                radiance,
            }];
            plan.technique_mut().shade = Shade::Lit {
                ambient: 0.2,
                illuminate: Illuminate::of(name, value).unwrap(),
                keep_last_normal: false,
            };
        }
        ("illustrate", _) => {
            let (near, far) = (15.0, 35.0);
            let style = Illustrate::of(name, |parameter| match parameter {
                "nearest_mm" => near,
                "farthest_mm" => far,
                "width_mm" | "reach_mm" => 1.0 + 0.5 * value("strength").min(1.0),
                other => value(other),
            });
            plan.technique_mut().illustrate = style.unwrap();
        }
        ("composite", _) => {
            some_samples(plan);
            plan.technique_mut().table = soft(random, false);
            plan.technique_mut().composite = Composite::of(name, value).unwrap();
        }
        (slot, name) => panic!("{slot}/{name}: no case"),
    }
}

/// A steep gradient of values from 0 to 255, one mm apart.
const WHITE_PER_MM: f64 = 255.0;

/// Four samples per ray.
fn some_samples(plan: &mut Plan) {
    let forward = plan.camera.forward;
    let half = 2.0 * plan.lattice.step_mm;
    plan.ray_clips = vec![plane(forward, half), plane(-forward, half)];
}

fn of_function(plan: &mut Plan) {
    plan.field_mut().fetch = Fetch::Noise {
        cell_voxels: 3.0,
        octaves: 1,
        seed: 5,
    };
    plan.technique_mut().table = in_unit();
}

fn in_unit() -> TransferTable {
    let entries = vec![[0.0, 0.0, 0.0, 1.0], [1.0, 1.0, 1.0, 1.0]];
    TransferTable::new([0.0, 1.0], 1.0, entries)
}

/// Shows the length of the gradient.
fn raw_gradient(plan: &mut Plan, white_per_mm: f32) {
    plan.technique_mut().composite =
        Composite::Debug(DebugView::GradientMagnitude { white_per_mm });
}

fn clip_ray(case: &mut Case, function: &str, random: &mut Random) {
    let through = random.between(-1.0, 1.0);
    match function {
        "plane" => {
            let normal = random.direction();
            case.plan.ray_clips.push(plane(normal, through));
        }
        _ => {
            case.meshes.push(wall(1.0));
            case.plan.ray_clips.clear();
            case.plan.meshes.push(PlanMesh {
                mesh: 0,
                world_from_mesh: DAffine3::from_mat3_translation(
                    DMat3::from_rotation_z(random.between(0.0, 3.0)) * 0.15,
                    random.direction() * 2.0,
                ),
                color: [0.2, 0.5, 0.9],
            });
            case.plan.technique_mut().table = soft(random, false);
            case.plan.lights = vec![PlanLight::Head { radiance: [1.0; 3] }];
        }
    }
}

fn clip_sample(case: &mut Case, function: &str, random: &mut Random) {
    let edges = DVec3::new(random.between(2.0, 6.0), random.between(2.0, 6.0), 5.0);
    let axes = DMat3::from_rotation_x(random.between(0.0, 3.0)) * DMat3::from_diagonal(edges);
    let unit_from_world = DAffine3::from_mat3_translation(axes, random.direction()).inverse();
    let mut clip = cut_box(unit_from_world, random.once_in(2));
    clip.shape = match function {
        "box" => ClipShape::Box,
        "cylinder" => ClipShape::Cylinder,
        "ellipsoid" => ClipShape::Ellipsoid,
        _ => {
            case.masks.push(noise(random));
            clip.unit_from_world = case.masks[0].grid().voxel_from_world();
            let scale = DVec3::from_array(DIMS.map(|n| 1.0 / n as f64));
            clip.unit_from_world = DAffine3::from_scale(scale)
                * DAffine3::from_translation(DVec3::splat(0.5))
                * clip.unit_from_world;
            ClipShape::Mask {
                mask: 0,
                threshold: 127.5,
            }
        }
    };
    case.plan.sample_clips.push(clip);
}

fn lit(plan: &mut Plan, function: &Function, random: &mut Random) {
    let radiance = std::array::from_fn(|_| random.between(0.3, 1.0) as f32);
    plan.lights = vec![match function.name {
        "point" => PlanLight::Point {
            place_mm: random.direction() * random.between(2.0, 20.0),
            reach_mm: random.between(5.0, 30.0) as f32,
            radiance,
        },
        "head" => PlanLight::Head { radiance },
        _ => PlanLight::Directional {
            to_light: random.direction(),
            radiance,
        },
    }];
    let drawn = random_values(function, random, [0.0, 255.0], WHITE_PER_MM);
    let shade = Shade::of(function.name, |parameter| drawn[parameter]);
    plan.technique_mut().shade = shade.unwrap_or(Shade::Lit {
        ambient: 0.2,
        illuminate: Illuminate::Lambert { diffuse: 0.9 },
        keep_last_normal: function.name == "lit_last_normal",
    });
}

#[test]
fn exceptions_are_of_functions_that_there_are() {
    for (name, _) in EXCEPTIONS {
        let (slot, function) = name.split_once('/').unwrap();
        let found = Function::of_slot(slot).any(|f| f.name == function);
        assert!(found, "{name}");
    }
}

#[test]
fn twins_give_the_same_from_the_same_numbers() {
    let Some(device) = device() else { return };
    let adapter = device.adapter();
    let (weights, flips) = match adapter.to_string().contains("software") {
        true => (0.0, 0.0),
        false => (HARDWARE_WEIGHTS, 0.05),
    };
    let mut wrong = Vec::new();
    for of in FUNCTIONS.iter().filter(|f| f.has_text) {
        let Function { slot, name, .. } = of;
        let twin = alike_of(of.slot, of.name);
        let (mut most, mut off, mut all, mut seen) = (0.0f32, 0usize, 0usize, 0usize);
        for seed in seeds(3) {
            let mut random = Random::new(seed ^ 0x7315);
            let (case, cpu) = seen_case(of, &mut random);
            let mut renderer = Renderer::new(device, case.data());
            let program = renderer.program(&case.plan).unwrap();
            let heading = format!(": {name} (library/{slot}/{name}.wgsl) ----");
            if !program.wgsl().contains(&heading) {
                wrong.push(format!("{slot}/{name}: not called"));
                continue;
            }
            let gpu = renderer.render(&case.plan, &Control::NONE).unwrap();
            for (a, b) in cpu.image.pixels().iter().zip(gpu.image.pixels()) {
                let d = a.iter().zip(b).map(|(a, b)| (a - b).abs());
                let d = d.fold(
                    0.0f32,
                    |most, d| if d.is_nan() { f32::MAX } else { most.max(d) },
                );
                all += 1;
                seen += usize::from(a[3] > 0.0);
                if d > twin.tolerance + weights {
                    off += 1;
                } else {
                    most = most.max(d);
                }
            }
        }
        let share = off as f64 / all as f64;
        println!(
            "{:32} {most:.1e} {share:.4}, {seen} of {all} seen",
            format!("{slot}/{name}")
        );
        if share > twin.flips + flips || seen < all / 5 {
            wrong.push(format!(
                "{slot}/{name}: {share:.4} are off by more than {}, {seen} of {all} are seen",
                twin.tolerance
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
