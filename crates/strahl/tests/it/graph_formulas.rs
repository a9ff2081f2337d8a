//! Nodes of graphs against the formulas of their papers, on a volume whose gradient is known.

use crate::graph::example;
use strahl::glam::DVec3;
use strahl::volume::{Grid, Metadata, Rescale, Samples};
use strahl::{Backend, Image, Render, Scene, Volume, scene::linear_from_srgb};

/// Towards the eye of all scenes here.
const TO_EYE: DVec3 = DVec3::Y;
const OPACITY: f64 = 0.4;
/// Of the transfer function, as a screen shows it.
const COLOR: [f64; 3] = [0.8, 0.6, 0.2];

fn linear_color() -> DVec3 {
    DVec3::from_array(COLOR.map(linear_from_srgb))
}

fn volume(value: impl Fn(DVec3) -> f64) -> Volume {
    let grid = Grid::centered([40; 3], DVec3::ONE).unwrap();
    let mut samples = Vec::new();
    for i in 0..40 * 40 * 40 {
        let voxel = DVec3::from_array([i % 40, i / 40 % 40, i / 1600].map(f64::from));
        samples.push(value(grid.world_from_voxel().transform_point3(voxel)) as f32);
    }
    let samples = Samples::F32(samples);
    Volume::new(grid, samples, Rescale::IDENTITY, Metadata::default()).unwrap()
}

/// Rises by `per_mm` along `normal`.
fn ramp(normal: DVec3, per_mm: f64) -> Volume {
    volume(|place| per_mm * normal.dot(place))
}

/// A slab with one sample per ray, seen from the front: one look for all values.
fn slab() -> Scene {
    let text = r#"{
        "size": [9, 9], "background": "transparent", "step_mm": 1, "method": "emission-absorption",
        "camera": { "view": "front", "projection": "orthographic", "height_mm": 4 },
        "transfer_function": { "reference_mm": 1, "points": [
            [-10000, 0.4, [0.8, 0.6, 0.2]], [10000, 0.4, [0.8, 0.6, 0.2]]] },
        "clips": [
            { "plane": { "normal": [0, 1, 0], "distance_mm": -0.6 } },
            { "plane": { "normal": [0, -1, 0], "distance_mm": -0.6 } }]
    }"#;
    Scene::parse("slab", text).unwrap()
}

/// The slab, with the keys of `text` in it.
fn slab_with(text: &str) -> Scene {
    let scene = Scene::parse("keys", text).unwrap();
    Scene {
        graph: scene.graph,
        shading: scene.shading,
        objects: scene.objects,
        ..slab()
    }
}

fn drawn(volume: &Volume, scene: &Scene) -> Image {
    let render = Render::volume(volume).with(|own| *own = scene.clone());
    let picture = render.backend(Backend::Cpu).picture();
    picture.unwrap_or_else(|error| panic!("{error}")).image
}

/// Color, not premultiplied, and opacity in the middle of the picture.
fn seen(volume: &Volume, scene: &Scene) -> (DVec3, f64) {
    let [r, g, b, alpha] = drawn(volume, scene).pixel(4, 4).map(f64::from);
    (DVec3::new(r, g, b) / alpha, alpha)
}

#[track_caller]
fn near(found: (DVec3, f64), color: DVec3, opacity: f64) {
    assert!(
        found.0.distance(color) < 2e-4 && (found.1 - opacity).abs() < 2e-5,
        "{found:?} instead of {color} {opacity}"
    );
}

/// Directions that face the eye, from straight to slanted.
fn normals() -> [DVec3; 3] {
    [
        DVec3::Y,
        DVec3::new(0.5, 0.7, -0.3).normalize(),
        DVec3::new(-0.8, 0.2, 0.5).normalize(),
    ]
}

/// P. Rheingans and D. Ebert 2001, in the order of the example.
#[test]
fn boundaries_and_silhouettes_change_opacity_by_their_formulas() {
    let scene = Scene {
        graph: example("boundary-silhouette").graph,
        ..slab_with(r#"{ "shading": { "ambient": 1, "diffuse": 0, "specular": 0 } }"#)
    };
    for normal in normals() {
        for per_mm in [20.0, 75.0, 140.0, 400.0] {
            let boundary = 0.05 + 1.0 * (per_mm / 150.0f64).min(1.0).powf(1.5);
            let silhouette = 0.1 + 1.4 * (1.0 - normal.dot(TO_EYE)).powi(2);
            let opacity = ((OPACITY * boundary).min(1.0) * silhouette).min(1.0);
            near(seen(&ramp(normal, per_mm), &scene), linear_color(), opacity);
        }
    }
}

/// A. Gooch et al. 1998. The edit replaces the stage of shading, whatever the settings make there.
#[test]
fn tone_is_its_formula_with_any_settings() {
    let to_light = DVec3::new(0.3, -0.6, 0.7).normalize();
    let (cool, warm) = (DVec3::new(0.05, 0.08, 0.35), DVec3::new(0.9, 0.6, 0.2));
    for shading in ["blinn-phong", "oren-nayar", "cel"] {
        let scene = Scene {
            graph: example("tone").graph,
            ..slab_with(&format!(r#"{{ "shading": {{ "model": "{shading}" }} }}"#))
        };
        for normal in normals() {
            let warmth = 0.5 * (1.0 + normal.dot(to_light));
            let own = linear_color() * (0.4 + 0.6 * warmth);
            let color = 0.5 * cool.lerp(warm, warmth) + 0.5 * own;
            near(seen(&ramp(normal, 10.0), &scene), color, OPACITY);
        }
    }
}

/// The first light takes the ambient share of the color, each adds its own.
#[test]
fn a_chain_of_lights_is_their_sum() {
    let scene = Scene {
        graph: example("three-lights").graph,
        ..slab()
    };
    let lights = [
        (DVec3::new(1.0, 0.6, 0.3), DVec3::new(0.9, 0.25, 0.2)),
        (DVec3::new(-1.0, 0.6, 0.3), DVec3::new(0.2, 0.8, 0.3)),
        (DVec3::new(0.0, 0.2, 1.0), DVec3::new(0.3, 0.4, 1.0)),
    ];
    for normal in normals() {
        let mut color = 0.15 * linear_color();
        for (to_light, radiance) in lights {
            let to_light = to_light.normalize();
            let half = (to_light + TO_EYE).normalize();
            let cosine = normal.dot(to_light);
            if cosine > 0.0 {
                let highlight = 0.2 * normal.dot(half).max(0.0).powi(32);
                color += radiance * (linear_color() * cosine + highlight);
            }
        }
        near(seen(&ramp(normal, 10.0), &scene), color, OPACITY);
    }
}

/// A row of the table per tag, which another object has; the value across.
#[test]
fn tags_choose_the_row_of_a_table() {
    let scene = Scene {
        graph: example("tags").graph,
        ..slab_with(
            r##"{ "objects": [{ "like": "volume", "transfer_function": {
                "points": [[0, 0, "#000"], [1, 0, "#000"]] } }] }"##,
        )
    };
    // Texels 1 and 2 of each row of the example.
    let rows = [
        ([0.2, 0.2, 0.25, 0.0], [0.6, 0.5, 0.4, 0.5]),
        ([0.9, 0.3, 0.2, 0.3], [0.9, 0.5, 0.4, 0.5]),
        ([0.2, 0.6, 0.2, 0.3], [0.5, 0.8, 0.3, 0.5]),
        ([0.1, 0.3, 0.8, 0.3], [0.4, 0.5, 0.9, 0.5]),
        ([0.8, 0.6, 0.1, 0.3], [0.9, 0.8, 0.3, 0.5]),
    ];
    for (tag, (left, right)) in rows.into_iter().enumerate() {
        let value = 0.25 * tag as f64;
        let part = (value + 900.0) / 1800.0 * 3.0 - 1.0;
        let [r, g, b, a] = [0, 1, 2, 3].map(|c| left[c] + part * (right[c] - left[c]));
        near(seen(&volume(|_| value), &scene), DVec3::new(r, g, b), a);
    }
}

/// S. Bruckner and E. Gröller 2007: the color of a sphere of the material where that faces the same way. The texels
/// rise evenly from left to right and from top to bottom.
#[test]
fn lit_spheres_have_the_color_of_their_normal() {
    let texels: Vec<_> = (0..16)
        .map(|i| {
            format!(
                "[{}, {}, 0.5, 1]",
                f64::from(i % 4) / 3.0,
                f64::from(i / 4) / 3.0
            )
        })
        .collect();
    let scene = slab_with(&format!(
        r#"{{ "graph": {{ "edits": [{{ "name": "sphere", "commands": [
            {{ "add": {{
                "sphere": {{ "texture": {{ "size": [4, 4], "texels": [{}] }} }},
                "facing": {{ "pattern": "camera_from_world", "inputs": {{ "way": "normal" }} }},
                "lit_sphere": {{ "pattern": "lit_sphere", "inputs": {{ "normal": "facing", "sphere": "sphere" }} }}
            }} }},
            {{ "insert": {{ "node": "lit_sphere", "input": "color", "into": "after_shade_color" }} }}
        ] }}] }} }}"#,
        texels.join(", ")
    ));
    for normal in normals() {
        // From the front, the patient's right is on the left.
        let place = [0.5 - 0.5 * normal.x, 0.5 - 0.5 * normal.z];
        let [r, g] = place.map(|share| (share * 4.0 - 0.5).clamp(0.0, 3.0) / 3.0);
        let color = DVec3::new(r, g, 0.5);
        near(seen(&ramp(normal, 10.0), &scene), color, OPACITY);
    }
}

/// G. Kindlmann et al. 2003: the contour of a sphere is as thick as it should be, whatever the radius.
#[test]
fn contours_are_as_thick_as_they_should_be() {
    let text = r##"{
        "size": [160, 160], "background": "#0000ff", "method": "first-hit", "threshold": 100,
        "reconstruct": "b-spline", "gradient": { "method": "b-spline" }, "step_mm": 0.5,
        "camera": { "view": "front", "projection": "orthographic", "height_mm": 32, "zoom": 1 },
        "shading": { "ambient": 1, "diffuse": 0, "specular": 0 },
        "transfer_function": { "points": [[0, 1, "#fff"], [200, 1, "#fff"]] }
    }"##;
    let scene = Scene {
        graph: example("contours").graph,
        ..Scene::parse("ball", text).unwrap()
    };
    let (pixel_mm, thickness_mm) = (32.0 / 160.0, 1.5);
    for radius_mm in [7.0f64, 10.0, 14.0] {
        let ball = volume(|place| 100.0 + radius_mm - place.length());
        let image = drawn(&ball, &scene);
        let count = |is: &dyn Fn([f32; 4]) -> bool| {
            image.pixels().iter().filter(|p| is(**p)).count() as f64 * pixel_mm * pixel_mm
        };
        let line = count(&|[r, g, b, _]| r + g + b < 0.1);
        let white = count(&|[r, ..]| r > 0.9);
        // Of a disk, all but the inner one is line.
        let outer_mm = ((line + white) / std::f64::consts::PI).sqrt();
        let inner_mm = (white / std::f64::consts::PI).sqrt();
        assert!((outer_mm - radius_mm).abs() < 0.15, "{outer_mm}");
        assert!(
            (outer_mm - inner_mm - thickness_mm).abs() < 0.15,
            "{radius_mm}: from {inner_mm} to {outer_mm}"
        );
    }
}

/// Functions of nodes have conditions, loops, and reads of a texture at a place that they compute.
#[test]
fn nodes_have_conditions_loops_and_dependent_reads() {
    let scene = slab_with(
        r#"{ "shading": { "model": "unlit" }, "graph": { "edits": [{ "name": "odd", "commands": [
            { "add": {
                "steps": { "texture": { "size": [4, 1], "texels": [
                    [0.1, 0, 0, 1], [0.2, 0, 0, 1], [0.4, 0, 0, 1], [0.8, 0, 0, 1]] } },
                "odd": { "wgsl": [
                    "fn odd(color: vec3f, value: f32, steps: texture_2d<f32>) -> vec3f {",
                    "    var sum = 0.0;",
                    "    for (var i = 0; i < 4; i += 1) {",
                    "        if f32(i) < value {",
                    "            sum += textureLoad(steps, vec2i(i, 0), 0).r;",
                    "        }",
                    "    }",
                    "    return vec3f(sum, color.yz);",
                    "}"
                ], "inputs": { "value": "after_sample", "steps": "steps" } }
            } },
            { "insert": { "node": "odd", "input": "color", "into": "after_shade_color" } }
        ] }] } }"#,
    );
    let sums = [0.0, 0.1, 0.3, 0.7, 1.5];
    for (value, sum) in sums.into_iter().enumerate() {
        let color = DVec3::new(sum, linear_color().y, linear_color().z);
        near(seen(&volume(|_| value as f64), &scene), color, OPACITY);
    }
}

/// What a setting says is a parameter of a node: set there, it is the picture of the setting.
#[test]
fn settings_are_parameters_of_nodes() {
    let set = |command: &str| {
        format!(
            r#""graph": {{ "edits": [{{ "name": "set", "commands": [{{ "set": {command} }}] }}] }}"#
        )
    };
    let volume = ramp(normals()[1], 10.0);
    let plain = drawn(&volume, &slab());
    for (shading, command) in [
        (r#""ambient": 0.9"#, r#"{ "lit.ambient": 0.9 }"#),
        (r#""ambient": 0"#, r#"{ "lit.ambient": 0 }"#),
    ] {
        let by_setting = slab_with(&format!(r#"{{ "shading": {{ {shading} }} }}"#));
        let by_node = slab_with(&format!("{{ {} }}", set(command)));
        let [setting, node] = [by_setting, by_node].map(|scene| drawn(&volume, &scene));
        let farthest = |a: &Image, b: &Image| {
            let pixels = a.pixels().iter().zip(b.pixels());
            let off = pixels.flat_map(|(a, b)| (0..4).map(|c| (a[c] - b[c]).abs()));
            off.fold(0.0, f32::max)
        };
        assert!(farthest(&setting, &node) < 1e-5, "{command}");
        assert!(farthest(&setting, &plain) > 0.01, "{command}");
    }
}
