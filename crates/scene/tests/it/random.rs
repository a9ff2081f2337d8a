use crate::{ct_head, engine, header_at};
use proptest::collection::vec;
use proptest::option::of;
use proptest::prelude::*;
use proptest::sample::select;
use strahl_scene::plan::{Plan, PlanLight, Projection as PlanProjection};
use strahl_scene::*;

/// Numbers that scenes are likely to hold, and wild ones.
fn finite() -> BoxedStrategy<f64> {
    prop_oneof![
        4 => -2.0..2.0f64,
        4 => (-300i32..300).prop_map(f64::from),
        1 => any::<f64>().prop_filter("finite", |v| v.is_finite()),
        1 => select(vec![0.0, -0.0, 1e-300, 1e300, 90.0, 180.0, 1e-12, 1e12, 4e16, 1e27]),
    ]
    .boxed()
}

fn wild() -> BoxedStrategy<f64> {
    prop_oneof![
        12 => finite(),
        1 => select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY]),
    ]
    .boxed()
}

type Number = BoxedStrategy<f64>;

fn three(n: &Number) -> BoxedStrategy<[f64; 3]> {
    [n.clone(), n.clone(), n.clone()].boxed()
}

fn color(n: &Number) -> BoxedStrategy<Color> {
    prop_oneof![
        any::<[u8; 3]>().prop_map(|rgb| Color(rgb.map(|part| f64::from(part) / 255.0))),
        (0.0..1.0f64).prop_map(|grey| Color([grey; 3])),
        three(n).prop_map(Color),
    ]
    .boxed()
}

fn camera(n: &Number) -> BoxedStrategy<Camera> {
    (
        of(select(vec![
            Projection::Perspective,
            Projection::Orthographic,
        ])),
        of(select(View::ALL.to_vec())),
        [
            of(n.clone()),
            of(n.clone()),
            of(n.clone()),
            of(n.clone()),
            of(n.clone()),
        ],
        [of(three(n)), of(three(n)), of(three(n))],
    )
        .prop_map(
            |(
                projection,
                view,
                [elevation_deg, azimuth_deg, view_angle_deg, height_mm, zoom],
                [position, focus, up],
            )| {
                Camera {
                    projection,
                    view,
                    elevation_deg,
                    azimuth_deg,
                    position,
                    focus,
                    up,
                    view_angle_deg,
                    height_mm,
                    zoom,
                }
            },
        )
        .boxed()
}

fn transfer_function(n: &Number) -> BoxedStrategy<TransferFunction> {
    let point = (n.clone(), of(n.clone()), of(color(n))).prop_map(|(value, opacity, color)| {
        TransferPoint {
            value,
            opacity,
            color,
        }
    });
    let sorted = vec((n.clone(), 0.0..1.0f64, any::<[u8; 3]>()), 1..6).prop_map(|points| {
        let mut points: Vec<_> = points
            .into_iter()
            .map(|(value, opacity, rgb)| {
                TransferPoint::new(
                    value,
                    opacity,
                    Color(rgb.map(|part| f64::from(part) / 255.0)),
                )
            })
            .collect();
        points.sort_by(|a, b| a.value.total_cmp(&b.value));
        points
    });
    (
        of(prop_oneof![sorted, vec(point, 0..5)]),
        of(select(vec![PointsIn::Values, PointsIn::Window])),
        of(select(ColorMap::ALL.to_vec())),
        of([n.clone(), n.clone()]),
        [of(n.clone()), of(n.clone()), of(n.clone()), of(n.clone())],
    )
        .prop_map(
            |(
                points,
                points_in,
                color_map,
                opacity,
                [window, level, reference_mm, reference_voxels],
            )| {
                TransferFunction {
                    regions: None,
                    points,
                    points_in,
                    window,
                    level,
                    color_map,
                    opacity,
                    reference_mm,
                    reference_voxels,
                }
            },
        )
        .boxed()
}

fn light(n: &Number) -> BoxedStrategy<Light> {
    (
        select(vec![
            LightKind::Directional,
            LightKind::Point,
            LightKind::Head,
        ]),
        of(select(vec![LightSpace::Camera, LightSpace::World])),
        [of(n.clone()), of(n.clone()), of(n.clone()), of(n.clone())],
        of(three(n)),
        of(color(n)),
    )
        .prop_map(
            |(kind, space, [azimuth_deg, elevation_deg, intensity, reach_mm], position, color)| {
                Light {
                    position,
                    reach_mm,
                    kind,
                    space,
                    azimuth_deg,
                    elevation_deg,
                    color,
                    intensity,
                }
            },
        )
        .boxed()
}

fn clip(n: &Number) -> BoxedStrategy<Clip> {
    let frame = || {
        let names = ["volume", "other", "world", "nothing"];
        of(select(names.map(str::to_owned).to_vec()))
    };
    let plane = (three(n), of(three(n)), of(n.clone()), frame()).prop_map(
        |(normal, point, distance_mm, frame)| {
            Clip::Plane(PlaneClip {
                normal,
                point,
                distance_mm,
                frame,
                objects: None,
            })
        },
    );
    let space = of(select(vec![
        BoxSpace::World,
        BoxSpace::Voxels,
        BoxSpace::Fraction,
    ]));
    let keep = of(select(vec![KeptSide::Inside, KeptSide::Outside]));
    let objects = of(vec(
        select(vec!["volume".to_owned(), "other".to_owned()]),
        0..2,
    ));
    let cut = (
        0..3usize,
        three(n),
        three(n),
        space,
        of(three(n)),
        (keep, frame()),
        objects,
    )
        .prop_map(
            |(shape, min, max, space, rotation_deg, (keep, frame), objects)| {
                [Clip::Box, Clip::Ellipsoid, Clip::Cylinder][shape](BoxClip {
                    min,
                    max,
                    space,
                    rotation_deg,
                    keep,
                    frame,
                    objects,
                })
            },
        );
    prop_oneof![plane, cut].boxed()
}

fn function(n: &Number) -> BoxedStrategy<(String, FunctionUse)> {
    let slots = ["classify", "composite", "gradient", "jitter", "mine"].map(str::to_owned);
    let modules = ["table", "threshold", "mida", "sobel", "tile", "mine.wgsl"].map(str::to_owned);
    let parameters = ["threshold", "white", "high"].map(str::to_owned);
    (
        select(slots.to_vec()),
        select(modules.to_vec()),
        of((select(parameters.to_vec()), n.clone())),
    )
        .prop_map(|(slot, module, parameter)| {
            let params = parameter
                .into_iter()
                .map(|(name, value)| (name, ParameterValue::Number(value)));
            let params = params.collect();
            (slot, FunctionUse { module, params })
        })
        .boxed()
}

fn scene(n: Number) -> BoxedStrategy<Scene> {
    let volume = (
        of("[a-z/.\"\\\\]{0,8}"),
        of("[a-z]{0,8}"),
        of(any::<[usize; 3]>()),
        of(three(&n)),
    );
    let shading = (
        of(select(ShadingModel::ALL.to_vec())),
        [of(n.clone()), of(n.clone()), of(n.clone()), of(n.clone())],
        [of(n.clone()), of(n.clone()), of(n.clone())],
        of(any::<bool>()),
    );
    let beyond = (
        of(select(vec![
            Quality::Null,
            Quality::Minimum,
            Quality::Medium,
            Quality::Maximum,
        ])),
        of(select(vec![
            DebugView::Entry,
            DebugView::Depth,
            DebugView::GradientMagnitude,
        ])),
        of([n.clone(), n.clone()]),
        of(n.clone()),
        of(any::<u32>()),
        of(select(vec![Compositing::Linear, Compositing::Display])),
        of([three(&n), three(&n), three(&n), three(&n)]),
        of(vec(function(&n), 0..3)),
    );
    let settings = (
        of(select(Method::ALL.to_vec())),
        of(prop_oneof![
            4 => select(presets().iter().map(|p| p.name.to_owned()).collect::<Vec<_>>()),
            1 => "[a-z-]{0,9}",
        ]),
        of(select(vec![
            Reconstruct::Nearest,
            Reconstruct::Trilinear,
            Reconstruct::BSpline,
            Reconstruct::CatmullRom,
        ])),
        of(prop_oneof![
            Just(Jitter::Off),
            any::<u32>().prop_map(Jitter::Seed),
            any::<u32>().prop_map(Jitter::BlueTile)
        ]),
        of(prop_oneof![
            Just(Background::Transparent),
            color(&n).prop_map(Background::Color)
        ]),
        of(prop_oneof![(1u32..2000, 1u32..2000), any::<(u32, u32)>()]),
        of((
            of(n.clone()),
            of(select(ToneMap::ALL.to_vec())),
            of(n.clone()),
            of(n.clone()),
            of(any::<bool>()),
        )),
    );
    (
        of(volume),
        of(transfer_function(&n)),
        of(shading),
        of(vec(light(&n), 0..3)),
        of(camera(&n)),
        of(vec(clip(&n), 0..3)),
        settings,
        [of(n.clone()), of(n.clone()), of(n.clone()), of(n.clone())],
        beyond,
    )
        .prop_map(
            |(
                volume,
                transfer_function,
                shading,
                lights,
                camera,
                clips,
                settings,
                numbers,
                beyond,
            )| {
                let (quality, debug, grey_range, blend, frames, compositing, moved, functions) =
                    beyond;
                let (method, preset, reconstruct, jitter, background, size, display) = settings;
                let [threshold, step_mm, step_voxels, early_termination] = numbers;
                Scene {
                    format: Some(1),
                    volume: volume.map(|(path, phantom, dims, spacing_mm)| VolumeSource {
                        path,
                        phantom,
                        dims,
                        spacing_mm,
                        ..VolumeSource::default()
                    }),
                    labels: None,
                    techniques: None,
                    segments: None,
                    composite: None,
                    importance: None,
                    preset,
                    method,
                    threshold,
                    transfer_function,
                    shading: shading.map(|(model, matt, rough, keep_last_normal)| {
                        let [ambient, diffuse, specular, shininess] = matt;
                        let [roughness, reflectance, full_per_mm] = rough;
                        Shading {
                            model,
                            ambient,
                            diffuse,
                            specular,
                            shininess,
                            roughness,
                            reflectance,
                            full_per_mm,
                            keep_last_normal,
                        }
                    }),
                    quality,
                    debug,
                    grey_range,
                    blend,
                    frames,
                    compositing,
                    transform: moved.map(|[translate_mm, rotate_deg, scale, about]| Placement {
                        translate_mm: Some(translate_mm),
                        rotate_deg: Some(rotate_deg),
                        scale: Some(scale),
                        about: Some(about),
                    }),
                    functions: functions.map(|functions| functions.into_iter().collect()),
                    graph: frames.map(|n| {
                        let text = format!(r#"{{ "strahl_graph": 1, "name": "{n}" }}"#);
                        GraphText::new(text).unwrap()
                    }),
                    gradient: None,
                    objects: None,
                    lights,
                    camera,
                    clips,
                    reconstruct,
                    step_mm,
                    step_voxels,
                    sampling: frames.map(|n| Sampling {
                        rule: Some(SamplingRule::ALL[n as usize % SamplingRule::ALL.len()]),
                        parts: (n % 3 == 0).then_some(n),
                        error: blend.filter(|_| n % 2 == 0),
                        share: blend.filter(|_| n % 5 == 0),
                    }),
                    jitter,
                    early_termination,
                    background,
                    size: size.map(|(w, h)| [w, h]),
                    display: display.map(|(exposure, tone_map, white_point, gamma, fxaa)| {
                        Display {
                            exposure,
                            tone_map,
                            white_point,
                            gamma,
                            fxaa,
                            invert: fxaa.map(|fxaa| !fxaa),
                        }
                    }),
                }
            },
        )
        .boxed()
}

/// Every number of the plan is finite and inside its range.
fn check_plan(plan: &Plan) {
    assert!((1..=65_535).contains(&plan.width) && (1..=65_535).contains(&plan.height));
    let camera = &plan.camera;
    for axis in [camera.right, camera.up, camera.forward] {
        assert!((axis.length() - 1.0).abs() < 1e-9, "{camera:?}");
    }
    assert!(
        camera.right.cross(camera.up).distance(-camera.forward) < 1e-6,
        "{camera:?}"
    );
    assert!(camera.eye_mm.is_finite());
    let spread = match camera.projection {
        PlanProjection::Perspective { tan_half_height } => tan_half_height,
        PlanProjection::Orthographic { half_height_mm } => half_height_mm,
    };
    assert!(spread.is_finite() && spread > 0.0);
    assert!(plan.lattice.step_mm > 0.0 && plan.lattice.step_mm.is_finite());
    let [lo, hi] = plan.technique().table.domain();
    assert!(lo < hi && (hi - lo).is_finite(), "{lo} {hi}");
    assert!(plan.technique().table.reference_mm().is_finite());
    for part in plan.technique().table.entries().iter().flatten() {
        assert!((0.0..=1.0).contains(part), "{part}");
    }
    let probe = plan.technique().table.at(0.5 * lo + 0.5 * hi);
    assert!(probe.iter().all(|part| part.is_finite()));
    for light in &plan.lights {
        let (PlanLight::Directional { radiance, .. }
        | PlanLight::Point { radiance, .. }
        | PlanLight::Head { radiance }) = light;
        assert!(radiance.iter().all(|part| part.is_finite() && *part >= 0.0));
        if let PlanLight::Directional { to_light, .. } = light {
            assert!((to_light.length() - 1.0).abs() < 1e-9);
        }
    }
    for plane in &plan.ray_clips {
        assert!((plane.normal.length() - 1.0).abs() < 1e-9 && plane.offset_mm.is_finite());
    }
    for clip in &plan.sample_clips {
        assert!(clip.unit_from_world.is_finite());
    }
    assert!(
        plan.background
            .iter()
            .all(|part| (0.0..=1.0).contains(part))
    );
    assert!(plan.display.exposure > 0.0);
    if let plan::ToneMap::ReinhardExtended { white } | plan::ToneMap::Hable { white } =
        plan.display.tone_map
    {
        assert!((1e-3..=1e6).contains(&white));
    }
    if let plan::DisplayCurve::Power { gamma } = plan.display.curve {
        assert!((0.1..=10.0).contains(&gamma));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    #[test]
    fn what_is_written_is_read_again(scene in scene(finite())) {
        let text = scene.to_json();
        prop_assert_eq!(Scene::parse("random", &text).unwrap(), scene);
    }

    #[test]
    fn any_scene_resolves_or_says_why(scene in scene(wild()), which in 0..3usize) {
        let header = match which {
            0 => engine(),
            1 => ct_head(),
            _ => header_at([1, 7, 1], glam::DVec3::splat(1e6)),
        };
        match resolve(&scene, &header, None) {
            Ok(plan) => check_plan(&plan),
            Err(problems) => prop_assert!(problems.iter().count() > 0),
        }
    }

    #[test]
    fn a_camera_alone_resolves_or_says_why(camera in camera(&wild()), which in 0..2usize) {
        let header = if which == 0 { engine() } else { ct_head() };
        let scene = Scene { camera: Some(camera), ..Scene::default() };
        if let Ok(plan) = resolve(&scene, &header, None) {
            check_plan(&plan);
            let settled = settled(&scene, &header);
            prop_assert_eq!(resolve(&settled, &header, None).unwrap().camera, plan.camera);
        }
    }

    #[test]
    fn a_transfer_function_alone_resolves_or_says_why(function in transfer_function(&wild()), which in 0..2usize) {
        let header = if which == 0 { engine() } else { ct_head() };
        let scene = Scene { transfer_function: Some(function), ..Scene::default() };
        if let Ok(plan) = resolve(&scene, &header, None) {
            check_plan(&plan);
            let settled = settled(&scene, &header);
            prop_assert_eq!(resolve(&settled, &header, None).unwrap().technique().table.clone(), plan.technique().table.clone());
        }
    }

    #[test]
    fn any_text_is_a_scene_or_an_error(text in "[\\[\\]{}:,\"a-z0-9#/* .\\\\\n-]{0,80}") {
        let _ = Scene::parse("random", &text);
    }
}
