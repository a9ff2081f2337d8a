use crate::{ct_head, engine, header_at, header_of};
use glam::DVec3;
use strahl_scene::{
    Camera, Color, Headers, LabelHeader, LabelName, MaskClip, Method, Scene, TransferFunction,
    TransferPoint, VolumeSource, resolve, resolve_with,
};
use strahl_volume::{Grid, Label, LabelVolume, Metadata, Rescale, Samples, Volume};

fn report(scene: &Scene) -> String {
    match resolve(scene, &ct_head(), None) {
        Ok(_) => "no problem".to_owned(),
        Err(problems) => problems.to_string(),
    }
}

fn parsed(text: &str) -> Scene {
    Scene::parse("scene.json", text).unwrap()
}

#[test]
fn all_problems_come_at_once() {
    let everything_wrong = parsed(
        r##"{
          "format": 2,
          "volume": { "path": "a.nii", "phantom": "anatomy", "type": "u7", "dims": [0, 1, 1], "spacing_mm": [1, 1, -1] },
          "preset": "ct-bones",
          "size": [0, 70000],
          "threshold": 1e99,
          "transfer_function": {
            "points": [[0, 0.5, "#000"], [50, 1.5, [2, 0, 0]], [40, 0.1]],
            "opacity": [0, 2], "color_map": "hot", "window": -1, "reference_mm": 0
          },
          "shading": { "ambient": -1, "shininess": 0 },
          "lights": [
            { "type": "head", "azimuth_deg": 10 },
            { "type": "directional", "elevation_deg": 100, "intensity": -3 }
          ],
          "camera": { "view_angle_deg": 200, "zoom": 0, "position": [1, 2, 3], "azimuth_deg": 3 },
          "clips": [
            { "plane": { "normal": [0, 0, 0], "point": [0, 0, 0], "distance_mm": 2 } },
            { "box": { "min": [0, 0, 0], "max": [1, 1, 0] } },
            { "box": { "min": [0, 0, 0], "max": [1, 1, 1], "space": "voxels", "rotation_deg": [0, 10, 0] } }
          ],
          "step_mm": -0.5,
          "early_termination": 2,
          "background": [0, 0, 1.5],
          "display": { "exposure": 0, "white_point": 2, "gamma": 0, "fxaa": true }
        }"##,
    );
    let problems = report(&everything_wrong);
    insta::assert_snapshot!(problems);
}

#[test]
fn problems_that_hide_each_other() {
    let texts = [
        r#"{ "step_mm": 0 }"#,
        r#"{ "step_voxels": 1e-9 }"#,
        r#"{ "step_voxels": 1e9 }"#,
        r#"{ "step_mm": 1, "step_voxels": 1 }"#,
        r#"{ "method": "average", "shading": { "model": "blinn-phong" } }"#,
        r#"{ "camera": { "position": [0, 0, 100], "focus": [0, 0, 0], "up": [0, 0, 1] } }"#,
        r#"{ "camera": { "position": [1, 2, 3], "focus": [1, 2, 3] } }"#,
        r#"{ "camera": { "elevation_deg": 90.1 } }"#,
        r#"{ "camera": { "up": [0, 0, 1] } }"#,
        r#"{ "camera": { "projection": "orthographic", "view_angle_deg": 30 } }"#,
        r#"{ "camera": { "height_mm": 30 } }"#,
        r#"{ "camera": { "zoom": 0.1 } }"#,
        r#"{ "transfer_function": { "points": [] } }"#,
        r#"{ "transfer_function": { "points": [[0, 0]], "reference_mm": 1, "reference_voxels": 1 } }"#,
        r#"{ "clips": [{ "mask": { "path": "m.nrrd", "labels": [1, "liver"], "threshold": 0.2 } }, { "mask": { "path": "m.nrrd", "labels": [] } }] }"#,
        r#"{ "volume": {} }"#,
        r#"{ "volume": { "phantom": "anatomy", "series": "1", "endian": "big" } }"#,
    ];
    let text: Vec<String> = texts
        .iter()
        .map(|text| format!("{text}\n  {}", report(&parsed(text)).replace('\n', "\n  ")))
        .collect();
    insta::assert_snapshot!(text.join("\n"));
}

#[test]
fn numbers_that_are_none_are_refused() {
    // JSON cannot say NaN, code can.
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let scene = Scene {
            step_mm: Some(bad),
            early_termination: Some(bad),
            transfer_function: Some(TransferFunction {
                points: Some(vec![
                    TransferPoint::new(bad, 0.5, Color::WHITE),
                    TransferPoint::new(0.0, bad, Color([bad; 3])),
                ]),
                ..TransferFunction::default()
            }),
            camera: Some(Camera {
                zoom: Some(bad),
                focus: Some([0.0, bad, 0.0]),
                view_angle_deg: Some(bad),
                ..Camera::default()
            }),
            ..Scene::default()
        };
        let problems = resolve(&scene, &ct_head(), None).unwrap_err();
        let paths: Vec<_> = problems.iter().map(|problem| &*problem.path).collect();
        assert_eq!(
            paths,
            [
                "transfer_function.points[0].value",
                "transfer_function.points[1].opacity",
                "transfer_function.points[1].color",
                "camera.zoom",
                "camera.focus",
                "camera.view_angle_deg",
                "step_mm",
                "early_termination",
            ]
        );
    }
}

#[test]
fn labels_that_lie_elsewhere_are_refused() {
    let scene = Scene::default();
    let of = |dims, corner| LabelHeader {
        grid: header_at(dims, corner).grid,
        labels: Vec::new(),
        ids: vec![0, 1],
        unused_ids: Vec::new(),
    };
    let same = of([256, 256, 128], DVec3::new(-127.0, -127.0, -64.0));
    assert!(resolve(&scene, &engine(), Some(&same)).is_ok());
    // On a grid of their own they have to meet the volume somewhere.
    let shifted = of([64, 64, 32], DVec3::new(100.5, -127.0, -64.0));
    assert!(resolve(&scene, &engine(), Some(&shifted)).is_ok());
    let elsewhere = of([64, 64, 32], DVec3::new(129.0, -127.0, -64.0));
    let problems = resolve(&scene, &engine(), Some(&elsewhere)).unwrap_err();
    insta::assert_snapshot!(problems);
}

#[test]
fn labels_that_a_mask_does_not_have() {
    let ids = Samples::U8([0, 1, 2, 3, 4, 9, 9, 200].to_vec());
    let grid = Grid::centered([2, 2, 2], DVec3::ONE).unwrap();
    let volume = Volume::new(grid, ids, Rescale::IDENTITY, Metadata::default()).unwrap();
    let named = vec![Label::new(3, "liver"), Label::new(77, "spleen")];
    let labels = LabelVolume::from_volume(volume, named).unwrap();
    let clip = |labels: &[LabelName]| MaskClip {
        path: "organs.nrrd".into(),
        labels: Some(labels.to_vec()),
        ..MaskClip::default()
    };
    let of_name = |name: &str| LabelName::Name(name.into());
    let good = [LabelName::Id(9), of_name("spleen"), of_name("liver")];
    let found = clip(&good).label_ids("clips[0]", &labels);
    assert_eq!(found, Ok(vec![9, 77, 3]));
    let bad = [LabelName::Id(5), LabelName::Id(9), of_name("Liver")];
    let problems = clip(&bad).label_ids("clips[0]", &labels).unwrap_err();
    insta::assert_snapshot!(problems);
}

#[test]
fn odd_volumes_resolve_or_say_why() {
    let scene = Scene::default();
    for samples in [
        Samples::U8(vec![7; 3]),
        Samples::F32(vec![f32::NAN; 3]),
        Samples::F32(vec![f32::MIN_POSITIVE, 0.0]),
        Samples::F32(vec![1e29, 1e29 + 1e22]),
        Samples::I32(vec![i32::MIN, i32::MAX]),
        Samples::U32(vec![u32::MAX, u32::MAX - 1]),
    ] {
        for rescale in [Rescale::IDENTITY, Rescale::new(-1e-3, 5.0)] {
            let header = header_of(samples.clone(), rescale);
            let plan = resolve(&scene, &header, None).unwrap();
            assert!(
                plan.technique()
                    .table
                    .entries()
                    .iter()
                    .flatten()
                    .all(|v| v.is_finite())
            );
        }
    }
    let huge = header_of(Samples::F64(vec![-1e300, 1e300]), Rescale::IDENTITY);
    let problems = resolve(&scene, &huge, None).unwrap_err().to_string();
    assert!(problems.contains("values from"), "{problems}");
}

#[test]
fn read_options_name_what_is_wrong() {
    let source = VolumeSource {
        path: Some("a.raw".into()),
        sample_type: Some("uint16".into()),
        dims: Some([2, 3, 4]),
        ..VolumeSource::default()
    };
    let options = source.read_options().unwrap();
    assert_eq!(options.raw.dims, Some([2, 3, 4]));
    assert_eq!(
        options.raw.sample_type,
        Some(strahl_volume::SampleType::U16)
    );
    let wrong = VolumeSource {
        sample_type: Some("complex".into()),
        ..source
    };
    assert_eq!(
        wrong.read_options().unwrap_err().to_string(),
        "volume.type is \"complex\"; allowed: u8, i8, u16, i16, u32, i32, f32 or f64"
    );
}

#[test]
fn rules_of_sampling_say_what_they_need() {
    let cases = [
        (
            r#"{ "sampling": { "rule": "split", "parts": 65 } }"#,
            "sampling.parts is 65; allowed: 1 to 64",
        ),
        (
            r#"{ "sampling": { "parts": 4 } }"#,
            "given for rule \"regular\"",
        ),
        (
            r#"{ "sampling": { "rule": "integrated", "parts": 4 } }"#,
            "given for rule \"integrated\"",
        ),
        (
            r#"{ "sampling": { "rule": "integrated" }, "functions": { "classify": { "module": "gradient_table" } } }"#,
            "a transfer function of the value, or rule \"refine\"",
        ),
        (
            r#"{ "sampling": { "rule": "refine", "error": 0.1 } }"#,
            "it belongs to adaptive",
        ),
        (
            r#"{ "sampling": { "rule": "by-opacity", "share": 1.5 } }"#,
            "0 to 1",
        ),
        (
            r#"{ "sampling": { "rule": "adaptive", "share": 0.1 }, "shading": { "model": "unlit" } }"#,
            "it belongs to by-opacity",
        ),
        (
            r#"{ "sampling": { "rule": "by-opacity" }, "functions": { "classify": { "module": "gradient_table" } } }"#,
            "a transfer function of the value",
        ),
        (
            r#"{ "sampling": { "error": 0.6 }, "shading": { "model": "unlit" } }"#,
            "0 to 0.5",
        ),
        (
            r#"{ "sampling": { "error": 0.1 } }"#,
            "sampling.rule is \"adaptive\" with shading",
        ),
        (
            r#"{ "sampling": { "rule": "split" }, "method": "mip" }"#,
            "method emission-absorption, or rule \"refine\" with mip or minip",
        ),
        (
            r#"{ "sampling": { "rule": "split" }, "functions": { "classify": { "module": "gradient_table" } } }"#,
            "rule \"refine\"",
        ),
    ];
    for (scene, part) in cases {
        let report = report(&parsed(scene));
        assert!(report.contains(part), "{scene}: {report}");
    }
}

/// Methods that keep one number of a ray, or find one place, draw one volume: of several, the message names the key,
/// its value, and the methods that mix.
#[test]
fn several_volumes_need_a_method_that_mixes() {
    let headers = Headers {
        volumes: vec![engine(), engine()],
        ..Headers::from(engine())
    };
    let problems = |text: &str| {
        let objects = r#""objects": [{ "name": "b", "volume": { "path": "b.nrrd" } }]"#;
        let scene = Scene::parse("scene", &format!("{{ {text}, {objects} }}")).unwrap();
        match resolve_with(&scene, &headers) {
            Ok(_) => String::new(),
            Err(problems) => problems.to_string(),
        }
    };
    let mixing = ["emission-absorption", "back-to-front"];
    let mut refused = 0;
    for method in Method::ALL {
        let name = method.name();
        let found = problems(&format!(r#""method": "{name}""#));
        if mixing.contains(&name) {
            assert_eq!(found, "");
            continue;
        }
        refused += 1;
        let expected = format!("method is {name:?}, which does not mix several volumes");
        assert!(found.contains(&expected), "{found}");
        assert!(mixing.iter().all(|rule| found.contains(rule)), "{found}");
        assert!(found.contains("or one volume"), "{found}");
    }
    assert!(refused >= 8);
    for view in ["entry", "depth", "sample-count", "gradient-magnitude"] {
        let found = problems(&format!(r#""debug": "{view}""#));
        let expected = format!("debug is {view:?}, which does not mix several volumes");
        assert!(found.contains(&expected), "{found}");
    }
    // Nor do rules of sampling with a memory of one volume.
    for rule in ["refine", "split", "integrated", "adaptive", "by-opacity"] {
        let found = problems(&format!(r#""sampling": {{ "rule": "{rule}" }}"#));
        assert!(
            found.contains(&format!("sampling.rule is {rule:?} with several volumes")),
            "{found}"
        );
        assert!(found.contains("\"regular\", or one volume"), "{found}");
    }
}
