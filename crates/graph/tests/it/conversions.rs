//! Meanings: what the numbers of a port are.

use crate::{assert_says, compile, compiled, refused, showing, standard_of};
use strahl_graph::{Kind, Node};

#[test]
fn meanings_have_to_be_the_same_and_the_pattern_is_named() {
    let nodes = r#""ray": { "pattern": "ray" },
        "s": { "slot": "reconstruct", "inputs": { "position": "ray.origin_mm" } }"#;
    assert_says(
        &refused(&showing(nodes, "s")),
        &[
            "nodes.s.inputs.position",
            "is position.world",
            "takes position.voxel",
            "`voxel_from_world`",
        ],
    );
}

#[test]
fn an_explicit_conversion_is_taken() {
    let nodes = r#""ray": { "pattern": "ray" },
        "p": { "pattern": "voxel_from_world", "inputs": { "place_mm": "ray.origin_mm" } },
        "s": { "slot": "reconstruct", "inputs": { "position": "p" } }"#;
    compiled(&showing(nodes, "s"));
}

#[test]
fn each_conversion_is_offered() {
    let cases = [
        (
            "normal_of_gradient",
            "gradient_here: gradient.per_mm",
            "vec3f",
            "direction.world",
        ),
        (
            "step_opacity",
            "opacity: opacity.reference",
            "f32",
            "opacity.step",
        ),
        (
            "premultiply",
            "color: color.linear",
            "vec3f",
            "color.premultiplied",
        ),
        (
            "unpremultiply",
            "color: color.premultiplied",
            "vec3f",
            "color.linear",
        ),
        (
            "texture_from_voxel",
            "position: position.voxel",
            "vec3f",
            "position.texture",
        ),
        (
            "distance",
            "lattice_point: lattice_point",
            "f32",
            "length.mm",
        ),
    ];
    for (pattern, from, ty, wanted) in cases {
        let from = from.split_once(": ").unwrap().1;
        let nodes = format!(
            r#""u": {{ "uniform": "{ty}", "value": {} }},
            "source": {{ "wgsl": "/// result: {from}\nfn from_it(a: {ty}) -> {ty} {{ return sin(a); }}", "inputs": {{ "a": "u" }} }},
            "to": {{ "wgsl": "/// a: {wanted}\nfn to_it(a: {ty}) -> f32 {{ return length(a); }}", "inputs": {{ "a": "source" }} }}"#,
            if ty == "f32" { "1" } else { "[1, 2, 3]" }
        );
        assert_says(
            &refused(&showing(&nodes, "to")),
            &[
                "nodes.to.inputs.a",
                &format!("is {from}"),
                &format!("takes {wanted}"),
                pattern,
            ],
        );
    }
}

#[test]
fn what_has_no_meaning_goes_anywhere() {
    let nodes = r#""u": { "uniform": "vec3f", "value": [1, 2, 3] },
        "s": { "slot": "reconstruct", "inputs": { "position": "u" } }"#;
    compiled(&showing(nodes, "s"));
}

#[test]
fn an_unknown_meaning_is_no_comment() {
    let nodes = r#""v": { "wgsl": "/// a: position.voxels\nfn v(a: vec3f) -> f32 { return a.x; }", "inputs": { "a": 1 } }"#;
    assert_says(
        &refused(&showing(nodes, "v")),
        &["nodes.v", "position.voxels", "position.voxel"],
    );
}

#[test]
fn light_without_a_gradient_is_warned_of() {
    let (_, mut graph, names) = standard_of("");
    assert!(names.contains_key("lit"));
    assert!(compile(&graph).unwrap().warnings.is_empty());
    // The normal is the way to the eye: no gradient.
    let lit = graph.node_mut("lit").unwrap();
    let (_, input) = lit
        .inputs
        .iter_mut()
        .find(|(name, _)| name == "normal")
        .unwrap();
    *input = "ray.to_eye".into();
    let warnings = compile(&graph).unwrap().warnings;
    let lights = warnings
        .iter()
        .find(|w| w.place == "nodes.lit.inputs.normal")
        .unwrap();
    assert_says(&lights.why, &["no gradient makes", "`normal_of_gradient`"]);
    // Own WGSL may know better.
    let own = Kind::Wgsl("fn up(way: vec3f) -> vec3f { return way.yxz; }".into());
    graph
        .nodes
        .push(Node::new("up", own).input("way", "ray.to_eye"));
    let lit = graph.node_mut("lit").unwrap();
    lit.inputs
        .iter_mut()
        .find(|(name, _)| name == "normal")
        .unwrap()
        .1 = "up".into();
    let warnings = compile(&graph).unwrap().warnings;
    assert!(
        !warnings.iter().any(|w| w.place.starts_with("nodes.lit")),
        "{warnings:?}"
    );
}

#[test]
fn a_gradient_that_a_loop_carries_is_one() {
    let (plan, graph, names) = standard_of(r#", "shading": { "keep_last_normal": true }"#);
    assert!(names.contains_key("normals"), "{names:?}");
    let warnings = crate::compile_over(&plan, &graph).unwrap().warnings;
    assert!(warnings.is_empty(), "{warnings:?}");
}
