//! Times frames of the cases in `bench/cases.json`: an orbit about a scan of `../shared/data` (or of the
//! folder in `STRAHL_SHARED`), one line of JSON each.
//!
//!     cargo run --release -p strahl-cpu --example time_frames -- \
//!         [case=bonsai] [mode=unshaded|shaded|mip|first-hit] [frames=16] [threads=2] [step=1] \
//!         [size=512] [simd=avx512|avx2|portable] [skip=false] [tile=32] [raw=FILE]
//!
//! `raw` writes the last frame as little-endian f32 RGBA, linear light, row by row from the top.

use serde_json::{Value, json};
use std::path::PathBuf;
use std::time::Instant;
use strahl_cpu::{InstructionSet, Options, Renderer, no_progress};
use strahl_scene::{Scene, resolve};
use strahl_volume::read::{MemoryFiles, ReadOptions, read_file};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let argument = |name: &str| {
        let named = |a: &String| Some(a.strip_prefix(name)?.strip_prefix('=')?.to_owned());
        arguments.iter().find_map(named)
    };
    let number = |name: &str, default: f64| {
        argument(name).map_or(default, |text| text.parse().expect("a number"))
    };
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let shared =
        std::env::var_os("STRAHL_SHARED").map_or_else(|| folder.join("../shared"), PathBuf::from);
    let text = std::fs::read_to_string(folder.join("bench/cases.json")).expect("bench/cases.json");
    let spec: Value = serde_json::from_str(&text).expect("JSON");
    for (name, case) in spec["cases"].as_object().expect("cases") {
        if argument("case").is_some_and(|only| only != *name) {
            continue;
        }
        let file = case["file"].as_str().expect("a file name");
        let Ok(bytes) = std::fs::read(shared.join("data").join(file)) else {
            eprintln!("skipped: {file} is not there");
            continue;
        };
        let files = MemoryFiles::from([(file.to_owned(), bytes)]);
        let volume = read_file(file, &files, &ReadOptions::default())
            .expect("a volume")
            .volume;
        for mode in ["unshaded", "shaded", "mip", "first-hit"] {
            if argument("mode").is_some_and(|only| only != mode) {
                continue;
            }
            let frames = number("frames", 16.0) as u32;
            let plan = |frame: u32| {
                let turned = 360.0 * f64::from(frame) / f64::from(frames);
                let size = number("size", 512.0) as u32;
                let scene = scene(&spec, case, mode, turned, number("step", 1.0), size);
                let scene = Scene::parse("scene", &scene.to_string()).expect("a scene");
                resolve(&scene, &volume.header(), None).expect("a plan")
            };
            let simd = argument("simd")
                .map(|name| InstructionSet::from_name(&name).expect("avx512, avx2 or portable"));
            let options = Options {
                threads: 0,
                tile: number("tile", 32.0) as u32,
                skip: argument("skip").as_deref() != Some("false"),
                instructions: simd,
            };
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(number("threads", 0.0) as usize)
                .build()
                .expect("threads");
            let line = pool.install(|| {
                let start = Instant::now();
                let renderer = Renderer::new(&volume);
                let draw = |frame: u32| {
                    let plan = plan(frame);
                    let start = Instant::now();
                    let drawn = renderer.render(&plan, &options, &no_progress);
                    (start.elapsed().as_secs_f64(), drawn.expect("a picture"))
                };
                let (_, mut drawn) = draw(0);
                let first = start.elapsed().as_secs_f64();
                let mut seconds = Vec::new();
                for frame in 1..=frames {
                    let (taken, picture) = draw(frame);
                    seconds.push(taken);
                    drawn = picture;
                }
                if let Some(path) = argument("raw") {
                    let pixels = drawn.image.pixels();
                    let bytes: Vec<u8> = pixels
                        .iter()
                        .flatten()
                        .flat_map(|c| c.to_le_bytes())
                        .collect();
                    std::fs::write(path, bytes).expect("the file can be written");
                }
                seconds.sort_by(f64::total_cmp);
                json!({
                    "case": name,
                    "mode": mode,
                    "threads": drawn.stats.threads,
                    "first_s": first,
                    "median_s": seconds[seconds.len() / 2],
                    "min_s": seconds[0],
                    "prepare_s": drawn.stats.prepare_seconds,
                    "bricks_s": drawn.stats.bricks_seconds,
                    "samples": drawn.stats.samples,
                    "visible": drawn.stats.samples_visible,
                    "points": drawn.stats.lattice_points,
                })
            });
            println!("{line}");
        }
    }
}

/// A frame of a case as a scene.
fn scene(spec: &Value, case: &Value, mode: &str, turned: f64, step: f64, size: u32) -> Value {
    let points: Vec<Value> = case["points"]
        .as_array()
        .expect("points")
        .iter()
        .map(|point| json!({ "value": point[0], "opacity": point[1], "color": point[2] }))
        .collect();
    let phong = &spec["phong"];
    let mut scene = json!({
        "transfer_function": { "points": points },
        "camera": {
            "view": "top",
            "view_angle_deg": spec["view_angle_deg"],
            "elevation_deg": spec["elevation_deg"],
            "azimuth_deg": spec["azimuth_deg"].as_f64().expect("degrees") + turned,
            "zoom": spec["zoom"],
        },
        "step_voxels": step,
        "size": [size, size],
        "shading": { "model": "unlit" },
        "background": "#000000",
        "jitter": "off",
    });
    match mode {
        "unshaded" => {}
        "mip" => scene["method"] = json!("mip"),
        "first-hit" => {
            scene["method"] = json!("first-hit");
            scene["threshold"] = case["first_hit"].clone();
        }
        _ => {}
    }
    if mode == "shaded" || mode == "first-hit" {
        scene["shading"] = json!({
            "model": "phong",
            "ambient": phong["ambient"],
            "diffuse": phong["diffuse"],
            "specular": phong["specular"],
            "shininess": phong["power"],
        });
    }
    scene
}
