//! Scenes with labels: what their keys say of segments is what is drawn.

use crate::variants::draw;
use strahl_scene::plan::{Composite, GradientInput, Illustrate, Plan, SegmentLook};
use strahl_scene::{LabelHeader, Scene, resolve};
use strahl_volume::{Datasets, LabelVolume, Phantom, Volume};

const DIMS: [usize; 3] = [40, 48, 56];

fn anatomy() -> (Volume, LabelVolume) {
    let labels = Phantom::Anatomy.labels(DIMS).unwrap().unwrap();
    (Phantom::Anatomy.volume(DIMS).unwrap(), labels)
}

fn plan(text: &str) -> Plan {
    let (volume, labels) = anatomy();
    let scene = Scene::parse("scene", text).unwrap();
    let labels = LabelHeader::from(&labels);
    resolve(&scene, &volume.header(), Some(&labels)).unwrap_or_else(|why| panic!("{text}: {why}"))
}

fn data() -> Datasets {
    let (volume, labels) = anatomy();
    Datasets {
        labels: vec![labels],
        ..Datasets::from(&volume)
    }
}

fn look(plan: &Plan, id: u32) -> SegmentLook {
    plan.labeled().unwrap().look_of(id)
}

#[test]
fn a_scene_draws_segments_by_their_techniques() {
    let (_, labels) = anatomy();
    let named = &labels.labels()[1];
    let text = format!(
        r##"{{ "size": [48, 40],
          "techniques": {{ "vessel": {{ "method": "mip" }} }},
          "segments": [
            {{ "of": "*", "opacity": 0.25 }},
            {{ "of": {:?}, "technique": "vessel", "color": "#f00", "opacity": 1 }},
            {{ "of": {}, "show": false }}
          ] }}"##,
        named.name,
        labels.labels()[0].id
    );
    let plan = plan(&text);
    let of_named = look(&plan, named.id);
    assert_eq!(of_named.tint, [1.0, 0.0, 0.0]);
    assert_eq!(of_named.opacity, 1.0);
    let technique = |id| &plan.techniques[look(&plan, id).technique.unwrap()];
    assert_eq!(technique(named.id).composite, Composite::Mip);
    assert_eq!(look(&plan, labels.labels()[0].id).technique, None);
    assert_eq!(look(&plan, 0).technique, None);
    let other = labels.labels()[2].id;
    assert_eq!(look(&plan, other).opacity, 0.25);
    assert_eq!(technique(other).gradient_input, GradientInput::Segment);
    // Only what is used is there.
    assert_eq!(plan.techniques.len(), 2);
    let drawn = draw(data(), &plan);
    assert!(drawn.stats.counts.as_ref().unwrap().samples_visible > 1000);
}

#[test]
fn all_segments_as_the_scene_says_are_the_picture_without_labels() {
    let (volume, _) = anatomy();
    for method in ["emission-absorption", "mip", "first-hit"] {
        let size = format!(
            r#""size": [48, 40], "early_termination": 0, "gradient": {{ "method": "central" }}, "method": "{method}""#
        );
        // One segment of all ids: the anatomy as one.
        let one = LabelVolume::from_volume(
            strahl_volume::Volume::new(
                *volume.grid(),
                strahl_volume::Samples::U8(vec![3; DIMS.iter().product()]),
                strahl_volume::Rescale::IDENTITY,
                strahl_volume::Metadata::default(),
            )
            .unwrap(),
            Vec::new(),
        )
        .unwrap();
        let without = Scene::parse("scene", &format!("{{ {size} }}")).unwrap();
        let with = format!(r#"{{ {size}, "segments": [{{ "of": 3, "technique": "scene" }}] }}"#);
        let with = Scene::parse("scene", &with).unwrap();
        let without = resolve(&without, &volume.header(), None).unwrap();
        let with = resolve(&with, &volume.header(), Some(&LabelHeader::from(&one))).unwrap();
        let data = Datasets {
            labels: vec![one],
            ..Datasets::from(&volume)
        };
        let [without, with] = [&without, &with].map(|plan| draw(data.clone(), plan));
        assert!(without.image.pixels() == with.image.pixels(), "{method}");
    }
}

#[test]
fn what_does_not_go_together_is_refused_by_name() {
    let (volume, labels) = anatomy();
    let header = LabelHeader::from(&labels);
    for (text, expected) in [
        (
            r#"{ "segments": [{ "of": 1, "technique": "solit" }] }"#,
            r#"segments[0].technique is "solit"; allowed: solid, scene; did you mean "solid"?"#,
        ),
        (
            r#"{ "segments": [{ "of": 1, "opacity": 2 }] }"#,
            "segments[0].opacity is 2; allowed: 0 to 1",
        ),
        (
            r#"{ "techniques": { "t": { "method": "back-to-front" } }, "segments": [{ "of": 1, "technique": "t" }] }"#,
            r#"techniques.t.method is "back-to-front", which makes no sample of a run"#,
        ),
        (
            r#"{ "techniques": { "t": { "blend": 1.5, "method": "mida" } }, "segments": [{ "of": 1, "technique": "t" }] }"#,
            "techniques.t.blend is 1.5",
        ),
        (
            r#"{ "techniques": { "t": { "functions": { "gradient": { "module": "sobel" } } } }, "segments": [{ "of": 1, "technique": "t" }] }"#,
            "techniques.t.functions.gradient is given for a technique; allowed: classify",
        ),
        (
            r##"{ "techniques": { "t": { "gradient_of": "segment", "transfer_function": { "points": [[0, 0.5, "#fff"]] },
                "functions": { "classify": { "module": "gradient_table" } } } }, "segments": [{ "of": 1, "technique": "t" }] }"##,
            r#"techniques.t.gradient_of is "segment" with a transfer function that needs the gradient of the value"#,
        ),
        (
            r#"{ "sampling": { "rule": "refine" } }"#,
            r#"sampling is "refine" with segments of labels"#,
        ),
        (
            r#"{ "debug": "normal" }"#,
            "debug is set with segments of labels",
        ),
        (
            r#"{ "objects": [{ "like": "volume" }] }"#,
            "objects is volumes beside segments of labels",
        ),
    ] {
        let scene = Scene::parse("scene", text).unwrap();
        let problems = resolve(&scene, &volume.header(), Some(&header)).unwrap_err();
        assert!(
            problems.to_string().contains(expected),
            "{problems} instead of {expected}"
        );
    }
}

#[test]
fn a_technique_is_illustrated_for_the_camera_of_its_scene() {
    let (volume, labels) = anatomy();
    let header = LabelHeader::from(&labels);
    let planned = |params: &str, more: &str| {
        let text = format!(
            r#"{{ "camera": {{ "view": "left" }}, "techniques": {{ "t": {{ "functions": {{ "illustrate":
                {{ "module": "depth_cue", "params": {{ {params} }} }} }} }} }}, "segments": [{{ "of": 1, "technique": "t" }}] {more} }}"#
        );
        let scene = Scene::parse("scene", &text).unwrap();
        resolve(&scene, &volume.header(), Some(&header)).unwrap()
    };
    let depths = |plan: &Plan| {
        let cue = plan.techniques.iter().find_map(|t| match t.illustrate {
            Illustrate::DepthCue {
                nearest_mm,
                farthest_mm,
                ..
            } => Some([nearest_mm, farthest_mm]),
            _ => None,
        });
        cue.expect("a depth cue")
    };
    let plan = planned("", "");
    let [near, far] = depths(&plan);
    let corners = plan.field().grid.corners_mm();
    let of_corners = corners.map(|at| (at - plan.camera.eye_mm).dot(plan.camera.forward));
    let nearest = of_corners.into_iter().fold(f64::INFINITY, f64::min);
    let farthest = of_corners.into_iter().fold(0.0, f64::max);
    assert!(
        (f64::from(near) - nearest).abs() < 1e-3 * farthest,
        "{near}"
    );
    assert!((f64::from(far) - farthest).abs() < 1e-3 * farthest, "{far}");
    assert_eq!(depths(&planned(r#""nearest_mm": 5"#, "")), [5.0, far]);
}
