//! Graphs that are drawn by slices, against the same samples along rays.

use super::graph::{agreement, drawn, examples, has_gpu};
use std::fs;
use strahl::{Backend, Image, Render, Scene, SceneFile};

const ORTHOGRAPHIC: &str =
    r#""projection": "orthographic", "azimuth_deg": 40, "elevation_deg": 12"#;
const PERSPECTIVE: &str = r#""azimuth_deg": -130, "elevation_deg": 25"#;

/// A scene over a small volume that is drawn by this graph.
fn scene(camera: &str, graph: &str) -> Scene {
    let text = format!(
        r##"{{ "volume": {{ "phantom": "anatomy", "dims": [32, 40, 50] }}, "preset": "ct-bone", "size": [72, 54],
            "step_voxels": 0.7, "background": "#203040", "camera": {{ {camera} }}, "graph": {graph} }}"##
    );
    Scene::parse("test", &text).unwrap_or_else(|error| panic!("{error}"))
}

/// The sample of the example, which both drivers use.
fn sample() -> String {
    fs::read_to_string(examples().join("nodes/lit-sample.graph.json")).unwrap()
}

/// By slices; the sample's color and opacity are `sample.color` and `sample.opacity`.
fn slices(slicing: &str, pixel: &str) -> String {
    format!(
        r#"{{ "slicing": {slicing}, "nodes": {{
            "slice": {{ "pattern": "slice" }},
            "sample": {{ "graph": {}, "inputs": {{
                "position": "slice.position", "to_eye": "slice.to_eye", "length_mm": "slice.length_mm" }} }},
            {pixel}
        }}, "roots": {{ "color": "pixel" }} }}"#,
        sample()
    )
}

const PREMULTIPLIED: &str = r#"
    "associated": { "pattern": "premultiply", "inputs": { "color": "sample.color", "opacity": "sample.opacity" } },
    "pixel": { "pattern": "pixel", "inputs": { "color": "associated", "opacity": "sample.opacity" } }"#;

/// Along rays, at the points where these meet the same planes.
fn rays() -> String {
    format!(
        r#"{{ "nodes": {{
            "ray": {{ "pattern": "ray" }},
            "extent": {{ "pattern": "extent", "inputs": {{ "origin_mm": "ray.origin_mm", "direction": "ray.direction" }} }},
            "step": {{ "pattern": "step_mm" }},
            "ahead": {{ "wgsl": "fn ahead(direction: vec3f) -> f32 {{ return -in_camera(direction).z; }}", "inputs": {{ "direction": "ray.direction" }} }},
            "plane": {{ "wgsl": ["/// interval_mm: length.mm", "/// step: length.mm", "fn plane(interval_mm: vec2f, step: f32, ahead: f32) -> f32 {{ return ceil(interval_mm.x * ahead / step); }}"],
                "inputs": {{ "interval_mm": "extent", "step": "step", "ahead": "ahead" }} }},
            "walk": {{ "loop": {{
                "carry": {{
                    "k": {{ "type": "f32", "start": "plane", "next": "onward" }},
                    "color": {{ "type": "vec3f", "start": 0, "next": "over.color" }},
                    "opacity": {{ "type": "f32", "start": 0, "next": "over.opacity" }}
                }},
                "while": "is_before_end"
            }} }},
            "onward": {{ "pattern": "add", "inputs": {{ "a": "walk.k", "b": 1 }} }},
            "at": {{ "wgsl": ["struct At {{", "/// length.mm", "distance_mm: f32,", "/// length.mm", "length_mm: f32 }}", "/// step: length.mm",
                "fn at(k: f32, step: f32, ahead: f32) -> At {{ return At(k * step * (1.0 / ahead), step * (1.0 / ahead)); }}"],
                "inputs": {{ "k": "walk.k", "step": "step", "ahead": "ahead" }} }},
            "is_before_end": {{ "pattern": "in_interval_mm", "inputs": {{ "distance_mm": "at.distance_mm", "interval_mm": "extent" }} }},
            "place": {{ "wgsl": ["/// origin_mm: position.world", "/// distance_mm: length.mm", "/// direction: direction.world", "/// result: position.world",
                "fn place(origin_mm: vec3f, distance_mm: f32, direction: vec3f) -> vec3f {{ return origin_mm + distance_mm * direction; }}"],
                "inputs": {{ "origin_mm": "ray.origin_mm", "distance_mm": "at.distance_mm", "direction": "ray.direction" }} }},
            "position": {{ "pattern": "voxel_from_world", "inputs": {{ "place_mm": "place" }} }},
            "sample": {{ "graph": {}, "inputs": {{ "position": "position", "to_eye": "ray.to_eye", "length_mm": "at.length_mm" }} }},
            "over": {{ "pattern": "over", "inputs": {{ "color": "sample.color", "opacity": "sample.opacity",
                "sum_color": "walk.color", "sum_opacity": "walk.opacity" }} }},
            "pixel": {{ "pattern": "pixel", "inputs": {{ "color": "walk.last.color", "opacity": "walk.last.opacity" }} }}
        }}, "roots": {{ "color": "pixel" }} }}"#,
        sample()
    )
}

/// The largest difference of any channel.
fn farthest(a: &Image, b: &Image) -> f32 {
    let pairs = a.pixels().iter().flatten().zip(b.pixels().iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

fn on_all(scene: &Scene) -> Vec<(&'static str, Image)> {
    let mut images = vec![("cpu", drawn(scene, Backend::Cpu))];
    if has_gpu() {
        images.push(("gpu", drawn(scene, Backend::Gpu { adapter: None })));
    }
    images
}

#[test]
fn slices_are_rays_at_the_same_planes() {
    for camera in [ORTHOGRAPHIC, PERSPECTIVE] {
        let along_rays = drawn(&scene(camera, &rays()), Backend::Cpu);
        let seen = along_rays.pixels().iter().filter(|p| p[0] > 0.2).count();
        assert!(seen > 300, "only {seen} pixels show anything");
        let by_slices = slices(r#"{ "blend": "front-to-back" }"#, PREMULTIPLIED);
        for (backend, image) in on_all(&scene(camera, &by_slices)) {
            let (psnr, far) = agreement(&along_rays, &image);
            let most = farthest(&along_rays, &image);
            println!("{backend}: {psnr:.1} dB, {far:.5} far, at most {most}");
            match backend {
                "cpu" => assert!(most < 1e-4, "{most}"),
                // Its texture unit interpolates with coarser weights.
                _ => assert!(psnr > 50.0 && far <= 0.002, "{psnr:.1} dB, {far}"),
            }
        }
    }
}

#[test]
fn both_orders_and_blends_are_one_picture() {
    let forth = slices(r#"{ "blend": "front-to-back" }"#, PREMULTIPLIED);
    let forth = on_all(&scene(PERSPECTIVE, &forth));
    let associated = slices(r#"{ "blend": "back-to-front" }"#, PREMULTIPLIED);
    // Colors that are not multiplied by their opacity: the blend does that.
    let unassociated = slices(
        r#"{ "order": "back-to-front", "blend": {
            "color": { "source": "source-opacity", "destination": "one-minus-source-opacity" },
            "opacity": { "destination": "one-minus-source-opacity" } } }"#,
        r#""pixel": { "wgsl": "fn plain(color: vec3f, opacity: f32) -> vec4f { return vec4f(color, opacity); }",
            "inputs": { "color": "sample.color", "opacity": "sample.opacity" } }"#,
    );
    for other in [associated, unassociated] {
        let other = on_all(&scene(PERSPECTIVE, &other));
        for ((backend, forth), (_, other)) in forth.iter().zip(&other) {
            let most = farthest(forth, other);
            println!("{backend}: at most {most}");
            assert!(most < 1e-5, "{backend}: {most}");
        }
    }
    // In the wrong order it is another picture: the test above can fail.
    let wrong = slices(
        r#"{ "order": "front-to-back", "blend": { "color": { "source": "source-opacity", "destination": "one-minus-source" } } }"#,
        PREMULTIPLIED,
    );
    let wrong = drawn(&scene(PERSPECTIVE, &wrong), Backend::Cpu);
    assert!(farthest(&forth[0].1, &wrong) > 0.1);
}

/// The largest value of all slices is that along the ray, and what is outside does not count as smallest.
#[test]
fn extremes_are_blended() {
    let of = |blend: &str| {
        let text = format!(
            r#"{{ "slicing": {{ "blend": "{blend}" }}, "nodes": {{
                "slice": {{ "pattern": "slice" }},
                "value": {{ "slot": "reconstruct", "inputs": {{ "position": "slice.position" }} }},
                "pixel": {{ "wgsl": "fn hot(value: f32) -> vec4f {{ return vec4f(vec3f(value / 4096.0 + 0.5), 1.0); }}", "inputs": {{ "value": "value" }} }}
            }}, "roots": {{ "color": "pixel" }} }}"#
        );
        on_all(&scene(ORTHOGRAPHIC, &text))
    };
    let (larger, smaller, mean) = (of("larger"), of("smaller"), of("add"));
    for (((backend, larger), (_, smaller)), (_, sum)) in larger.iter().zip(&smaller).zip(&mean) {
        let mut apart = 0;
        for ((l, s), sum) in larger
            .pixels()
            .iter()
            .zip(smaller.pixels())
            .zip(sum.pixels())
        {
            // Where no slice is inside, what was there at the start is there: nothing, and white.
            if l[0] < 0.2 {
                continue;
            }
            assert!(
                s[0] <= l[0] && l[0] <= sum[0] + 1e-6,
                "{backend}: {s:?} {l:?} {sum:?}"
            );
            apart += usize::from(l[0] > s[0] + 0.1);
        }
        assert!(apart > 300, "{backend}: {apart}");
    }
    for images in [&larger, &smaller] {
        if let [(_, here), (_, there)] = &images[..] {
            let (psnr, far) = agreement(here, there);
            assert!(psnr > 45.0 && far <= 0.002, "{psnr:.1} dB, {far}");
        }
    }
}

/// The position is computed at the corners of the picture and interpolated: S3-58.
#[test]
fn positions_may_come_from_the_vertices() {
    for camera in [ORTHOGRAPHIC, PERSPECTIVE] {
        let by_pixel = slices(r#"{ "blend": "front-to-back" }"#, PREMULTIPLIED);
        let by_pixel = drawn(&scene(camera, &by_pixel), Backend::Cpu);
        for how in ["perspective", "linear"] {
            let vertex = format!(
                r#"{PREMULTIPLIED},
                "corner": {{ "pattern": "corner", "stage": "vertex" }},
                "place": {{ "pattern": "voxel_from_world", "stage": "vertex", "interpolation": "{how}", "inputs": {{ "place_mm": "corner.place_mm" }} }}"#
            );
            let text = slices(r#"{ "blend": "front-to-back" }"#, &vertex)
                .replace(r#""position": "slice.position""#, r#""position": "place""#);
            for (backend, image) in on_all(&scene(camera, &text)) {
                let (psnr, far) = agreement(&by_pixel, &image);
                println!(
                    "{how} {backend}: {psnr:.1} dB, {far:.5} far, at most {}",
                    farthest(&by_pixel, &image)
                );
                assert!(
                    psnr > 50.0 && far <= 0.002,
                    "{backend} {how}: {psnr:.1} dB, {far}"
                );
            }
        }
    }
}

/// Pictures are drawn in parts of 512 pixels; corners are those of the part.
#[test]
fn parts_of_a_picture_have_their_own_corners() {
    let vertex = format!(
        r#"{PREMULTIPLIED},
        "corner": {{ "pattern": "corner", "stage": "vertex" }},
        "place": {{ "pattern": "voxel_from_world", "stage": "vertex", "inputs": {{ "place_mm": "corner.place_mm" }} }}"#
    );
    let text = slices(r#"{ "blend": "back-to-front" }"#, &vertex)
        .replace(r#""position": "slice.position""#, r#""position": "place""#);
    let mut wide = scene(PERSPECTIVE, &text);
    (wide.size, wide.step_voxels) = (Some([530, 24]), Some(2.0));
    if let [(_, here), (_, there)] = &on_all(&wide)[..] {
        let (psnr, far) = agreement(here, there);
        assert!(psnr > 50.0 && far <= 0.002, "{psnr:.1} dB, {far}");
    }
}

/// Rays, too, may get their direction from the corners; what is flat is the first corner's everywhere.
#[test]
fn rays_may_come_from_the_vertices() {
    let graph = |direction: &str| {
        rays()
            .replace(
                r#""ray": { "pattern": "ray" },"#,
                &format!(
                    r#""ray": {{ "pattern": "ray" }},
                    "corner": {{ "pattern": "corner", "stage": "vertex", "interpolation": "{direction}" }},
                    "direction": {{ "wgsl": ["/// result: direction.world", "fn along(along: vec3f) -> vec3f {{ return normalize(along); }}"], "inputs": {{ "along": "corner.along" }} }},"#
                ),
            )
            .replace(r#""direction": "ray.direction""#, r#""direction": "direction""#)
    };
    let by_pixel = drawn(&scene(PERSPECTIVE, &rays()), Backend::Cpu);
    for (backend, image) in on_all(&scene(PERSPECTIVE, &graph("linear"))) {
        let (psnr, far) = agreement(&by_pixel, &image);
        assert!(
            psnr > 50.0 && far <= 0.002,
            "{backend}: {psnr:.1} dB, {far}"
        );
    }
    let flat = on_all(&scene(PERSPECTIVE, &graph("flat")));
    for (backend, image) in &flat {
        let first = image.pixels()[0];
        assert!(image.pixels().iter().all(|p| *p == first), "{backend}");
    }
}

#[test]
fn what_slices_cannot_do_is_said_before_anything_is_drawn() {
    let text = slices(r#"{ "blend": "front-to-back" }"#, PREMULTIPLIED);
    let one = scene(PERSPECTIVE, &text);
    let mut backends = vec![Backend::Cpu];
    if has_gpu() {
        backends.push(Backend::Gpu { adapter: None });
    }
    for backend in backends {
        let render = || Render::scene(one.clone()).backend(backend.clone());
        let error = render().with_depth().picture().unwrap_err().to_string();
        assert!(error.contains("slices have no depth"), "{error}");
        let thin = render().with(|scene| (scene.step_voxels, scene.step_mm) = (None, Some(0.0005)));
        let error = thin.picture().unwrap_err().to_string();
        assert!(error.contains("make the step larger"), "{error}");
    }
    let folder = tempfile::tempdir().unwrap();
    let mesh = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 9 0 0\nvertex 0 9 0\nendloop\nendfacet\nendsolid a\n";
    fs::write(folder.path().join("a.stl"), mesh).unwrap();
    let text = one
        .to_json()
        .replacen('{', r#"{ "objects": [{ "mesh": "a.stl" }],"#, 1);
    fs::write(folder.path().join("mesh.json"), text).unwrap();
    let scene = SceneFile::open(&folder.path().join("mesh.json"));
    let among_meshes = Render::scene(scene.unwrap().unwrap().scene);
    let error = among_meshes.picture().unwrap_err().to_string();
    assert!(
        error.contains("slices are not drawn among meshes"),
        "{error}"
    );
}

/// Slices of the second object are those of the object alone, and are cut to both extents.
#[test]
fn several_objects_have_slices() {
    let graph = |object: usize| {
        format!(
            r#"{{ "slicing": {{ "blend": "front-to-back" }}, "nodes": {{
                "slice": {{ "pattern": "slice", "object": {object} }},
                "value": {{ "slot": "reconstruct", "object": {object}, "inputs": {{ "position": "slice.position" }} }},
                "look": {{ "slot": "classify", "object": {object}, "inputs": {{ "value": "value", "position": "slice.position" }} }},
                "opacity": {{ "pattern": "length_opacity", "object": {object}, "inputs": {{ "opacity": "look.opacity", "length_mm": "slice.length_mm" }} }},
                "shown": {{ "pattern": "shown", "inputs": {{ "color": "look.color", "opacity": "opacity" }} }},
                "pixel": {{ "if": "slice.is_inside", "then": {{ "color": "shown" }}, "else": {{ "color": [0, 0, 0, 0] }} }}
            }}, "roots": {{ "color": "pixel.color" }} }}"#
        )
    };
    // What the camera takes in follows the objects if nothing is said.
    let camera =
        r#""position": [500, 300, 200], "focus": [0, 0, 0], "up": [0, 0, 1], "view_angle_deg": 30"#;
    let alone = on_all(&scene(camera, &graph(0)));
    let text = scene(camera, &graph(1)).to_json();
    let other = r#"{ "objects": [{ "volume": { "phantom": "anatomy", "dims": [32, 40, 50] }, "preset": "ct-bone" }],"#;
    let other = text.replacen('{', other, 1);
    let other = Scene::parse("two", &other).unwrap_or_else(|error| panic!("{error}"));
    for ((backend, alone), (_, second)) in alone.iter().zip(&on_all(&other)) {
        let most = farthest(alone, second);
        assert!(most < 1e-5, "{backend}: {most}");
        assert!(alone.pixels().iter().filter(|p| p[0] > 0.2).count() > 100);
    }
}
