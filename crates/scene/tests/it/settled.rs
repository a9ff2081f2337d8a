use crate::{ct_head, engine, header_at};
use glam::DVec3;
use strahl_scene::plan::{
    Classify, ClipPlane, Composite, DebugView, GradientMethod, Illuminate, Jitter, Plan, PlanLight,
    Reconstruct, Shade,
};
use strahl_scene::{
    Headers, LabelHeader, Scene, plan, presets, resolve, resolve_with, segment_notes, settled,
    why_nothing_is_seen,
};
use strahl_volume::{Label, Modality, VolumeHeader};

fn plan(text: &str, header: &VolumeHeader) -> Plan {
    resolve(&Scene::parse("scene.json", text).unwrap(), header, None).unwrap()
}

/// Settling changes nothing that is drawn, twice settled is once settled, and the text of a settled
/// scene is the scene.
fn check_settled(scene: &Scene, header: &VolumeHeader) {
    let once = settled(scene, header);
    assert_eq!(settled(&once, header), once);
    assert_eq!(Scene::parse("settled", &once.to_json()).unwrap(), once);
    let (a, b) = (resolve(scene, header, None), resolve(&once, header, None));
    assert_eq!(format!("{:?}", a.unwrap()), format!("{:?}", b.unwrap()));
}

#[test]
fn a_settled_scene_draws_the_same() {
    let texts = [
        "{}",
        r#"{ "method": "mip" }"#,
        r#"{ "method": "average" }"#,
        r#"{ "method": "first-hit" }"#,
        r#"{ "preset": "mr", "method": "mip" }"#,
        r#"{ "transfer_function": { "window": 400, "level": 40 } }"#,
        r#"{ "transfer_function": { "color_map": "viridis" } }"#,
        r#"{ "transfer_function": { "opacity": [0, 0.2] } }"#,
        r#"{ "camera": { "projection": "orthographic" }, "size": [200, 300] }"#,
        r#"{ "camera": { "position": [500, 500, 0] } }"#,
        r#"{ "display": { "tone_map": "hable", "gamma": 1.8 } }"#,
        r#"{ "camera": { "azimuth_deg": 30 }, "clips": [{ "plane": { "normal": [1, 0, 0] } }] }"#,
        r#"{ "shading": { "ambient": 0.5 }, "lights": [{ "type": "directional", "azimuth_deg": 20 }] }"#,
    ];
    for header in [ct_head(), engine()] {
        for text in texts {
            check_settled(&Scene::parse("scene.json", text).unwrap(), &header);
        }
        for preset in presets() {
            let scene = Scene {
                preset: Some(preset.name.to_owned()),
                ..Scene::default()
            };
            check_settled(&scene, &header);
            check_settled(&preset.scene(), &header);
        }
    }
}

#[test]
fn the_preset_follows_the_volume() {
    let preset = |header: &VolumeHeader, text: &str| {
        let scene = Scene::parse("scene.json", text).unwrap();
        settled(&scene, header).preset.unwrap()
    };
    assert_eq!(preset(&ct_head(), "{}"), "ct-bone");
    assert_eq!(preset(&ct_head(), r#"{ "method": "mip" }"#), "mip");
    assert_eq!(preset(&ct_head(), r#"{ "method": "average" }"#), "x-ray");
    assert_eq!(preset(&engine(), "{}"), "solid");
    let mut unnamed = ct_head();
    unnamed.metadata.modality = None;
    assert_eq!(preset(&unnamed, "{}"), "ct-bone");
    let of = |modality: Modality| {
        let mut header = header_at([100, 100, 100], DVec3::new(-33.0, 12.0, 7.0));
        header.metadata.modality = Some(modality);
        preset(&header, "{}")
    };
    assert_eq!(of(Modality::Mr), "mr");
    assert_eq!(of(Modality::Nuclear), "mr");
    assert_eq!(of(Modality::Ultrasound), "mr");
    assert_eq!(of(Modality::Microscopy), "solid");
    assert_eq!(of(Modality::Simulation), "solid");
}

/// Files that name no device, as NIfTI never does.
#[test]
fn the_preset_of_a_nameless_volume_follows_its_values_and_place() {
    let preset = |header: &VolumeHeader| settled(&Scene::default(), header).preset.unwrap();
    // Bright voxels: half of the box, or two in a hundred.
    let bytes = |bright: u64, length_unit: bool, first: DVec3| {
        let mut header = header_at([100, 100, 100], first);
        header.statistics.histogram = vec![0; 256];
        header.statistics.histogram[3] = 1_000_000 - bright;
        header.statistics.histogram[200] = bright;
        header.metadata.has_length_unit = length_unit;
        preset(&header)
    };
    let (scanner, made_up) = (DVec3::new(-33.0, 12.0, 7.0), DVec3::splat(-49.5));
    assert_eq!(bytes(500_000, true, scanner), "mr");
    assert_eq!(bytes(20_000, true, scanner), "vessels");
    assert_eq!(bytes(500_000, true, made_up), "solid");
    assert_eq!(bytes(500_000, false, scanner), "solid");
    let with = |range: [f64; 2], unit: Option<&str>| {
        let mut header = header_at([100, 100, 100], made_up);
        header.statistics.range = range;
        header.metadata.value_unit = unit.map(str::to_owned);
        preset(&header)
    };
    assert_eq!(with([-1024.0, 1800.0], None), "ct-bone");
    // No air: not a CT as far as the values can say.
    assert_eq!(with([-200.0, 1800.0], None), "solid");
    assert_eq!(with([-200.0, 1800.0], Some("HU")), "ct-bone");
}

#[test]
fn a_scene_goes_before_its_preset() {
    let header = ct_head();
    let with = plan(
        r##"{ "preset": "ct-bone", "background": "#ff0000", "shading": { "ambient": 0.9 } }"##,
        &header,
    );
    assert_eq!(with.background, [1.0, 0.0, 0.0, 1.0]);
    let parts = |plan: &Plan| match plan.technique().shade {
        Shade::Lit {
            ambient,
            illuminate: Illuminate::BlinnPhong { diffuse, .. },
            ..
        } => (ambient, diffuse),
        _ => panic!("unlit"),
    };
    let (ambient, diffuse) = parts(&with);
    assert_eq!(ambient, 0.9);
    let plain = plan(r#"{ "preset": "ct-bone" }"#, &header);
    assert_eq!(diffuse, parts(&plain).1);
    assert_eq!(with.technique().table, plain.technique().table);
}

#[test]
fn tone_maps_get_their_white_points() {
    let header = ct_head();
    let display = |text: &str| plan(&format!(r#"{{ "display": {text} }}"#), &header).display;
    assert_eq!(display("{}"), plan::Display::PLAIN);
    let [r, g, b, _] = plan("{}", &header).background;
    let found = display(r#"{ "tone_map": "reinhard-extended", "gamma": 2.2, "fxaa": true }"#);
    let expected = plan::Display {
        exposure: 1.0,
        tone_map: plan::ToneMap::ReinhardExtended { white: 4.0 },
        curve: plan::DisplayCurve::Power { gamma: 2.2 },
        fxaa: true,
        invert: false,
        background: Some([r, g, b]),
    };
    assert_eq!(found, expected);
    let hable = |white: f32| plan::ToneMap::Hable { white };
    assert_eq!(display(r#"{ "tone_map": "hable" }"#).tone_map, hable(11.2));
    let found = display(r#"{ "tone_map": "hable", "white_point": 5 }"#);
    assert_eq!(found.tone_map, hable(5.0));
}

#[test]
fn methods_become_composites() {
    let header = ct_head();
    for (text, composite) in [
        (
            r#"{ "early_termination": 0 }"#,
            Composite::EmissionAbsorption {
                stop_at_transmittance: 0.0,
            },
        ),
        (r#"{ "method": "mip" }"#, Composite::Mip),
        (r#"{ "method": "minip" }"#, Composite::Minip),
        (r#"{ "method": "average" }"#, Composite::Average),
        (
            r#"{ "method": "first-hit", "threshold": 250 }"#,
            Composite::FirstHit { threshold: 250.0 },
        ),
    ] {
        assert_eq!(plan(text, &header).technique().composite, composite);
    }
    let mip = plan(r#"{ "method": "mip" }"#, &header);
    assert_eq!(mip.technique().shade, Shade::Unlit);
    assert!(mip.lights.is_empty());
}

#[test]
fn lights_stand_where_their_angles_say() {
    let text = r#"{ "lights": [
        { "type": "directional", "space": "world", "azimuth_deg": 90 },
        { "type": "directional", "space": "world", "elevation_deg": 90, "intensity": 0.5 },
        { "type": "directional", "azimuth_deg": 90 },
        { "type": "head" }
    ] }"#;
    let plan = plan(text, &ct_head());
    let towards: Vec<DVec3> = plan
        .lights
        .iter()
        .filter_map(|light| match light {
            PlanLight::Directional { to_light, .. } => Some(*to_light),
            PlanLight::Point { .. } | PlanLight::Head { .. } => None,
        })
        .collect();
    // The patient's left, the head, and the right edge of the frontal picture, which is left again.
    for (found, expected) in towards.iter().zip([-DVec3::X, DVec3::Z, -DVec3::X]) {
        assert!(found.distance(expected) < 1e-12, "{found}");
    }
    let PlanLight::Directional { radiance, .. } = plan.lights[1] else {
        panic!("not directional");
    };
    assert_eq!(radiance, [0.5; 3]);
    assert_eq!(plan.lights[3], PlanLight::Head { radiance: [1.0; 3] });
}

#[test]
fn rules_of_sampling() {
    let header = ct_head();
    let sampling = |text: &str| {
        plan(
            &format!(r#"{{ "shading": {{ "model": "unlit" }}, "sampling": {text} }}"#),
            &header,
        )
        .sampling
    };
    assert_eq!(plan("{}", &header).sampling, plan::Sampling::Regular);
    assert_eq!(sampling("{}"), plan::Sampling::Regular);
    assert_eq!(
        sampling(r#"{ "rule": "refine" }"#),
        plan::Sampling::Refine { parts: 8 }
    );
    let split = |parts, curve| plan::Sampling::Split { parts, curve };
    assert_eq!(
        sampling(r#"{ "rule": "split" }"#),
        split(10, plan::Curve::Linear)
    );
    assert_eq!(
        sampling(r#"{ "rule": "split-cubic", "parts": 3 }"#),
        split(3, plan::Curve::Cubic)
    );
    assert_eq!(
        sampling(r#"{ "rule": "integrated" }"#),
        plan::Sampling::Integrated
    );
    assert_eq!(
        sampling(r#"{ "error": 0.25 }"#),
        plan::Sampling::Adaptive { error: 0.25 }
    );
    assert_eq!(
        sampling(r#"{ "rule": "adaptive" }"#),
        plan::Sampling::Adaptive { error: 0.01 }
    );
    assert_eq!(
        sampling(r#"{ "rule": "by-opacity" }"#),
        plan::Sampling::ByOpacity { share: 0.2 }
    );
    assert_eq!(
        sampling(r#"{ "rule": "by-opacity", "share": 0 }"#),
        plan::Sampling::Regular
    );
    // What may not differ is the regular picture.
    assert_eq!(sampling(r#"{ "error": 0 }"#), plan::Sampling::Regular);
}

#[test]
fn steps_and_jitter() {
    let header = ct_head();
    assert_eq!(plan("{}", &header).lattice.step_mm, 0.25);
    let lattice = plan(r#"{ "step_mm": 2, "jitter": { "seed": 7 } }"#, &header).lattice;
    assert_eq!((lattice.step_mm, lattice.jitter), (2.0, Jitter::Hash(7)));
    assert_eq!(
        plan(r#"{ "step_voxels": 3 }"#, &header).lattice.step_mm,
        1.5
    );
}

#[test]
fn clips_keep_what_they_say() {
    let header = ct_head();
    let grid = header.grid;
    let kept = |plan: &Plan, point: DVec3| {
        plan.ray_clips.iter().all(
            |ClipPlane {
                 normal, offset_mm, ..
             }| normal.dot(point) + offset_mm >= 0.0,
        ) && plan.sample_clips.iter().all(|clip| {
            let unit = clip.unit_from_world.transform_point3(point);
            (unit.abs().max_element() <= 0.5) == clip.keep_inside
        })
    };
    let voxel = |x: f64, y: f64, z: f64| {
        grid.world_from_voxel()
            .transform_point3(DVec3::new(x, y, z))
    };
    let half = plan(
        r#"{ "clips": [{ "plane": { "normal": [0, 3, 0] } }] }"#,
        &header,
    );
    assert!(kept(&half, grid.center_mm() + DVec3::Y));
    assert!(!kept(&half, grid.center_mm() - DVec3::Y));
    let at = plan(
        r#"{ "clips": [{ "plane": { "normal": [0, 0, 2], "distance_mm": -700 } }] }"#,
        &header,
    );
    assert!(kept(&at, DVec3::new(0.0, 0.0, -699.0)) && !kept(&at, DVec3::new(0.0, 0.0, -701.0)));
    for (keep, inside) in [("inside", true), ("outside", false)] {
        let texts = [
            format!(
                r#"{{ "clips": [{{ "box": {{ "min": [100, 100, 50], "max": [300, 300, 150], "space": "voxels", "keep": "{keep}" }} }}] }}"#
            ),
            format!(
                r#"{{ "clips": [{{ "box": {{ "min": [0.25, 0.25, 0.25], "max": [0.75, 0.75, 0.75], "space": "fraction", "keep": "{keep}" }} }}] }}"#
            ),
        ];
        for text in texts {
            let plan = plan(&text, &header);
            assert_eq!(kept(&plan, voxel(200.0, 200.0, 100.0)), inside);
            assert_eq!(kept(&plan, voxel(102.0, 298.0, 52.0)), inside);
            assert_eq!(kept(&plan, voxel(97.0, 200.0, 100.0)), !inside);
            assert_eq!(kept(&plan, voxel(200.0, 302.0, 100.0)), !inside);
            assert_eq!(kept(&plan, voxel(200.0, 200.0, 152.0)), !inside);
        }
    }
    // Turned by 45° about z, a box of 20 mm reaches 14.1 mm along x and y, but not to its old corner.
    let turned = plan(
        r#"{ "clips": [{ "box": { "min": [-10, -10, -750], "max": [10, 10, -730], "rotation_deg": [0, 0, 45] } }] }"#,
        &header,
    );
    assert!(kept(&turned, DVec3::new(13.9, 0.0, -740.0)));
    assert!(!kept(&turned, DVec3::new(9.0, 9.0, -740.0)));
}

/// Saved as a scene and edited, the text of a preset draws what its name draws: every key of it arrives. No two presets
/// are the same.
#[test]
fn a_preset_draws_as_its_text_does() {
    let mut header = ct_head();
    header.grid = engine().grid;
    let labels = LabelHeader {
        grid: header.grid,
        labels: vec![
            Label::new(1, "skin"),
            Label::new(2, "femur_left"),
            Label::new(3, "aorta"),
        ],
        ids: vec![0, 1, 2, 3],
        unused_ids: Vec::new(),
    };
    let mut plans = Vec::new();
    for preset in presets() {
        // Where labels are, segments are drawn, in their own ways.
        let has_segments = preset.scene().segments.is_some();
        let plan = |scene: &Scene| {
            let headers = Headers {
                labels: has_segments.then(|| labels.clone()),
                ..Headers::from(header.clone())
            };
            let plan = resolve_with(scene, &headers);
            let plan = plan.unwrap_or_else(|problems| panic!("{}: {problems}", preset.name));
            let why = why_nothing_is_seen(&plan, &headers);
            assert!(why.is_empty(), "{}: {why:?}", preset.name);
            format!("{plan:?}")
        };
        let named = Scene {
            preset: Some(preset.name.to_owned()),
            ..Scene::default()
        };
        let written = Scene {
            preset: Some("mip".to_owned()),
            ..Scene::parse(preset.name, preset.text()).unwrap()
        };
        let by_name = plan(&named);
        assert!(by_name == plan(&written), "{}", preset.name);
        plans.push(by_name);
    }
    plans.sort();
    plans.dedup();
    assert_eq!(plans.len(), presets().len());
}

#[test]
fn qualities_choose_interpolation_gradient_and_light() {
    let of = |quality: &str| plan(&format!(r#"{{ "quality": "{quality}" }}"#), &ct_head());
    let entry = of("null");
    let shows_entry = Composite::Debug(DebugView::Entry);
    assert_eq!(entry.technique().composite, shows_entry);
    let least = of("minimum");
    assert_eq!(least.field().reconstruct, Reconstruct::Nearest);
    assert_eq!(least.technique().shade, Shade::Unlit);
    assert!(matches!(
        least.technique().classify,
        Classify::Identity { .. }
    ));
    let medium = of("medium");
    assert_eq!(medium.field().reconstruct, Reconstruct::Trilinear);
    assert_eq!(medium.field().gradient, GradientMethod::Central);
    let most = of("maximum");
    assert_eq!(most.field().reconstruct, Reconstruct::BSplineInterpolating);
    assert_eq!(most.field().gradient, GradientMethod::Central9);
    for (plan, is_best) in [(&medium, false), (&most, true)] {
        let Shade::Lit { illuminate, .. } = plan.technique().shade else {
            panic!("unlit")
        };
        let is_mirror = matches!(illuminate, Illuminate::CookTorrance { .. });
        assert_eq!(is_mirror, is_best, "{illuminate:?}");
    }
}

/// Many programs leave the unit of lengths out, and CT says by its values what it is.
#[test]
fn a_scan_in_hounsfield_units_opens_from_the_front_without_a_length_unit() {
    let view = |header: &VolumeHeader| {
        let camera = settled(&Scene::default(), header).camera.unwrap();
        (camera.elevation_deg, camera.azimuth_deg)
    };
    let mut header = ct_head();
    header.metadata.modality = None;
    header.metadata.has_length_unit = false;
    assert_eq!(view(&header), (Some(0.0), Some(0.0)));
    header.statistics.range = [0.0, 255.0];
    assert_eq!(view(&header), (Some(20.0), Some(30.0)));
    // Placed by nobody.
    let mut engine = engine();
    engine.statistics.range = [-1024.0, 3071.0];
    assert_eq!(view(&engine), (Some(20.0), Some(30.0)));
}

#[test]
fn segments_without_voxels_are_named_if_they_are_to_be_seen() {
    let labels = LabelHeader {
        grid: engine().grid,
        labels: vec![
            Label::new(1, "liver"),
            Label::new(2, "lung_left"),
            Label::new(3, "lung_right"),
            Label::new(4, "aorta"),
        ],
        ids: vec![0, 1, 2, 3, 4],
        unused_ids: vec![2, 3],
    };
    let notes = |segments: &str| {
        let text = format!(r#"{{ "segments": [{segments}] }}"#);
        segment_notes(&Scene::parse("scene.json", &text).unwrap(), &labels)
    };
    for (segments, note) in [
        (
            r#"{ "of": "lung_left" }"#,
            r#"segments[0].of: the segment "lung_left" (2) has no voxels"#,
        ),
        (
            r#"{ "of": "*", "show": false }, { "of": [4, "lung_*"], "show": true }"#,
            r#"segments[1].of: the segments "lung_left" (2), "lung_right" (3) have no voxels"#,
        ),
    ] {
        assert_eq!(notes(segments), [note]);
    }
    // Some of the chosen ones are there, or none is to be seen.
    for segments in [
        r#"{ "of": "l*" }"#,
        r#"{ "of": "*" }"#,
        r#"{ "of": "lung_left", "show": false }"#,
        r#"{ "of": { "not": ["lung_left"] } }"#,
    ] {
        assert_eq!(notes(segments), [""; 0], "{segments}");
    }
}
