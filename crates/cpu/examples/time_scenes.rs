//! Times scenes of phantoms that use what the cases of `time_frames` do not: several volumes, masks, clips,
//! cubic reconstruction, other composite rules. One line of JSON per scene.
//!
//!     cargo run --release -p strahl-cpu --example time_scenes -- \
//!         [scene=two-volumes] [frames=5] [threads=2] [size=256] [edge=128]
//!
//! `cargo xtask bench-scenes` builds this file in an older commit, too, and runs both in turns: it uses
//! only what was there then.

use std::time::Instant;
use strahl_cpu::{Options, Renderer};
use strahl_scene::{Headers, Scene, resolve_with};
use strahl_volume::{Datasets, Label, LabelIds, Metadata, Phantom, Rescale, Samples, Volume};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let argument = |name: &str| {
        let named = |a: &String| Some(a.strip_prefix(name)?.strip_prefix('=')?.to_owned());
        arguments.iter().find_map(named)
    };
    let number = |name: &str, default: usize| {
        argument(name).map_or(default, |text| text.parse().expect("a whole number"))
    };
    let edge = number("edge", 128);
    let phantom = |phantom: Phantom| {
        let dims = phantom.dims_for_edge(edge);
        phantom.volume(dims).expect("memory for a phantom")
    };
    let [tree, shells, anatomy] = [Phantom::Tree, Phantom::Shells, Phantom::Anatomy].map(phantom);
    let of_labels = mask_of_labels(anatomy.grid().dims(), &["mandible", "teeth", "vertebrae"]);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(number("threads", 2))
        .build()
        .expect("threads");
    for (name, is_of_tree, change) in SCENES {
        if argument("scene").is_some_and(|only| only != name) {
            continue;
        }
        let mut data = Datasets::from(if is_of_tree { &tree } else { &anatomy });
        match name {
            "two-volumes" => data.volumes.push((&shells).into()),
            "mask" | "mask-of-little" => data.masks.push((&shells).into()),
            "labels" => data.masks.push((&of_labels).into()),
            _ => {}
        }
        let draw = drawing(&data, change, number("size", 256));
        let mut seconds = Vec::new();
        let mut samples = 0;
        pool.install(|| {
            // The first picture also makes what is kept.
            draw();
            for _ in 0..number("frames", 5) {
                let start = Instant::now();
                samples = draw();
                seconds.push(start.elapsed().as_secs_f64());
            }
        });
        // Written by hand: the older commit has no JSON here.
        println!(r#"{{"scene":"{name}","seconds":{seconds:?},"samples":{samples}}}"#);
    }
}

/// A mask of the tissues of the anatomy with these names; as `LabelVolume::mask`, which the older commit does not have.
fn mask_of_labels(dims: [usize; 3], names: &[&str]) -> Volume {
    let labels = Phantom::Anatomy.labels(dims).expect("memory for labels");
    let labels = labels.expect("the anatomy has labels");
    let is_named = |label: &&Label| names.contains(&label.name.as_str());
    let inside: Vec<u32> = labels
        .labels()
        .iter()
        .filter(is_named)
        .map(|l| l.id)
        .collect();
    let LabelIds::U8(ids) = labels.ids() else {
        panic!("few tissues have small ids");
    };
    let samples = ids
        .iter()
        .map(|&id| u8::from(inside.contains(&id.into())))
        .collect();
    Volume::new(
        *labels.grid(),
        Samples::U8(samples),
        Rescale::IDENTITY,
        Metadata::default(),
    )
    .expect("a sample for each voxel")
}

/// Draws the scene with the keys in `change`; gives the number of samples.
fn drawing(data: &Datasets, change: &str, size: usize) -> impl Fn() -> u64 {
    let text = format!(r#"{{ "size": [{size}, {size}], {change} }}"#);
    let scene = Scene::parse("scene", &text).expect("a scene");
    let first: &Volume = &data.volumes[0];
    let headers = Headers {
        volumes: data.volumes.iter().map(|volume| volume.header()).collect(),
        masks: data.masks.iter().map(|mask| *mask.grid()).collect(),
        ..Headers::from(first.header())
    };
    let plan = resolve_with(&scene, &headers).expect("a plan");
    let renderer = Renderer::new(data.clone());
    move || {
        let drawn = renderer.render(&plan, &Options::default(), &strahl_volume::Control::NONE);
        drawn.expect("a picture").stats.counts.unwrap().samples
    }
}

/// Name, whether it shows the tree (the anatomy, if not), and what differs from the default scene.
const SCENES: [(&str, bool, &str); 21] = [
    ("default", false, ""),
    (
        "two-volumes",
        true,
        r#""objects": [{ "volume": { "phantom": "shells" }, "preset": "grey" }]"#,
    ),
    (
        "mask",
        true,
        r#""clips": [{ "mask": { "path": "shells", "threshold": 0.4 } }]"#,
    ),
    (
        "mask-of-little",
        false,
        r#""clips": [{ "mask": { "path": "shells", "threshold": 0.8 } }]"#,
    ),
    (
        "labels",
        false,
        r#""clips": [{ "mask": { "path": "labels" } }]"#,
    ),
    (
        "ball",
        false,
        r#""clips": [
            { "ellipsoid": { "min": [0.3, 0.2, 0.3], "max": [0.7, 0.6, 0.7], "space": "fraction" } },
        ]"#,
    ),
    (
        "clips",
        false,
        r#""clips": [
            { "plane": { "normal": [0, -1, 0] } },
            { "box": { "min": [0.1, 0.1, 0.1], "max": [0.9, 0.9, 0.9], "space": "fraction" } },
            { "ellipsoid": {
                "min": [0.3, 0.2, 0.3], "max": [0.7, 0.6, 0.7], "space": "fraction", "keep": "outside"
            } },
        ]"#,
    ),
    ("nearest", false, r#""reconstruct": "nearest""#),
    ("b-spline", true, r#""reconstruct": "b-spline""#),
    (
        "b-spline-interpolating",
        true,
        r#""reconstruct": "b-spline-interpolating""#,
    ),
    ("catmull-rom", true, r#""reconstruct": "catmull-rom""#),
    (
        "central-9",
        true,
        r#""gradient": { "method": "central-9" }"#,
    ),
    ("sobel", true, r#""gradient": { "method": "sobel" }"#),
    (
        "gradient-table",
        false,
        r#""functions": { "classify": {
            "module": "gradient_table", "params": { "low_per_mm": 5, "high_per_mm": 60 }
        } }"#,
    ),
    (
        "pre-classified",
        true,
        r#""functions": { "classify": { "module": "pre_classified" } }"#,
    ),
    (
        "back-to-front",
        true,
        r#""functions": { "composite": { "module": "back_to_front" } }"#,
    ),
    ("mida", false, r#""method": "mida""#),
    ("average", false, r#""method": "average""#),
    ("minip", false, r#""method": "minip""#),
    ("gmip", false, r#""method": "gmip""#),
    ("jitter", false, r#""jitter": { "seed": 7 }, "frames": 4"#),
];
