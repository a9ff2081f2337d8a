//! Times frames of the cases in `bench/cases.json`: an orbit about a scan of `../shared/data` (or of the
//! folder in `STRAHL_SHARED`), one line of JSON each.
//!
//!     cargo run --release -p strahl-cpu --example time_frames -- \
//!         [case=bonsai] [mode=unshaded|shaded|mip|mip-values|first-hit|minip|average] [edit=true] [frames=16] [threads=2] \
//!         [step=1] [size=512] [compositing=linear|display] [simd=avx512|avx2|portable] [skip=false] [tile=32] \
//!         [raw=FILE] [sampling='{ "error": 0.01 }'] [stages=true] [points=JSON] \
//!         [reconstruct=b-spline]
//!
//! `mip-values` colors the largest value of a ray black to white over 0 to 255: a picture of values.
//! `sampling` is that key of a scene; `stages` draws every picture in stages and adds the medians of the times after
//! which each was there; `points` are other points of the transfer function, as in `bench/cases.json`.
//! `edit` keeps the view and changes the transfer function instead, to one that was not seen before, each time.
//! Seconds of a frame are those of resolving the scene and drawing the Plan; `first_s` begins with the decoded
//! volume in memory. `raw` writes the last frame as little-endian f32 RGBA, linear light, row by row from the top.

use serde_json::{Value, json};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;
use strahl_cpu::{InstructionSet, Options, Rendered, Renderer};
use strahl_scene::{Scene, resolve};
use strahl_volume::Control;
use strahl_volume::Volume;
use strahl_volume::read::{MemoryFiles, ReadOptions, read_file};

/// Those that are timed if none is named.
const MODES: [&str; 4] = ["unshaded", "shaded", "mip", "first-hit"];

fn main() {
    let arguments = Arguments(std::env::args().skip(1).collect());
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let shared =
        std::env::var_os("STRAHL_SHARED").map_or_else(|| folder.join("../shared"), PathBuf::from);
    let text = std::fs::read_to_string(folder.join("bench/cases.json")).expect("bench/cases.json");
    let spec: Value = serde_json::from_str(&text).expect("JSON");
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(arguments.number("threads", 0.0) as usize)
        .build()
        .expect("threads");
    for (name, case) in spec["cases"].as_object().expect("cases") {
        if arguments.excludes("case", name) {
            continue;
        }
        let Some(volume) = volume(&shared, case["file"].as_str().expect("a file name")) else {
            continue;
        };
        let modes = arguments
            .text("mode")
            .map_or(MODES.to_vec(), |mode| vec![mode]);
        for mode in modes {
            let mut line = pool.install(|| time(&arguments, &spec, case, &volume, mode));
            line["case"] = json!(name);
            println!("{line}");
        }
    }
}

/// `name=value` of the command line.
struct Arguments(Vec<String>);

impl Arguments {
    fn text(&self, name: &str) -> Option<&str> {
        let mut values = self
            .0
            .iter()
            .map(|a| a.strip_prefix(name)?.strip_prefix('='));
        values.find_map(|value| value)
    }

    fn number(&self, name: &str, default: f64) -> f64 {
        self.text(name)
            .map_or(default, |text| text.parse().expect("a number"))
    }

    fn excludes(&self, name: &str, value: &str) -> bool {
        self.text(name).is_some_and(|only| only != value)
    }
}

fn volume(shared: &Path, file: &str) -> Option<Volume> {
    let Ok(bytes) = std::fs::read(shared.join("data").join(file)) else {
        eprintln!("skipped: {file} is not there");
        return None;
    };
    let files = MemoryFiles::from([(file.to_owned(), bytes)]);
    let read = read_file(file, &files, &ReadOptions::default());
    Some(read.expect("a volume").volume)
}

/// Draws the orbit, or the edits, in the current thread pool.
fn time(arguments: &Arguments, spec: &Value, case: &Value, volume: &Volume, mode: &str) -> Value {
    let frames = arguments.number("frames", 16.0) as u32;
    let is_edit = arguments.text("edit") == Some("true");
    let simd = arguments
        .text("simd")
        .map(|name| InstructionSet::from_name(name).expect("avx512, avx2 or portable"));
    let options = Options {
        threads: 0,
        tile: arguments.number("tile", 32.0) as u32,
        skip: arguments.text("skip") != Some("false"),
        instructions: simd,
    };
    let scene = |frame: u32| {
        let share = f64::from(frame) / f64::from(frames);
        let scene = if is_edit {
            // Every point but the outer ones moves by up to 8 values.
            scene(spec, case, mode, 0.0, 8.0 * share, arguments)
        } else {
            scene(spec, case, mode, 360.0 * share, 0.0, arguments)
        };
        Scene::parse("scene", &scene.to_string()).expect("a scene")
    };
    let header = volume.header();
    let in_stages = arguments.text("stages") == Some("true");
    let mut stages: Vec<Vec<f64>> = Vec::new();
    let mut draw = |renderer: &Renderer, scene: &Scene| {
        let start = Instant::now();
        let plan = resolve(scene, &header, None).expect("a plan");
        let drawn = if in_stages {
            let mut times = Vec::new();
            let drawn = renderer.refine(&plan, &options, &Control::NONE, &mut |_, _| {
                times.push(start.elapsed().as_secs_f64());
                ControlFlow::Continue(())
            });
            stages.push(times);
            drawn
        } else {
            renderer.render(&plan, &options, &Control::NONE)
        };
        drawn.expect("a picture")
    };
    let first_scene = scene(0);
    let start = Instant::now();
    let renderer = Renderer::new(volume);
    let mut drawn = draw(&renderer, &first_scene);
    let first = start.elapsed().as_secs_f64();
    let bricks = drawn.stats.bricks_seconds;
    let (mut seconds, mut prepare) = (Vec::new(), Vec::new());
    for frame in 1..=frames {
        let scene = scene(frame);
        let start = Instant::now();
        drawn = draw(&renderer, &scene);
        seconds.push(start.elapsed().as_secs_f64());
        prepare.push(drawn.stats.prepare_seconds);
    }
    if let Some(path) = arguments.text("raw") {
        write_raw(&drawn, path);
    }
    let of_stage = |stage: usize| {
        let times: Vec<f64> = stages.iter().map(|times| times[stage]).collect();
        median(&times)
    };
    let stages: Vec<f64> = (0..stages.first().map_or(0, Vec::len))
        .map(of_stage)
        .collect();
    json!({
        "renderer": "Strahl",
        "mode": mode,
        "edit": is_edit,
        "threads": drawn.stats.threads,
        "first_s": first,
        "median_s": median(&seconds),
        "min_s": seconds.iter().copied().fold(f64::INFINITY, f64::min),
        "seconds": seconds,
        "prepare_s": median(&prepare),
        "bricks_s": bricks,
        "samples": drawn.stats.counts.unwrap().samples,
        "visible": drawn.stats.counts.unwrap().samples_visible,
        "points": drawn.stats.counts.unwrap().lattice_points,
        "stages_s": stages,
    })
}

fn median(seconds: &[f64]) -> f64 {
    let mut sorted = seconds.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

fn write_raw(drawn: &Rendered, path: &str) {
    let pixels = drawn.image.pixels().iter().flatten();
    let bytes: Vec<u8> = pixels.flat_map(|c| c.to_le_bytes()).collect();
    std::fs::write(path, bytes).expect("the file can be written");
}

/// A frame of a case as a scene: the camera `turned_deg` about the up axis, the inner points of the transfer
/// function moved `by` values.
fn scene(
    spec: &Value,
    case: &Value,
    mode: &str,
    turned_deg: f64,
    by: f64,
    arguments: &Arguments,
) -> Value {
    let number = |value: &Value| value.as_f64().expect("a number");
    let point = |value: f64, opacity: &Value, color: &Value| json!({ "value": value, "opacity": opacity, "color": color });
    let other: Option<Value> = arguments
        .text("points")
        .map(|points| serde_json::from_str(points).expect("JSON"));
    let points = other.as_ref().unwrap_or(&case["points"]);
    let points = points.as_array().expect("points");
    let points: Vec<Value> = if mode == "mip-values" {
        vec![
            point(0.0, &json!(1), &json!([0, 0, 0])),
            point(255.0, &json!(1), &json!([1, 1, 1])),
        ]
    } else {
        let inner = 1..points.len() - 1;
        let moved = |(i, p): (usize, &Value)| {
            let by = if inner.contains(&i) { by } else { 0.0 };
            point(number(&p[0]) + by, &p[1], &p[2])
        };
        points.iter().enumerate().map(moved).collect()
    };
    let size = arguments.number("size", number(&spec["size"][0])) as u32;
    let phong = &spec["phong"];
    let mut scene = json!({
        "transfer_function": { "points": points },
        "camera": {
            "view": "top",
            "view_angle_deg": spec["view_angle_deg"],
            "elevation_deg": spec["elevation_deg"],
            "azimuth_deg": number(&spec["azimuth_deg"]) + turned_deg,
            "zoom": spec["zoom"],
        },
        "step_voxels": arguments.number("step", number(&spec["step_in_voxels"])),
        "compositing": arguments.text("compositing").unwrap_or("linear"),
        "size": [size, size],
        "shading": { "model": "unlit" },
        "background": "#000000",
        "jitter": "off",
    });
    if let Some(reconstruct) = arguments.text("reconstruct") {
        scene["reconstruct"] = json!(reconstruct);
    }
    if let Some(sampling) = arguments.text("sampling") {
        scene["sampling"] = serde_json::from_str(sampling).expect("JSON");
    }
    match mode {
        // Where VTK's mapper ends a ray, too.
        "unshaded" | "shaded" => scene["early_termination"] = json!(255.0 / 32767.0),
        "mip-values" => scene["method"] = json!("mip"),
        "mip" | "minip" | "average" => scene["method"] = json!(mode),
        "first-hit" => {
            scene["method"] = json!("first-hit");
            scene["threshold"] = case["first_hit"].clone();
        }
        _ => panic!("mode={mode}: unshaded, shaded, mip, mip-values, first-hit, minip or average"),
    }
    if mode == "shaded" || mode == "first-hit" {
        scene["shading"] = json!({
            "model": "phong",
            "ambient": phong["ambient"],
            "diffuse": phong["diffuse"],
            "specular": phong["specular"],
            "shininess": phong["power"],
        });
        // What VTK makes when nothing is said: one white light, from the camera along its axis.
        scene["lights"] = json!([
            { "type": "directional", "azimuth_deg": 0, "elevation_deg": 0, "intensity": 1 }
        ]);
    }
    scene
}
