//! Every function of the library, alone: its WGSL on an adapter beside its Rust on the processor, from
//! the same random numbers.
//!
//! Each pixel is one call: parallel rays through a volume of noise, cut to one sample each, with random
//! parameters. A composite gets some samples per ray, or it would have nothing to do.

use crate::gpu::device;
use crate::random::{Random, seeds};
use crate::simple::{centred, cut_box, of_samples, one_sample_at, parallel, plan, plane};
use crate::variants::wall;
use glam::{DAffine3, DMat3, DVec3};
use strahl_gpu::Renderer;
use strahl_scene::plan::*;
use strahl_scene::transfer::TransferTable;
use strahl_shader::library;
use strahl_volume::{Control, Datasets, Mesh, Samples, Volume};

/// A function, how far a channel may be off, and the share of the calls whose decision may fall the
/// other way.
struct Twin {
    /// Slot and name.
    name: &'static str,
    /// Largest difference of a linear channel, where 1 is white.
    tolerance: f32,
    /// Share of the pixels that may be off by more.
    flips: f64,
}

const fn twin(name: &'static str, tolerance: f32, flips: f64) -> Twin {
    Twin {
        name,
        tolerance,
        flips,
    }
}

/// Arithmetic in single precision, in another order.
const ROUNDING: f32 = 1e-5;
/// The same of values from 0 to 255, whose digits differences use up.
const CANCELLED: f32 = 3e-5;
/// Normals: where a gradient is small, its rounding turns them; highlights and mirrors enlarge that.
const TURNED: f32 = 1e-3;
/// Texture units of hardware have weights of 8 bits, up to 1/512 off in each axis, of the whole range of
/// values; those of software adapters are exact. A gradient has them twice.
const HARDWARE_WEIGHTS: f32 = 6.0 / 512.0;

const TWINS: &[Twin] = &[
    // A sample that lies on a face is on either side of it.
    twin("clip_ray/plane", ROUNDING, 0.005),
    // Triangles are drawn on one, and met by rays on the other: edges.
    twin("clip_ray/depth", ROUNDING, 0.01),
    twin("jitter/hash", ROUNDING, 0.0),
    // The sine of a large number, whose last bits the shift is made of.
    twin("jitter/sine_hash", 3e-3, 0.02),
    twin("jitter/tile", ROUNDING, 0.0),
    // Faces again.
    twin("clip_sample/box", ROUNDING, 0.005),
    twin("clip_sample/cylinder", ROUNDING, 0.005),
    twin("clip_sample/ellipsoid", ROUNDING, 0.005),
    // Where the mask crosses its threshold.
    twin("clip_sample/mask", ROUNDING, 0.005),
    twin("fetch/texture", ROUNDING, 0.0),
    twin("fetch/marschner_lobb", ROUNDING, 0.0),
    twin("fetch/noise", ROUNDING, 0.0),
    // Half way between two voxels.
    twin("reconstruct/nearest", ROUNDING, 0.005),
    twin("reconstruct/trilinear", ROUNDING, 0.0),
    twin("reconstruct/trilinear_sampler", ROUNDING, 0.0),
    twin("reconstruct/b_spline", ROUNDING, 0.0),
    twin("reconstruct/b_spline_sampler", ROUNDING, 0.0),
    twin("reconstruct/catmull_rom", ROUNDING, 0.0),
    twin("classify/table", ROUNDING, 0.0),
    // Opacity by value: what is nearly transparent is divided by little.
    twin("classify/identity", CANCELLED, 0.0),
    // A value at the threshold is on either side of it.
    twin("classify/threshold", ROUNDING, 0.005),
    twin("classify/gradient_table", CANCELLED, 0.0),
    twin("classify/pre_classified", ROUNDING, 0.0),
    twin("gradient_input/value", CANCELLED, 0.0),
    twin("gradient_input/opacity", CANCELLED, 0.0),
    twin("gradient/forward", CANCELLED, 0.0),
    twin("gradient/backward", CANCELLED, 0.0),
    twin("gradient/central", CANCELLED, 0.0),
    twin("gradient/central_9", CANCELLED, 0.0),
    twin("gradient/sobel", CANCELLED, 0.0),
    twin("gradient/b_spline", CANCELLED, 0.0),
    twin("light/directional", TURNED, 0.002),
    twin("light/point", TURNED, 0.002),
    twin("light/head", TURNED, 0.002),
    twin("illuminate/lambert", TURNED, 0.002),
    twin("illuminate/phong", TURNED, 0.002),
    twin("illuminate/blinn_phong", TURNED, 0.002),
    twin("illuminate/cook_torrance", TURNED, 0.002),
    twin("shade/lit", TURNED, 0.002),
    twin("shade/lit_last_normal", TURNED, 0.002),
    twin("shade/gradient_opacity", CANCELLED, 0.0),
    twin("composite/front_to_back", ROUNDING, 0.0),
    twin("composite/back_to_front", ROUNDING, 0.0),
    twin("composite/maximum", ROUNDING, 0.0),
    twin("composite/minimum", ROUNDING, 0.0),
    twin("composite/average", ROUNDING, 0.0),
    twin("composite/mida", ROUNDING, 0.0),
    // Whether the value crosses the threshold, and where.
    twin("composite/first_hit", CANCELLED, 0.005),
    twin("composite/hit_depth", CANCELLED, 0.005),
    twin("composite/gradient_maximum", CANCELLED, 0.0),
    // The first sample that is seen.
    twin("composite/gradient_magnitude", CANCELLED, 0.005),
    twin("composite/normal", TURNED, 0.005),
    // In values per mm, up to 255, not from 0 to 1.
    twin("composite/normal_raw", TURNED, 0.005),
    twin("composite/entry", ROUNDING, 0.0),
    twin("composite/exit", ROUNDING, 0.0),
    // A sample more or less where the ray leaves.
    twin("composite/sample_count", ROUNDING, 0.005),
];

/// What a call is made with.
struct Case {
    volume: Volume,
    masks: Vec<Volume>,
    meshes: Vec<Mesh>,
    plan: Plan,
}

const DIMS: [usize; 3] = [11, 9, 10];

fn noise(random: &mut Random) -> Volume {
    let n = DIMS.iter().product::<usize>();
    let samples = Samples::U8((0..n).map(|_| random.below(256) as u8).collect());
    let axes = DMat3::from_diagonal(DVec3::new(1.0, 1.2, 0.9));
    of_samples(centred(DIMS, axes), samples)
}

/// Smooth in colour and opacity.
fn soft(random: &mut Random, is_opaque: bool) -> TransferTable {
    let (a, b) = (random.unit() as f32, random.unit() as f32);
    let entries = (0..64).map(|i| {
        let v = i as f32 / 63.0;
        let opacity = if is_opaque { 1.0 } else { 0.1 + 0.5 * v };
        [v, 1.0 - v, a * v + b * (1.0 - v), opacity]
    });
    TransferTable::new([0.0, 255.0], 1.0, entries.collect())
}

fn case(name: &str, random: &mut Random) -> Case {
    let (slot, function) = name.split_once('/').unwrap();
    let volume = noise(random);
    let camera = parallel(random.direction(), 30.0, 3.0);
    let table = soft(random, true);
    let mut plan = plan(&volume, camera, table);
    (plan.width, plan.height) = (24, 20);
    one_sample_at(&mut plan, random.between(-1.0, 1.0));
    let mut case = Case {
        masks: Vec::new(),
        meshes: Vec::new(),
        plan,
        volume,
    };
    match slot {
        "clip_ray" => clip_ray(&mut case, function, random),
        "clip_sample" => clip_sample(&mut case, function, random),
        "composite" => composite(&mut case.plan, function, random),
        "illuminate" | "light" | "shade" => lit(&mut case.plan, slot, function, random),
        _ => choose(&mut case.plan, name, random),
    }
    case
}

/// The slots with one function each.
fn choose(plan: &mut Plan, name: &str, random: &mut Random) {
    let white_per_mm = 255.0;
    match name {
        "jitter/hash" => plan.lattice.jitter = Jitter::Hash(random.below(1 << 32) as u32),
        "jitter/sine_hash" => plan.lattice.jitter = Jitter::SineHash,
        "jitter/tile" => {
            let seed = random.below(1 << 32) as u32;
            plan.lattice.jitter = random.pick(&[Jitter::WhiteTile(seed), Jitter::BlueTile(seed)]);
        }
        "fetch/marschner_lobb" => {
            plan.field_mut().fetch = Fetch::MarschnerLobb {
                frequency: random.between(2.0, 8.0) as f32,
                alpha: random.between(0.1, 0.5) as f32,
            };
            plan.technique_mut().table = in_unit();
        }
        "fetch/noise" => {
            plan.field_mut().fetch = Fetch::Noise {
                cell_voxels: random.between(2.0, 6.0) as f32,
                octaves: 1 + random.below(3) as u32,
                seed: random.below(1 << 32) as u32,
            };
            plan.technique_mut().table = in_unit();
        }
        "reconstruct/nearest" => plan.field_mut().reconstruct = Reconstruct::Nearest,
        // Of a volume that is a function there is no texture that could be interpolated.
        "reconstruct/trilinear" => of_function(plan),
        "reconstruct/b_spline" => {
            of_function(plan);
            plan.field_mut().reconstruct = Reconstruct::BSpline;
        }
        "reconstruct/b_spline_sampler" => {
            plan.field_mut().reconstruct =
                random.pick(&[Reconstruct::BSpline, Reconstruct::BSplineInterpolating]);
        }
        "fetch/texture" | "reconstruct/catmull_rom" => {
            plan.field_mut().reconstruct = Reconstruct::CatmullRom;
        }
        "reconstruct/trilinear_sampler" | "classify/table" => {}
        "classify/identity" => {
            plan.technique_mut().classify = Classify::Identity {
                black: random.between(-50.0, 50.0) as f32,
                white: random.between(200.0, 300.0) as f32,
            };
        }
        "classify/threshold" => {
            plan.technique_mut().classify = Classify::Threshold {
                threshold: random.between(50.0, 200.0) as f32,
                black: 0.0,
                white: 255.0,
            };
        }
        "classify/gradient_table" => {
            plan.technique_mut().classify = Classify::GradientTable {
                low_per_mm: random.between(0.0, 50.0) as f32,
                high_per_mm: random.between(150.0, 255.0) as f32,
            };
        }
        "classify/pre_classified" => {
            plan.technique_mut().classify = Classify::PreClassified;
            plan.technique_mut().table = soft(random, false);
        }
        "gradient_input/value" => raw_gradient(plan, white_per_mm),
        "gradient_input/opacity" => {
            raw_gradient(plan, 1.0);
            plan.technique_mut().table = soft(random, false);
            plan.technique_mut().gradient_input = GradientInput::Opacity;
        }
        gradient => {
            raw_gradient(plan, white_per_mm);
            plan.field_mut().gradient = match gradient {
                "gradient/forward" => GradientMethod::Forward,
                "gradient/backward" => GradientMethod::Backward,
                "gradient/central" => GradientMethod::Central,
                "gradient/central_9" => GradientMethod::Central9,
                "gradient/sobel" => GradientMethod::Sobel,
                "gradient/b_spline" => GradientMethod::BSpline,
                other => panic!("{other}: no case"),
            };
        }
    }
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

fn lit(plan: &mut Plan, slot: &str, function: &str, random: &mut Random) {
    let radiance = std::array::from_fn(|_| random.between(0.3, 1.0) as f32);
    plan.lights = vec![match function {
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
    let (diffuse, specular) = (random.unit() as f32, 0.5 * random.unit() as f32);
    let shininess = random.between(1.0, 40.0) as f32;
    let illuminate = match (slot, function) {
        ("illuminate", "phong") => Illuminate::Phong {
            diffuse,
            specular,
            shininess,
        },
        ("illuminate", "cook_torrance") => Illuminate::CookTorrance {
            diffuse,
            roughness: random.between(0.2, 1.0) as f32,
            reflectance: specular,
        },
        ("illuminate", "lambert") | ("light", _) => Illuminate::Lambert { diffuse: 0.9 },
        _ => Illuminate::BlinnPhong {
            diffuse,
            specular,
            shininess,
        },
    };
    plan.technique_mut().shade = match function {
        "gradient_opacity" => Shade::GradientOpacity {
            full_per_mm: random.between(100.0, 300.0) as f32,
        },
        _ => Shade::Lit {
            ambient: 0.2,
            illuminate,
            keep_last_normal: function == "lit_last_normal",
        },
    };
}

fn composite(plan: &mut Plan, function: &str, random: &mut Random) {
    // Four samples.
    let forward = plan.camera.forward;
    let half = 2.0 * plan.lattice.step_mm;
    plan.ray_clips = vec![plane(forward, half), plane(-forward, half)];
    plan.technique_mut().table = soft(random, false);
    plan.technique_mut().composite = match function {
        "front_to_back" => Composite::EmissionAbsorption {
            stop_at_transmittance: 0.0,
        },
        "back_to_front" => Composite::BackToFront,
        "maximum" => Composite::Mip,
        "minimum" => Composite::MinIp,
        "average" => Composite::Average,
        "mida" => Composite::Mida {
            low: 0.0,
            high: 255.0,
            blend: random.between(-1.0, 0.0) as f32,
            stop_at_transmittance: 0.0,
        },
        "first_hit" | "hit_depth" => Composite::FirstHit {
            threshold: random.between(80.0, 180.0),
        },
        "gradient_maximum" => Composite::Gmip {
            white_per_mm: 255.0,
        },
        debug => Composite::Debug(match debug {
            "entry" => DebugView::Entry,
            "exit" => DebugView::Exit,
            "normal" => DebugView::Normal,
            "normal_raw" => DebugView::GradientRaw,
            "gradient_magnitude" => DebugView::GradientMagnitude {
                white_per_mm: 255.0,
            },
            "sample_count" => DebugView::SampleCount { white: 6.0 },
            other => panic!("{other}: no case"),
        }),
    };
    if function == "hit_depth" {
        plan.technique_mut().composite = Composite::Debug(DebugView::Depth {
            near_mm: 25.0,
            far_mm: 35.0,
        });
    }
}

#[test]
fn every_function_of_the_library_has_its_twin_here() {
    let named: Vec<_> = TWINS.iter().map(|twin| twin.name.to_owned()).collect();
    for module in library() {
        let name = format!("{}/{}", module.slot().name, module.name());
        assert!(named.contains(&name), "{name} is in no table");
    }
    assert_eq!(named.len(), library().len());
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
    for twin in TWINS {
        let (slot, function) = twin.name.split_once('/').unwrap();
        let (mut most, mut off, mut all, mut seen) = (0.0f32, 0usize, 0usize, 0usize);
        for seed in seeds(3) {
            let mut random = Random::new(seed ^ 0x7315);
            let case = case(twin.name, &mut random);
            let data = Datasets {
                volumes: vec![case.volume.clone()],
                masks: case.masks.clone(),
                meshes: case.meshes.clone(),
            };
            let cpu = strahl_cpu::Renderer::new(data.clone())
                .render(&case.plan, &Default::default(), &Control::NONE)
                .unwrap();
            let mut renderer = Renderer::new(device, data);
            let program = renderer.program(&case.plan).unwrap();
            let heading = format!(": {function} (library/{slot}/{function}.wgsl) ----");
            if !program.wgsl().contains(&heading) {
                wrong.push(format!("{}: not called", twin.name));
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
            twin.name
        );
        if share > twin.flips + flips || seen < all / 5 {
            wrong.push(format!(
                "{}: {share:.4} are off by more than {}, {seen} of {all} are seen",
                twin.name, twin.tolerance
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
