//! The standard graph, its anchors, and stages in place of others.

use crate::{compile_over, march, standard_of};
use strahl_graph::{Edit, EditList, Patterns, Reference, Replacement, STAGES, edited};
use strahl_scene::Method;

#[test]
fn anchors_are_there_whatever_the_settings_are() {
    let of_method = |method: Method| format!(r#", "method": "{}""#, method.name());
    let unlit = r#", "shading": { "model": "unlit" }"#.to_owned();
    for settings in Method::ALL.map(of_method).into_iter().chain([unlit]) {
        let (_, _, names) = standard_of(&settings);
        let classifies = names.contains_key("classify");
        for (stage, parts) in STAGES {
            // A rule that shows how steep values are has no colors of samples.
            if !classifies && ["classify", "shade"].contains(&stage) {
                continue;
            }
            assert!(
                names.contains_key(&format!("before_{stage}")) || stage == "composite",
                "{settings}: before_{stage}"
            );
            match parts {
                [] => assert!(
                    names.contains_key(&format!("after_{stage}")),
                    "{settings}: after_{stage}"
                ),
                parts => assert!(
                    names.contains_key(&format!("after_{stage}_{}", parts[0])),
                    "{settings}: {stage}"
                ),
            }
        }
    }
}

#[test]
fn anchors_cost_nothing() {
    let (plan, graph, _) = standard_of("");
    let text = march(&compile_over(&plan, &graph).unwrap());
    assert!(
        !text.contains("before_") || !text.contains("let before_classify"),
        "{text}"
    );
    assert!(!text.contains("let after_"), "{text}");
}

#[test]
fn a_stage_is_replaced_by_constants_through_its_anchors() {
    let (plan, graph, _) = standard_of("");
    let by = Replacement::One(Reference::new("half"));
    let half = strahl_graph::Node::new(
        "half",
        strahl_graph::Kind::Wgsl(
            "fn half(v: f32) -> Surface { return Surface(vec3f(v), 0.5); }".into(),
        ),
    );
    let commands = vec![
        Edit::Add(vec![half.input("v", "before_classify")]),
        Edit::ReplaceStage {
            stage: "classify".into(),
            by,
        },
    ];
    let list = EditList {
        name: "mine".into(),
        commands,
    };
    let done = edited(graph, &[list], &Patterns::new()).unwrap();
    let text = march(&compile_over(&plan, &done.graph).unwrap());
    assert!(
        text.contains("node_half(") && !text.contains("classify("),
        "{text}"
    );
    // Nothing is known to be empty any more: the test for it is decided and gone.
    assert!(
        !text.contains("empty_points(") && !text.contains("is_seen"),
        "{text}"
    );
}
